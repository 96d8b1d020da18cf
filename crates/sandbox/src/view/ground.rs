//! The ground below scenes in which something is up.

use glam::DVec3;
use pick::Shape;
use scene::Scene;

use crate::view::stage::Stage;

/// A floor is so many times as wide and as long as it is high, and no board.
const FLOOR_FLATNESS: f64 = 4.0;
const FLOOR_HALF_M: f64 = 5.0;

/// What a scene stands on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Ground {
    /// Whether something is up: gravity that is the same everywhere, or a floor.
    pub has_up: bool,
    /// Height of the ground that is drawn, m: far enough below everything that nothing reaches it soon. None where there is a
    /// floor, or nothing falls.
    height: Option<f64>,
    /// From line to line, m.
    spacing: f64,
}

impl Ground {
    pub fn of(scene: &Scene) -> Self {
        let is_floor = |half: DVec3| half.x.min(half.z) >= (FLOOR_FLATNESS * half.y).max(FLOOR_HALF_M);
        let has_floor = scene.bodies.iter().any(|body| {
            let still = body.inverse_mass.is_none_or(|inverse| inverse == 0.0);
            still && matches!(body.shape, Some(Shape::Cuboid { half_extents }) if is_floor(half_extents))
        });
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for body in &scene.bodies {
            let half = body.shape.map_or(DVec3::ZERO, |shape| shape.half_extents());
            (low, high) = (low.min(body.position - half), high.max(body.position + half));
        }
        let size = (high - low).max_element().max(1.0);
        let falls = scene.gravity.is_some() && size.is_finite();
        Self {
            has_up: has_floor || scene.gravity.is_some(),
            height: (falls && !has_floor).then_some(low.y - size),
            spacing: 10.0_f64.powf(size.log10().round()),
        }
    }
}

impl Stage {
    /// The ground as the camera sees it, if that is above it.
    #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
    pub(crate) fn ground(&self) -> Option<render::Ground> {
        let (Ground { height, spacing, .. }, eye) = (self.view.ground, self.view.camera.position);
        let height_m = (height? - eye.y) as f32;
        let past = |at: f64| at.rem_euclid(spacing) as f32;
        let (spacing_m, offset_m) = (spacing as f32, [past(eye.x), past(eye.z)]);
        (height_m < 0.0).then_some(render::Ground { height_m, spacing_m, offset_m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ground(name: &str) -> Ground {
        Ground::of(&scene::load(name).expect("a shipped scene"))
    }

    #[test]
    fn what_falls_has_a_ground_far_below_and_what_has_a_floor_has_no_other() {
        let Ground { has_up, height, .. } = ground("rope");
        // It swings its weight, of 0.6 m, down to 10 m below where it is held, 14 m high.
        assert!(has_up && height.is_some_and(|height| height < 3.4), "{height:?}");
        for name in ["tutorial", "jelly", "coast"] {
            assert!(matches!(ground(name), Ground { has_up: true, height: None, .. }), "{name}");
        }
    }

    #[test]
    fn in_space_nothing_is_up() {
        for name in ["orbit", "orbits_race", "figure_eight", "ship", "third_law", "empty"] {
            assert!(matches!(ground(name), Ground { has_up: false, height: None, .. }), "{name}");
        }
    }
}
