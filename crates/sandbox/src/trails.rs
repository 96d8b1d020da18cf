//! Where bodies have been: a line behind each, while trails are switched on.

use std::collections::{BTreeMap, VecDeque};

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Dormant, PhysicsBody, PreviousPosition, Transform};

/// How far back a trail goes, s of simulated time: a year of the orbits that are shipped.
const SECONDS: f64 = 6.0;

/// Points of all trails together, one a frame and body: many bodies leave short trails.
const POINTS: usize = 27_000;

/// Bodies that leave a trail, at most: lines are for looking at, not for a crowd.
const BODIES: usize = 300;

/// Where a body was drawn, m, and when, s.
type Point = (DVec3, f64);

/// The points that bodies passed, oldest first.
///
/// Ordered, because translucent lines blend in the order in which they are drawn.
#[derive(Default)]
pub(crate) struct Trails(BTreeMap<Entity, VecDeque<Point>>);

impl Trails {
    /// Notes where bodies are drawn at `time`, s, `alpha` of the way from their last position to the present one:
    /// a trail that ran ahead of its body would show long ticks.
    pub fn record(&mut self, world: &mut World, alpha: f64, time: f64) {
        // What is thrown out again leaves no line from where it was taken.
        for body in world.query_filtered::<Entity, With<Dormant>>().iter(world) {
            self.0.remove(&body);
        }
        let mut bodies = world
            .query_filtered::<(Entity, &Transform, &PhysicsBody, Option<&PreviousPosition>), Without<Dormant>>();
        let movable = bodies.iter(world).filter(|(_, _, body, _)| body.inverse_mass > 0.0).take(BODIES);
        let most = POINTS / movable.clone().count().max(1);
        for (body, Transform { position, .. }, _, before) in movable {
            let drawn = before.map_or(*position, |before| before.0 + (*position - before.0) * alpha);
            let trail = self.0.entry(body).or_default();
            // A body at rest keeps the way that brought it there.
            if trail.back().is_none_or(|(last, _)| *last != drawn) {
                trail.push_back((drawn, time));
                while trail.len() > most || trail.front().is_some_and(|(_, then)| time - then > SECONDS) {
                    trail.pop_front();
                }
            }
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = &VecDeque<Point>> {
        self.0.values()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world(bodies: usize) -> World {
        let mut world = World::new();
        world.spawn((Transform::at(DVec3::ZERO), PhysicsBody::IMMOVABLE));
        for _ in 0..bodies {
            let before = PreviousPosition(DVec3::ZERO);
            world.spawn((Transform::at(DVec3::X), PhysicsBody::with_mass(1.0), before));
        }
        world
    }

    /// The trails of bodies that move 1 m a frame along x, noted halfway between two ticks.
    fn drawn(bodies: usize, frames: u32, frame: f64) -> Trails {
        let (mut world, mut trails) = (world(bodies), Trails::default());
        for i in 0..frames {
            for (mut transform, mut before) in
                world.query::<(&mut Transform, &mut PreviousPosition)>().iter_mut(&mut world)
            {
                before.0 = transform.position;
                transform.position.x = f64::from(i);
            }
            trails.record(&mut world, 0.5, f64::from(i) * frame);
        }
        trails
    }

    #[test]
    fn a_trail_ends_where_its_body_is_drawn_and_goes_six_seconds_back() {
        for frame in [0.05, 0.25] {
            let trails = drawn(2, 200, frame);
            assert_eq!(trails.iter().count(), 2);
            for trail in trails.iter() {
                let ((first, then), (last, now)) = (trail[0], trail[trail.len() - 1]);
                assert_eq!(last, DVec3::X * 198.5);
                assert!(now - then <= SECONDS && now - then > SECONDS - 2.0 * frame);
                assert_eq!(
                    (last - first).x,
                    f64::from(u32::try_from(trail.len()).expect("some hundreds") - 1)
                );
            }
        }
    }

    #[test]
    fn many_bodies_leave_short_trails_and_no_more_than_the_first_any() {
        let trails = drawn(BODIES + 5, 200, 0.001);
        assert_eq!(trails.iter().count(), BODIES);
        assert!(trails.iter().all(|trail| trail.len() == POINTS / BODIES));
    }

    #[test]
    fn what_is_taken_back_leaves_no_trail() {
        let (mut world, mut trails) = (world(2), Trails::default());
        trails.record(&mut world, 1.0, 0.0);
        let taken = world.query_filtered::<Entity, With<PreviousPosition>>().iter(&world).last();
        world.entity_mut(taken.expect("two of them")).insert(Dormant);
        trails.record(&mut world, 1.0, 1.0);
        assert_eq!(trails.iter().count(), 1);
    }

    #[test]
    fn a_body_at_rest_keeps_its_trail() {
        let (mut world, mut trails) = (world(1), Trails::default());
        (0..9).for_each(|i| trails.record(&mut world, f64::from(i.min(4)) / 4.0, f64::from(i)));
        assert_eq!(trails.iter().next().map(VecDeque::len), Some(5));
    }
}
