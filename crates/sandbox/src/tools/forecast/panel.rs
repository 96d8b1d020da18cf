//! The panel of the forecast: how near everything is to instability, and what would help.

use egui::{Color32, Rect, RichText, Sense, Ui, Vec2};
use motion::margin::Fate;
use report::numbers::digits;

use crate::tools::forecast::ForecastRow;
use crate::tools::forecast::state::{growth, turns_in_words, wrong};
use crate::view::hud::as_in_picture;
use crate::view::inks;
use crate::view::springs::margin_color;

/// Most rows that are listed.
const MOST_ROWS: usize = 14;

pub(super) const WIDTH: f32 = 320.0;
const BAR_HEIGHT: f32 = 8.0;

/// The value of a full bar, as a multiple of the limit.
const FULL: f64 = 1.25;

/// The color of a cure.
const CURE: Color32 = Color32::from_rgb(255, 140, 90);

pub(super) fn show(ui: &mut Ui, rows: &[ForecastRow]) {
    ui.label(RichText::new(sentence(rows)).strong());
    if rows.is_empty() {
        return;
    }
    rows.iter().take(MOST_ROWS).for_each(|row| part(ui, row));
    if rows.len() > MOST_ROWS {
        ui.weak(format!("and {} more, all of them farther away", rows.len() - MOST_ROWS));
    }
}

/// The forecast in one sentence.
fn sentence(rows: &[ForecastRow]) -> String {
    let unstable = rows.iter().filter(|row| row.margin.is_unstable()).count();
    match (rows.first(), unstable) {
        (None, _) => {
            "nothing here can become unstable: no springs, damping, drag, wells or mutual gravity"
                .to_owned()
        }
        (Some(row), 0) if row.margin.may_be_unstable() || row.margin.fate != Fate::Holds => {
            format!("{}: {}", row.verdict(), row.element)
        }
        (Some(row), 0) if row.margin.limit.is_infinite() => {
            "stable: nothing here has a limit".to_owned()
        }
        (Some(row), 0) => {
            format!("stable: {:.0} % of the limit at {}", 100.0 * row.margin.ratio(), row.element)
        }
        (_, 1) => "unstable: one part grows".to_owned(),
        (_, many) => format!("unstable: {many} parts grow"),
    }
}

/// A row of the panel: the part of the scene, how much of its limit it uses, and its cure.
fn part(ui: &mut Ui, row: &ForecastRow) {
    let margin = &row.margin;
    ui.add_space(4.0);
    let limit = match margin.lasts.unwrap_or(margin.limit) {
        0.0 => "never stable".to_owned(),
        limit if limit.is_infinite() => "no limit".to_owned(),
        limit => format!("of {}", digits(limit)),
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(&row.element);
        ui.monospace(format!("{} {} {limit}", row.symbol(), row.value()));
    });
    let occasion = row.occasion();
    if !occasion.is_empty() {
        ui.weak(occasion.trim_start());
    }
    bar(ui, margin.ratio());
    let substeps =
        if margin.substeps > 1 { format!(" x {}", margin.substeps) } else { String::new() };
    let bodies = if margin.bodies == 1 { "body" } else { "bodies" };
    ui.weak(format!("{}{substeps}, {} {bodies}", margin.method.claims().title, margin.bodies));
    if !row.cure.is_empty() {
        let color = inks::words(ui.visuals(), CURE);
        ui.label(RichText::new(&row.cure).color(color).strong());
    }
    match margin.fate {
        Fate::Holds => {}
        Fate::Grows => _ = ui.weak(growth(margin.growth_per_s)),
        Fate::Drifts(turns) => _ = ui.weak(format!("leaves its orbit {}", turns_in_words(turns))),
        Fate::Wrong(deviation) => _ = ui.weak(wrong(deviation)),
    }
}

/// Draws how much of the limit is used; the mark is the limit.
#[expect(clippy::cast_possible_truncation, reason = "points")]
fn bar(ui: &mut Ui, ratio: f64) {
    let size = Vec2::new(ui.available_width(), BAR_HEIGHT);
    let (place, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(place, 2.0, ui.visuals().widgets.inactive.bg_fill);
    let at = |ratio: f64| place.left() + (ratio / FULL).clamp(0.0, 1.0) as f32 * place.width();
    let taken = Rect::from_min_max(place.min, egui::pos2(at(ratio), place.bottom()));
    painter.rect_filled(taken, 2.0, as_in_picture(margin_color(ratio)));
    painter.vline(at(1.0), place.y_range(), (1.5, ui.visuals().strong_text_color()));
}
