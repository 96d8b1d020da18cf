//! The ground below scenes that have an up direction.

use glam::DVec3;
use motion::Elastic;
use pick::Shape;
use scene::{BodySpec, Scene, SpringSpec};

/// Least half width and half length of a floor, as multiples of its half height.
const FLOOR_FLATNESS: f64 = 4.0;
/// Least half width and half length of a floor, m: smaller slabs are boards.
const FLOOR_HALF_M: f64 = 5.0;

/// The ground and the up direction of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Ground {
    /// Whether the scene has an up direction: by gravity that is the same everywhere, or by a floor.
    pub has_up: bool,
    /// Height of the ground that is drawn, m: at the bottom of the scene's slabs or, without slabs, far enough below everything
    /// that nothing reaches it soon. `None` if a body is the floor, or if nothing falls.
    height: Option<f64>,
    /// Height of the top of the lowest slabs that are the floor, m: in the program's own look the ground is drawn in their place.
    pub floor_top: Option<f64>,
    /// Distance from line to line, m.
    spacing: f64,
}

/// Whether a shape can be a floor.
pub(super) fn is_flat(shape: &Shape) -> bool {
    let half = shape.half_extents();
    matches!(shape, Shape::Cuboid { .. })
        && half.x.min(half.z) >= (FLOOR_FLATNESS * half.y).max(FLOOR_HALF_M)
}

impl Ground {
    /// The ground as seen from `eye`, m, if that is above it; with `for_floor`, also in place of slabs that are the floor.
    #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
    pub fn seen_from(self, eye: DVec3, for_floor: bool) -> Option<render::Ground> {
        let spacing = self.spacing;
        let height_m = (self.height(for_floor)? - eye.y) as f32;
        let past = |at: f64| at.rem_euclid(spacing) as f32;
        let (spacing_m, offset_m) = (spacing as f32, [past(eye.x), past(eye.z)]);
        (height_m < 0.0).then_some(render::Ground { height_m, spacing_m, offset_m })
    }

    /// The height of the ground, m; with `for_floor`, also in place of slabs that are the floor.
    pub fn height(self, for_floor: bool) -> Option<f64> {
        self.floor_top.filter(|_| for_floor).or(self.height)
    }

    /// Whether the ground is drawn in place of an immovable box whose middle is at `height`, m.
    pub fn replaces(self, shape: &Shape, height: f64) -> bool {
        let is_top =
            |top: f64| (height + shape.half_extents().y - top).abs() <= 1e-4 * (1.0 + top.abs());
        self.floor_top.is_some_and(is_top) && is_flat(shape)
    }

    /// The ground of the `next` text of the scene: it stays where it is as long as everything is above it, and its lines as far
    /// apart as they are.
    pub fn changed_to(self, next: Self) -> Self {
        let stays = (self.has_up, self.floor_top, self.height.is_some())
            == (next.has_up, next.floor_top, next.height.is_some());
        let height = self.height.zip(next.height).map(|(now, next)| now.min(next));
        if stays { Self { height, ..self } } else { next }
    }

    pub fn of(scene: &Scene) -> Self {
        let is_floor =
            |body: &&BodySpec| !body.is_movable() && body.shape.as_ref().is_some_and(is_flat);
        let (floors, others): (Vec<&BodySpec>, Vec<&BodySpec>) =
            scene.bodies.iter().partition(is_floor);
        let half = |body: &BodySpec| body.shape.map_or(DVec3::ZERO, |shape| shape.half_extents());
        let low = |bodies: &[&BodySpec]| {
            bodies.iter().map(|body| body.position - half(body)).fold(DVec3::INFINITY, DVec3::min)
        };
        let swings = scene.springs.iter().filter_map(|spring| swing(scene, spring)).flatten();
        let lowest = swings.fold(low(&others), DVec3::min);
        let high = others
            .iter()
            .map(|body| body.position + half(body))
            .fold(DVec3::NEG_INFINITY, DVec3::max);
        let size = (high - lowest).max_element().max(1.0);
        // A slab in the air, above other bodies, stands on nothing.
        let stands = low(&floors).y <= low(&others).y;
        let are_scenery = floors.iter().all(|body| body.inverse_mass.is_none());
        let tops = floors.iter().map(|body| (body.position + half(body)).y);
        // The lowest: the ground would hide a floor below it.
        let floor_top = tops.reduce(f64::min).filter(|_| stands);
        let height = if floors.is_empty() {
            scene.gravity.is_some().then_some(lowest.y - size)
        } else {
            (stands && are_scenery).then(|| low(&floors).y)
        };
        let height = height.filter(|height| height.is_finite() && size.is_finite());
        Self {
            has_up: !floors.is_empty() || scene.gravity.is_some(),
            height,
            floor_top: floor_top.filter(|top| top.is_finite() && size.is_finite()),
            spacing: 10.0_f64.powf(size.log10().round()),
        }
    }
}

