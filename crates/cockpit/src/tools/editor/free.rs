//! Computes how far an entry of the scene has to move until it overlaps no other.

use glam::DVec3;
use scene::{BodySpec, Entry, PointRadius, Scene, TextEdit as Change, rewrite};

use super::parts::rounded_to_multiple;

/// Gap between a moved entry and what was in its way, as a fraction of the size of the entry.
const ROOM: f64 = 0.1;

/// Overlap that counts as rounding, as a fraction of the size.
const ROUNDING: f64 = 1e-6;

/// The box around a body or a soft body, m.
#[derive(Clone, Copy)]
struct Bounds {
    least: DVec3,
    most: DVec3,
}

impl Bounds {
    fn of(body: &BodySpec) -> Self {
        let half = body.shape.map_or(DVec3::splat(PointRadius::default().0.into()), |shape| {
            if body.orientation.is_some() {
                DVec3::splat(shape.bounding_radius())
            } else {
                shape.half_extents()
            }
        });
        Self { least: body.position - half, most: body.position + half }
    }

    fn around(bodies: &[BodySpec]) -> Option<Self> {
        let both =
            |a: Self, b: Self| Self { least: a.least.min(b.least), most: a.most.max(b.most) };
        bodies.iter().map(Self::of).reduce(both)
    }

    /// The range of moves along `axis` after which it overlaps `other`, if there are any.
    fn blocked(&self, other: &Self, axis: DVec3) -> Option<[f64; 2]> {
        let slack = ROUNDING * (self.most - self.least).max_element();
        let (low, high) = (other.least - self.most + slack, other.most - self.least - slack);
        let across = |i: usize| axis[i] != 0.0 || (low[i] < 0.0 && high[i] > 0.0);
        let along = [low.dot(axis), high.dot(axis)];
        let along = [along[0].min(along[1]), along[0].max(along[1])];
        ((0..3).all(across) && along[0] < along[1]).then_some(along)
    }
}

/// The obstacles, and whether they can move: every body by itself, soft bodies as a whole, but no particles of emitters.
fn others(scene: &Scene, entry: &Entry) -> Vec<(Bounds, bool)> {
    let other = |other: Entry| {
        let bodies = &scene.bodies[other.bodies.start as usize..other.bodies.end as usize];
        let single = |body: &BodySpec| (Bounds::of(body), body.is_movable());
        match other.list {
            "emitters" => Vec::new(),
            "soft_bodies" => {
                Bounds::around(bodies).map(|bounds| (bounds, true)).into_iter().collect()
            }
            _ => bodies.iter().map(single).collect(),
        }
    };
    scene
        .entries()
        .into_iter()
        .filter(|other| other.path() != entry.path())
        .flat_map(other)
        .collect()
}

/// The shortest move along one of `axes` after which the entry at `path`, which `changes` add to the scene, overlaps nothing.
/// `keeps`: overlaps with immovable bodies that exist before the move stay, for example of a body that stands in a floor.
pub(crate) fn free_move(
    scene: &Scene,
    changes: &[Change],
    path: &str,
    axes: &[DVec3],
    keeps: bool,
) -> DVec3 {
    let with = rewrite(&scene.name, &scene.text, changes).and_then(|text| scene.reread(&text));
    let shortest = with.ok().and_then(|with| {
        let entry = with.entry_at(path)?;
        let own =
            Bounds::around(&with.bodies[entry.bodies.start as usize..entry.bodies.end as usize])?;
        let others = others(&with, &entry);
        let moves = axes.iter().map(|axis| *axis * along(&own, &others, *axis, keeps));
        moves.min_by(|a, b| a.length().total_cmp(&b.length()))
    });
    shortest.unwrap_or_default()
}

/// How far `own` has to move along `axis`, m.
fn along(own: &Bounds, others: &[(Bounds, bool)], axis: DVec3, keeps: bool) -> f64 {
    let room = ROOM * (own.most - own.least).max_element();
    let step = 10_f64.powf(room.log10().floor());
    let blocked = others.iter().filter_map(|(other, moves)| {
        let [from, to] = own.blocked(other, axis)?;
        let inside = from < 0.0 && to > 0.0;
        (*moves || !keeps || !inside).then_some([from, to + if *moves { room } else { 0.0 }])
    });
    let mut blocked: Vec<_> = blocked.collect();
    blocked.sort_by(|a, b| a[0].total_cmp(&b[0]));
    blocked.into_iter().fold(0.0, |by, [from, to]| {
        if from < by && by < to {
            rounded_to_multiple((to / step - ROUNDING).ceil() * step, step)
        } else {
            by
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(bodies: &str) -> Scene {
        Scene::parse("t", &format!("(version: 1, bodies: [{bodies}])")).expect("a scene")
    }

    #[test]
    fn what_is_added_moves_out_of_every_body_and_stands_on_a_floor() {
        let floor = "(shape: cuboid(half_extents_m: (50, 1, 50)), immovable: true)";
        let ball = "(shape: sphere(radius_m: 1), position_m: (0, 1.5, 0))";
        let added = [Change::add("bodies", ball)];
        let up = |scene: &Scene, path| free_move(scene, &added, path, &[DVec3::Y, DVec3::X], false);
        assert_eq!(up(&scene(floor), "bodies[1]"), DVec3::Y * 0.5);
        assert_eq!(up(&scene("(position_m: (0, 9, 0))"), "bodies[1]"), DVec3::ZERO);
        // On top of two that stand on each other, or beside them.
        let two = "(shape: sphere(radius_m: 1), position_m: (0, 1, 0)), (shape: sphere(radius_m: 1), position_m: (0, 3, 0))";
        assert_eq!(up(&scene(two), "bodies[2]"), DVec3::X * 2.2);
        assert_eq!(free_move(&scene(two), &added, "bodies[2]", &[DVec3::Y], false), DVec3::Y * 3.7);
        // What stood in a floor stays in it.
        let along = free_move(&scene(floor), &added, "bodies[1]", &[DVec3::X], true);
        assert_eq!(along, DVec3::ZERO);
    }
}
