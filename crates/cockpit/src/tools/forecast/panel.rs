//! The panel of the forecast: how near everything is to instability, and what would help.

use egui::{Color32, ProgressBar, Rect, RichText, Sense, Ui, Vec2};
use lab::trial::Verdict;
use motion::margin::Margin;
use report::numbers::digits;
use report::{ForecastRow, Instrument, growth, tried_in_words};

use crate::view::hud::as_in_picture;
use crate::view::inks;
use crate::view::springs::margin_color;
use crate::words::with_titles;

/// Most rows that are listed.
const MOST_ROWS: usize = 14;

pub(super) const WIDTH: f32 = 320.0;
const BAR_HEIGHT: f32 = 8.0;

/// The value of a full bar, as a multiple of the limit.
const FULL: f64 = 1.25;

/// The color of a cure.
const CURE: Color32 = Color32::from_rgb(255, 140, 90);

pub(super) fn show(ui: &mut Ui, rows: &[ForecastRow], progress: f64) {
    ui.label(RichText::new(sentence(rows)).strong());
    if progress < 1.0 && !rows.is_empty() {
        ui.add(ProgressBar::new(progress as f32).desired_height(BAR_HEIGHT));
        ui.weak("trying how the scene goes on");
    }
    rows.iter().take(MOST_ROWS).for_each(|row| part(ui, row));
    if rows.len() > MOST_ROWS {
        ui.weak(format!("and {} more, all of them farther away", rows.len() - MOST_ROWS));
    }
}

/// The forecast in one sentence.
fn sentence(rows: &[ForecastRow]) -> String {
    let faults: Vec<_> = rows.iter().filter(|row| row.is_fault() && !row.is_of_trial).collect();
    let shortest =
        rows.iter().filter_map(ForecastRow::tried).map(|tried| tried.seconds).reduce(f64::min);
    match (&faults[..], rows.first(), shortest) {
        (_, None, _) => {
            "nothing here can become unstable: no springs, damping, drag, wells or mutual gravity"
                .to_owned()
        }
        ([fault], ..) => format!("{}: {}", fault.verdict(), with_titles(&fault.element)),
        ([_, ..], ..) => format!("{} parts have a fault", faults.len()),
        ([], _, Some(seconds)) if seconds > 0.0 => format!("holds for {} s", digits(seconds)),
        ([], _, Some(_)) => "being tried".to_owned(),
        ([], Some(row), None) => format!("{}: {}", row.verdict(), with_titles(&row.element)),
    }
}

/// A row of the panel: the part of the scene, what was found, and its cure.
fn part(ui: &mut Ui, row: &ForecastRow) {
    ui.add_space(4.0);
    match &row.instrument {
        Instrument::Margin(margin) => of_margin(ui, row, margin),
        Instrument::Trial(tried) => {
            ui.horizontal_wrapped(|ui| {
                ui.label(with_titles(&row.element));
                ui.strong(row.verdict());
            });
            if tried.verdict != Verdict::Holds {
                ui.label(with_titles(&row.finding()));
            }
            ui.weak(format!("trial: {}", tried_in_words(tried)));
        }
    }
    if !row.cure_words.is_empty() {
        let color = inks::words(ui.visuals(), CURE);
        ui.label(RichText::new(with_titles(&row.cure_words)).color(color).strong());
    }
}

fn of_margin(ui: &mut Ui, row: &ForecastRow, margin: &Margin) {
    let how_near = match margin.limit {
        limit if limit > 0.0 && limit.is_finite() && !row.is_listed() => {
            format!("{:.0} % of its limit", 100.0 * margin.ratio())
        }
        f64::INFINITY => "no limit".to_owned(),
        0.0 if margin.is_unstable() => growth(margin.growth_per_s),
        0.0 => "grows at any step".to_owned(),
        _ => row.verdict().to_owned(),
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(with_titles(&row.element));
        ui.strong(how_near).on_hover_text(format!("{}, {}", row.value(), row.finding()));
    });
    // Without a limit nothing is near it.
    if margin.limit > 0.0 {
        bar(ui, margin.ratio());
    }
    let substeps =
        if margin.substeps > 1 { format!(" x {}", margin.substeps) } else { String::new() };
    let bodies = if margin.bodies == 1 { "body" } else { "bodies" };
    let linearized = if margin.is_linear { "" } else { ", linearized" };
    let title = margin.method.claims().title;
    ui.weak(format!("margin: {title}{substeps}, {} {bodies}{linearized}", margin.bodies));
    if margin.is_unstable() && margin.limit > 0.0 {
        ui.weak(growth(margin.growth_per_s));
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