/// The ends of the swing of a body that hangs from an immovable one by a spring, m: as far to the other side as it begins, and down
/// to where the spring has taken up the energy of the fall and of its own compression.
pub(super) fn swing(scene: &Scene, spring: &SpringSpec) -> Option<[DVec3; 2]> {
    let [a, b] = spring.ends.map(|end| scene.bodies.get(end as usize));
    let (a, b) = a.zip(b)?;
    let (held, hung) = if a.is_movable() { (b, a) } else { (a, b) };
    let inverse_mass = hung.inverse_mass.filter(|_| !held.is_movable())?;
    let Elastic { stiffness, rest_length, pull_only, .. } = spring.elastic;
    let begins = hung.position - held.position;
    let fall =
        scene.gravity.filter(|gravity| gravity.on).map_or(DVec3::ZERO, |fall| fall.acceleration);
    let down = fall.try_normalize().or_else(|| begins.try_normalize())?;
    let drop = (rest_length - begins.dot(down)).max(0.0);
    let pushed = if pull_only { 0.0 } else { (rest_length - begins.length()).max(0.0) };
    let at_rest = fall.length() / (inverse_mass * stiffness);
    let stretch = at_rest + (at_rest * (at_rest + 2.0 * drop) + pushed * pushed).sqrt();
    let across = begins - down * begins.dot(down);
    let ends = [-across, down * (rest_length + stretch)].map(|by| held.position + by);
    Some(ends).filter(|ends| ends.iter().all(|end| end.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ground(name: &str) -> Ground {
        Ground::of(&scene::load(name).expect("a shipped scene"))
    }

    #[test]
    fn what_falls_has_a_ground_far_below_a_slab_stands_on_one_and_a_floor_has_no_other() {
        let Ground { has_up, height, .. } = ground("rope");
        // It swings its weight, of 0.6 m, down to 10 m below where it is held, 14 m high.
        assert!(has_up && height.is_some_and(|height| height < 3.4), "{height:?}");
        for (name, bottom) in
            [("tutorial", None), ("bridge", None), ("jelly", Some(0.0)), ("coast", Some(-2.0))]
        {
            let Ground { has_up, height, .. } = ground(name);
            assert!(has_up && height == bottom, "{name}: {height:?}");
        }
    }

    #[test]
    fn of_floors_at_two_heights_the_ground_hides_none() {
        let floor = |name: &str, y: f64| {
            format!(
                "(name: \"{name}\", shape: cuboid(half_extents_m: (20, 1, 20)), position_m: (0, {y}, 0), immovable: true)"
            )
        };
        let text =
            format!("(version: 1, bodies: [{}, {}])", floor("low", -1.0), floor("high", 4.0));
        let scene = Scene::parse("floors", &text).expect("a good scene");
        assert_eq!(Ground::of(&scene).floor_top, Some(0.0));
    }

    #[test]
    fn in_space_nothing_is_up() {
        for name in ["orbit", "orbits_race", "figure_eight", "ship", "third_law", "empty"] {
            assert!(matches!(ground(name), Ground { has_up: false, height: None, .. }), "{name}");
        }
    }
}
