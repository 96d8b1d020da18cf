//! Line segments of a width in pixels, and the arrows built from them.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// How wide an arrow's head is, in widths of its shaft.
const HEAD_WIDTHS: f32 = 5.0;
/// How long an arrow's head is, as a share of its tip's distance from the camera: the head then has about the same
/// size on the screen everywhere, as the shaft's width has.
const HEAD_LENGTH: f32 = 0.026;

/// A straight segment drawn with a constant width on the screen. The layout is that of the vertex buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Line {
    /// One end, relative to the camera, m.
    pub start: [f32; 3],
    /// Width at the start, pixels.
    pub start_width_px: f32,
    /// The other end, relative to the camera, m.
    pub end: [f32; 3],
    /// Width at the end, pixels; 0 makes a point.
    pub end_width_px: f32,
    /// Red, green, blue as displayed and alpha at the start, 0 to 1.
    pub start_color: [f32; 4],
    /// Red, green, blue as displayed and alpha at the end, 0 to 1.
    pub end_color: [f32; 4],
}

impl Line {
    /// A segment of one color and one width.
    pub fn new(start: Vec3, end: Vec3, color: [f32; 4], width_px: f32) -> Self {
        Self {
            start: start.to_array(),
            start_width_px: width_px,
            end: end.to_array(),
            end_width_px: width_px,
            start_color: color,
            end_color: color,
        }
    }

    /// A shaft from `from` to `to` and a head that faces the camera, pushed onto `lines`. Nothing is pushed for an
    /// arrow without length; a short one is all head, at most as long as the arrow.
    pub fn arrow(lines: &mut Vec<Self>, from: Vec3, to: Vec3, color: [f32; 4], width_px: f32) {
        let along = to - from;
        let length = along.length();
        if !length.is_normal() {
            return;
        }
        let head_length = (HEAD_LENGTH * to.length()).min(length);
        let neck = to - along * (head_length / length);
        if head_length < length {
            lines.push(Self::new(from, neck, color, width_px));
        }
        let head_width_px = HEAD_WIDTHS * width_px;
        lines.push(Self {
            start_width_px: head_width_px,
            end_width_px: 0.0,
            ..Self::new(neck, to, color, 0.0)
        });
    }
}
