//! The ghosts panel, with the color, the distances and the visibility of each method, and the distance labels in the picture.

use egui::{
    Align2, Color32, FontId, Grid, Painter, Pos2, Rect, RichText, Stroke, TextStyle, Ui, Vec2,
};
use motion::Method;
use report::numbers::steady_length;
use report::{Ink, REFERENCE_INK, ink};

use crate::tools::ghosts::state::{GhostLabel, GhostRow, GhostState, Ghosts, Twins, subject};
use crate::tools::tool::Desk;
use crate::view::Mode;
use crate::view::hud::{SIZE, THIN, plate_size, point, swatch, text};
use crate::words::with_titles;

/// Radius of the dot before a label, points.
const DOT: f32 = 4.5;
/// Gap between the dot and the text, points.
const GAP: f32 = 5.0;
/// Distance of a label from its point, points.
const ASIDE: f32 = 24.0;
/// Vertical gap between two labels, points.
const BETWEEN: f32 = 1.0;
/// Width at which a long reason wraps, points.
const WIDTH: f32 = 300.0;
/// Width of the color and the checkbox before a name, points.
const BEFORE_NAME: f32 = 40.0;
/// Gap between two columns, points.
const COLUMNS: f32 = 10.0;

/// Headings of the columns of distances.
const HEADINGS: [&str; 3] = ["now", "at most", "rms of all"];

/// The level of detail of the table: the highest that fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Words {
    /// Names and three digits.
    Whole,
    /// In the dock: names and two digits.
    Docked,
    /// In a narrow dock: the short names of the picture.
    Short,
}

pub(super) fn show(ui: &mut Ui, ghosts: &mut Ghosts, desk: &Desk<'_>) {
    let (stage, docks) = (&*desk.stage, desk.dock_width.is_some());
    let rows = ghosts.rows(stage);
    let solid = stage.sim().method();
    let fits = |words, numbers| width(ui, &rows, words, numbers) <= ui.available_width();
    let (words, numbers) = match docks {
        false => (Words::Whole, 3),
        // Whole names come before the last column.
        true if fits(Words::Docked, 3) => (Words::Docked, 3),
        true if fits(Words::Docked, 2) => (Words::Docked, 2),
        true => (Words::Short, 2),
    };
    if desk.view.mode == Mode::Camera {
        // As in the reference picture.
        ui.weak("press Q to use the mouse here");
    }
    if docks {
        ui.weak(format!("Distance of {} from the reference", subject(stage)));
    }
    Grid::new("ghosts").num_columns(4).striped(true).spacing([COLUMNS, 2.0]).show(ui, |ui| {
        let [now, most, rms] = HEADINGS.map(str::to_owned);
        let now = if docks { now } else { subject(stage) };
        for heading in [String::new(), now, most, rms].into_iter().take(1 + numbers) {
            ui.weak(heading);
        }
        ui.end_row();
        for row in &rows {
            line(ui, row, (solid, ghosts.twins.as_mut()), (words, numbers));
            ui.end_row();
        }
    });
    ui.scope(|ui| {
        ui.set_max_width(WIDTH);
        for row in &rows {
            if let Some(why) = trouble(row) {
                let words = match why.split_once(" was quarantined at ") {
                    Some((body, when)) => {
                        let when = when.split(':').next().unwrap_or_default();
                        format!("{body} was thrown out at {when}")
                    }
                    None => with_titles(why),
                };
                let method = row.method.map_or("reference", |method| method.claims().title);
                ui.weak(format!("{method}: {words}")).on_hover_text(why);
            }
        }
    });
}

fn ink_of(row: &GhostRow, solid: Method) -> Ink {
    let method = row.method.or((row.state == GhostState::Mixed).then_some(solid));
    method.map_or(REFERENCE_INK, ink)
}

