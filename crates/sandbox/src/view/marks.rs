//! Words beside bodies, under the panels.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Vec2};

use crate::view::hud::{THIN, text};
use crate::view::labels::Label;

const SIZE: f32 = 17.0;

/// Points between a body and its words.
const GAP: f32 = 5.0;

/// Farthest that words stand from the middle of a body, points: those of a floor belong to its middle.
const FARTHEST: f32 = 120.0;

/// Radius of the ring around a body that went wrong, points: never so small that it is not seen, and not larger than
/// that it is seen as a ring.
const RING: [f32; 2] = [14.0, 200.0];

/// The color of what went wrong.
pub(crate) const FAULT: Color32 = Color32::from_rgb(255, 110, 90);

/// Draws them; where they stand.
pub(crate) fn show(painter: &Painter, labels: &[Label]) -> Vec<Rect> {
    let mut taken = Vec::new();
    for label in labels {
        let place = words(painter, label, label_reach(painter, label).min(FARTHEST), &taken);
        taken.push(place);
    }
    taken
}

/// A ring around a body that went wrong, with words beside it; where they stand.
pub(crate) fn show_mark(painter: &Painter, mark: &Label) -> Rect {
    let radius = (1.3 * label_reach(painter, mark)).clamp(RING[0], RING[1]);
    // Seen on dark, on bright and on red.
    for (width, color) in [(7.0, Color32::BLACK), (5.0, THIN), (2.5, FAULT)] {
        painter.circle_stroke(middle(painter, mark), radius, Stroke::new(width, color));
    }
    words(painter, mark, radius, &[])
}

#[expect(clippy::cast_possible_truncation, reason = "pixels")]
fn middle(painter: &Painter, label: &Label) -> Pos2 {
    Pos2::new(label.at.x as f32, label.at.y as f32) / painter.ctx().pixels_per_point()
}

#[expect(clippy::cast_possible_truncation, reason = "pixels")]
fn label_reach(painter: &Painter, label: &Label) -> f32 {
    label.reach as f32 / painter.ctx().pixels_per_point()
}

/// The words of a label, `reach` and a gap to the right of its body, or to the left where they would not fit; a line or more
/// above or below where they would stand on what is `taken`.
fn words(painter: &Painter, label: &Label, reach: f32, taken: &[Rect]) -> Rect {
    let (words, middle) = (&label.text, middle(painter, label));
    let font = FontId::proportional(SIZE);
    let size = painter.layout_no_wrap(words.clone(), font.clone(), THIN).size();
    let aside = Vec2::X * (reach + GAP);
    let fits = middle.x + aside.x + size.x <= painter.clip_rect().right();
    let (at, side) =
        if fits { (middle + aside, Align2::LEFT_CENTER) } else { (middle - aside, Align2::RIGHT_CENTER) };
    let lines = [0.0, 1.0, -1.0, 2.0, -2.0].map(|lines| Vec2::Y * (lines * size.y));
    let free = |at: &Pos2| !taken.iter().any(|other| other.intersects(side.anchor_size(*at, size)));
    let at = lines.map(|aside| at + aside).into_iter().find(free).unwrap_or(at);
    text(painter, at, side, words, font, THIN);
    side.anchor_size(at, size)
}
