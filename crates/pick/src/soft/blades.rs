//! Blades: chains that are drawn, and hit, as ribbons without thickness.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::SoftPose;

/// Turn from one blade to the next, radians: the golden angle repeats no direction.
const TURN: f32 = 2.399_963;

/// On a soft body: its points are drawn as blades, one after the other, which taper to their last point.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Blades {
    /// Points of a blade, at least 2.
    pub points: u32,
    /// Width at the first point, m.
    pub width: f64,
}

/// The surface of all blades of a soft body in a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BladeSurface {
    /// Two corners for each point, minus the anchor, m; both are at the point at the tip of a blade.
    pub corners: Vec<Vec3>,
    /// Its triangles, by indices of `corners`.
    pub triangles: Vec<[u32; 3]>,
}

impl Blades {
    /// Where a point is along its blade: 0 at the first point, 1 at the tip.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "few points")]
    pub fn share(&self, point: u32) -> f32 {
        let points = self.points.max(2);
        (point % points) as f32 / (points - 1) as f32
    }

    /// The number of the blade of a point.
    #[must_use]
    pub fn blade(&self, point: u32) -> u32 {
        point / self.points.max(2)
    }

    /// The surface of the blades in this pose; each faces a direction of its own. Between two points that are held, a blade is in
    /// the ground and has no surface.
    #[expect(clippy::cast_possible_truncation, reason = "what is drawn is f32")]
    pub(super) fn surface(&self, pose: &SoftPose) -> BladeSurface {
        let mut surface = BladeSurface::default();
        let mut side = Vec3::ZERO;
        for (number, point) in (0_u32..).zip(pose.points()) {
            let share = self.share(number);
            if share == 0.0 {
                let (sin, cos) = (TURN * f32::from(self.blade(number) as u16)).sin_cos();
                side = Vec3::new(cos, 0.0, sin) * (0.5 * self.width as f32);
            } else if pose.is_movable(number - 1) || pose.is_movable(number) {
                let at = 2 * number;
                surface.triangles.extend([[at - 2, at - 1, at], [at - 1, at + 1, at]]);
            }
            let aside = side * (1.0 - share.powi(2));
            surface.corners.extend([*point - aside, *point + aside]);
        }
        surface
    }
}