fn color([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

/// The reason why a ghost is not drawn, if any.
fn trouble(row: &GhostRow) -> Option<&str> {
    match &row.state {
        GhostState::Failed(why) => Some(why),
        GhostState::Unsolvable(why) => Some(why),
        GhostState::Solid | GhostState::Mixed | GhostState::Runs => None,
    }
}

/// The name of the row.
fn name(row: &GhostRow, words: Words) -> String {
    let short = |method| ink(method).short.to_owned();
    let name = match (row.method, &row.state, words) {
        (Some(method), _, Words::Short) => short(method),
        (Some(method), _, Words::Docked) => method.claims().title.replace("Runge-Kutta ", "RK"),
        (Some(method), ..) => method.claims().title.to_owned(),
        (None, GhostState::Mixed, _) => "solid bodies".to_owned(),
        (None, ..) => "reference".to_owned(),
    };
    let is_solid = row.state == GhostState::Solid && words == Words::Whole;
    if is_solid { format!("{name}, solid") } else { name }
}

/// The three distances of the row, as text.
fn distances(row: &GhostRow, words: Words) -> [String; 3] {
    let digits = if words == Words::Whole { 3 } else { 2 };
    let written = |distance: Option<f64>| {
        distance.map_or_else(String::new, |meters| steady_length(meters, digits))
    };
    let now = match &row.state {
        GhostState::Failed(_) => "failed".to_owned(),
        GhostState::Unsolvable(_) => "cannot".to_owned(),
        GhostState::Solid | GhostState::Mixed | GhostState::Runs => written(row.distance),
    };
    [now, written(row.largest), written(row.rms)]
}

/// Width of the table with this many columns of distances, points.
fn width(ui: &Ui, rows: &[GhostRow], words: Words, numbers: usize) -> f32 {
    let font = TextStyle::Body.resolve(ui.style());
    let of =
        |text: String| ui.painter().layout_no_wrap(text, font.clone(), Color32::WHITE).size().x;
    let names = rows.iter().map(|row| of(name(row, words))).fold(0.0, f32::max);
    // The minimum width of a grid column.
    let least = ui.spacing().interact_size.x;
    // Of the same width whatever is measured: a column that comes and goes could not be read.
    let column = |heading: &str| of("0.000 mm".to_owned()).max(of(heading.to_owned())).max(least);
    let numbers = HEADINGS.into_iter().take(numbers).map(|heading| COLUMNS + column(heading));
    BEFORE_NAME + names + numbers.sum::<f32>()
}

fn line(
    ui: &mut Ui,
    row: &GhostRow,
    (solid, twins): (Method, Option<&mut Twins>),
    (words, numbers): (Words, usize),
) {
    let there = trouble(row).is_none();
    ui.horizontal(|ui| {
        swatch(ui, color(ink_of(row, solid).srgb));
        let name = RichText::new(name(row, words));
        if row.state == GhostState::Mixed {
            ui.label(name.strong())
                .on_hover_text("several methods moved them since the ghosts began");
            return;
        }
        let mut shown = row.shown && there;
        let name = if row.state == GhostState::Solid { name.strong() } else { name };
        let mut box_ = ui.add_enabled(there, egui::Checkbox::new(&mut shown, name));
        let changed = box_.changed();
        if row.state == GhostState::Solid {
            box_ = box_.on_hover_text("the solid bodies: the method of the scene");
        }
        if let (Words::Short, Some(method)) = (words, row.method) {
            box_.on_hover_text(method.claims().title);
        }
        if let Some(twins) = twins.filter(|_| changed) {
            twins.show(row.method, shown);
        }
    });
    for (number, text) in distances(row, words).into_iter().enumerate().take(numbers) {
        match number {
            0 if !there => ui.weak(text),
            _ => ui.label(text),
        };
    }
}

/// The limits for labels in the picture.
struct Around {
    /// The panel, which would cover labels.
    panel: Rect,
    /// What labels have to stay in.
    screen: Rect,
}

/// Arranges labels, each with its point and its size. A label is above and to the right of its point, to the left if it would
/// leave the screen, beside the panel if that would cover it, and lower, or higher at the bottom, if it would overlap another label or
/// `taken`.
fn arranged(words: &[(Pos2, Vec2)], mut taken: Vec<Rect>, around: &Around) -> Vec<Rect> {
    let mut order: Vec<_> = (0..words.len()).collect();
    order.sort_by(|a, b| words[*a].0.y.total_cmp(&words[*b].0.y));
    let mut places = vec![Rect::NOTHING; words.len()];
    for i in order {
        let (at, size) = words[i];
        let fits = at.x + ASIDE + size.x <= around.screen.right();
        let left = if fits { at.x + ASIDE } else { at.x - ASIDE - size.x };
        let mut place = Rect::from_min_size(Pos2::new(left, at.y - ASIDE - size.y), size);
        if place.intersects(around.panel) {
            place = place.translate(Vec2::X * (around.panel.right() + ASIDE - place.left()));
        }
        let clear = |mut place: Rect, down: bool| {
            while let Some(other) = taken.iter().find(|other| other.intersects(place)) {
                let below = other.bottom() + BETWEEN - place.top();
                let above = other.top() - BETWEEN - place.bottom();
                place = place.translate(Vec2::Y * if down { below } else { above });
            }
            place
        };
        let lower = clear(place, true);
        let fits = lower.bottom() <= around.screen.bottom();
        place = if fits { lower } else { clear(place, false) };
        taken.push(place);
        places[i] = place;
    }
    places
}

/// Draws the distance labels beside their lines, clear of other words (`taken`) and of the panel.
pub(super) fn show_labels(
    painter: &Painter,
    labels: &[GhostLabel],
    taken: Vec<Rect>,
    panel: Option<Rect>,
) {
    let font = FontId::proportional(SIZE);
    let write = |label: &GhostLabel| {
        let words = format!("{} {}", label.ink.short, steady_length(label.distance, 3));
        let size = plate_size(painter, &words, &font);
        (words, (point(painter, label.at), size + Vec2::X * (2.0 * DOT + GAP)))
    };
    let (words, sizes): (Vec<_>, Vec<_>) = labels.iter().map(write).unzip();
    let around = Around { panel: panel.unwrap_or(Rect::NOTHING), screen: painter.clip_rect() };
    let places = arranged(&sizes, taken, &around);
    for (((label, words), (at, _)), place) in labels.iter().zip(words).zip(sizes).zip(places) {
        let ink = color(label.ink.srgb);
        let end = if place.left() > at.x { place.left_center() } else { place.right_center() };
        painter.line_segment([at, end], Stroke::new(1.0, ink));
        let dot = place.left_center() + Vec2::X * DOT;
        painter.circle(dot, DOT, ink, Stroke::new(1.0, Color32::from_black_alpha(200)));
        text(painter, dot + Vec2::X * (DOT + GAP), Align2::LEFT_CENTER, &words, font.clone(), THIN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_beside_their_places_and_not_on_anything_else() {
        let size = Vec2::new(90.0, 16.0);
        let panel = Rect::from_min_max(Pos2::ZERO, Pos2::new(200.0, 300.0));
        let screen = Rect::from_min_max(Pos2::ZERO, Pos2::new(640.0, 480.0));
        let around = Around { panel, screen };
        let label = Rect::from_min_size(Pos2::new(320.0, 165.0), Vec2::new(60.0, 20.0));
        let crowd: Vec<_> = (0..10_u8)
            .map(|i| (Pos2::new(300.0 + f32::from(i), 200.0 + 3.0 * f32::from(i % 4)), size))
            .collect();
        let places = arranged(&crowd, vec![label], &around);
        for (i, a) in places.iter().enumerate() {
            assert!(a.left() >= 300.0 + ASIDE && a.right() <= 640.0);
            assert!(
                !a.intersects(label) && places[..i].iter().all(|b| !a.intersects(*b)),
                "{places:?}"
            );
        }
        let alone = |at| arranged(&[(at, size)], Vec::new(), &around)[0];
        assert_eq!(
            alone(Pos2::new(600.0, 100.0)).right_bottom(),
            Pos2::new(600.0 - ASIDE, 100.0 - ASIDE)
        );
        let low = arranged(&[(Pos2::new(300.0, 470.0), size); 9], Vec::new(), &around);
        assert!(low.iter().all(|place| screen.contains_rect(*place)), "{low:?}");
        let beside = alone(Pos2::new(50.0, 100.0));
        assert!(!beside.intersects(around.panel) && (beside.bottom() + ASIDE - 100.0).abs() < 1e-3);
    }
}
