//! Words beside bodies, under the panels.

use egui::{Align2, FontId, Painter, Pos2, Rect, Vec2};

use super::hud::{THIN, text};
use crate::session::Label;

const SIZE: f32 = 17.0;

/// Points between a body and its words.
const GAP: f32 = 5.0;

/// Farthest that words stand from the middle of a body, points: those of a floor belong to its middle.
const FARTHEST: f32 = 120.0;

/// Draws them; where they stand.
pub(super) fn show(painter: &Painter, labels: &[Label]) -> Vec<Rect> {
    let screen = painter.ctx().content_rect();
    let scale = painter.ctx().pixels_per_point();
    let mut places = Vec::new();
    for Label { at, reach, text: words } in labels {
        #[expect(clippy::cast_possible_truncation, reason = "pixels")]
        let (middle, reach) = (Pos2::new(at.x as f32, at.y as f32) / scale, *reach as f32 / scale);
        let font = FontId::proportional(SIZE);
        let size = painter.layout_no_wrap(words.clone(), font.clone(), THIN).size();
        let aside = Vec2::X * (reach.min(FARTHEST) + GAP);
        let right = middle + aside;
        let (at, side) = if right.x + size.x <= screen.right() {
            (right, Align2::LEFT_CENTER)
        } else {
            (middle - aside, Align2::RIGHT_CENTER)
        };
        text(painter, at, side, words, font, THIN);
        places.push(side.anchor_size(at, size));
    }
    places
}
