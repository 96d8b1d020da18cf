//! Words beside bodies, under the panels.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Vec2};

use crate::view::hud::{SIZE, THIN, plate_size, point, text};
use crate::view::labels::Label;

/// Points between a body and its words.
const GAP: f32 = 5.0;

/// Largest distance of words from the middle of a body, points, so that those of a floor are near its middle.
const FARTHEST: f32 = 120.0;

/// How much farther aside words may be where something else is, points; a line then leads to the body.
const FARTHER: [f32; 6] = [0.0, 20.0, 45.0, 80.0, 130.0, 200.0];

/// Least and largest radius of the ring around a faulty body, points: large enough to be seen, and small enough to
/// look like a ring.
const RING: [f32; 2] = [14.0, 200.0];

/// The color of faults.
pub(crate) const FAULT: Color32 = Color32::from_rgb(255, 110, 90);

/// Draws labels where nothing is `taken`, the nearest first, if possible beside the bodies of the others, and leaves
/// out those without room. Adds their rectangles to `taken`.
pub(crate) fn show(painter: &Painter, labels: &[Label], taken: &mut Vec<Rect>) {
    let reach = |label: &Label| label_reach(painter, label).min(FARTHEST);
    let body = |label: &Label| {
        Rect::from_center_size(point(painter, label.at), Vec2::splat(2.0 * reach(label)))
    };
    for (i, label) in labels.iter().enumerate().rev() {
        let others = labels
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != i)
            .map(|(_, other)| body(other));
        let kept_free: Vec<_> = taken.iter().copied().chain(others).collect();
        let place = words(painter, label, reach(label), &kept_free, false);
        taken.extend(place.or_else(|| words(painter, label, reach(label), taken, false)));
    }
}

/// The color of what a lesson points at.
pub(crate) const POINTER: Color32 = Color32::from_rgb(255, 200, 60);

/// Draws a ring around a faulty body, with words beside it. Returns their rectangle.
pub(crate) fn show_mark(painter: &Painter, mark: &Label) -> Rect {
    // Can be seen on dark, on bright and on red.
    let radius = ring(painter, mark, &[(7.0, Color32::BLACK), (5.0, THIN), (2.5, FAULT)]);
    words(painter, mark, radius, &[], true).unwrap_or(Rect::NOTHING)
}

/// Draws a ring around a body in lines of those widths, points, and colors. Returns its radius, points.
pub(crate) fn ring(painter: &Painter, mark: &Label, lines: &[(f32, Color32)]) -> f32 {
    let radius = ring_radius(painter, mark);
    for (width, color) in lines {
        painter.circle_stroke(point(painter, mark.at), radius, Stroke::new(*width, *color));
    }
    radius
}

fn ring_radius(painter: &Painter, mark: &Label) -> f32 {
    (1.3 * label_reach(painter, mark)).clamp(RING[0], RING[1])
}

/// The rectangle of the ring around a body.
pub(crate) fn ring_place(painter: &Painter, mark: &Label) -> Rect {
    let size = Vec2::splat(2.0 * (ring_radius(painter, mark) + GAP));
    Rect::from_center_size(point(painter, mark.at), size)
}

#[expect(clippy::cast_possible_truncation, reason = "pixels")]
fn label_reach(painter: &Painter, label: &Label) -> f32 {
    label.reach as f32 / painter.ctx().pixels_per_point()
}

/// Writes the words of a label `reach` and a gap to the right of its body, or to the left, or lines below or above, where they
/// are in the picture and nothing is `taken`. Returns their rectangle. Words that are `needed` are always written.
fn words(
    painter: &Painter,
    label: &Label,
    reach: f32,
    taken: &[Rect],
    needed: bool,
) -> Option<Rect> {
    let (words, middle) = (&label.text, point(painter, label.at));
    let font = FontId::proportional(SIZE);
    let size = plate_size(painter, words, &font);
    let lines = [0.0, 1.1, -1.1, 2.2, -2.2].map(|lines| Vec2::Y * (lines * size.y));
    // To the sides only: words above a body seem to belong to whatever they end at.
    let mut places = FARTHER.into_iter().flat_map(|farther| {
        let aside = Vec2::X * (reach + GAP + farther);
        let sides = [(middle + aside, Align2::LEFT_CENTER), (middle - aside, Align2::RIGHT_CENTER)];
        lines.into_iter().flat_map(move |line| sides.map(|(at, side)| (at + line, side)))
    });
    let screen = painter.clip_rect();
    let is_free = |(at, side): &(Pos2, Align2)| {
        let place = side.anchor_size(*at, size);
        screen.contains_rect(place) && !taken.iter().any(|other| other.intersects(place))
    };
    let (at, side) = places.clone().find(is_free).or_else(|| places.next().filter(|_| needed))?;
    if (at.x - middle.x).abs() > reach + GAP + 1.0 {
        painter.line_segment([middle, at], Stroke::new(1.0, THIN));
    }
    Some(text(painter, at, side, words, font, THIN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_beside_the_bodies_of_others_as_long_as_there_is_room() {
        let label = |x: f64, reach: f64| Label {
            at: (x, 300.0).into(),
            reach,
            text: "a long label".to_owned(),
        };
        let written = |labels: &[Label]| {
            let (context, mut taken) = (egui::Context::default(), Vec::new());
            let screen = Rect::from_min_size(Pos2::ZERO, Vec2::new(800.0, 600.0));
            let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
            context
                .run_ui(input, |ui| show(ui.painter(), labels, &mut taken))
                .textures_delta
                .clear();
            taken
        };
        let [right, left] = written(&[label(300.0, 10.0), label(350.0, 10.0)])[..] else {
            panic!("two labels")
        };
        assert!(right.min.x > 360.0 && right.center().y == 300.0, "{right}");
        assert!(left.max.x < 290.0 && left.center().y == 300.0, "{left} is beside the other body");
        // Among bodies that fill the view there is no such place.
        assert_eq!(written(&[label(300.0, 110.0), label(420.0, 110.0)]).len(), 2);
    }
}
