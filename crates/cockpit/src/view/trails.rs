//! Trails: a line behind each body, where it has been, while trails are switched on.

use std::collections::{BTreeMap, VecDeque};

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Dormant, PhysicsBody, PreviousPosition, Transform};

use crate::stage::query;

/// How far back a trail goes, s of watched time: a year of the orbits that are shipped.
const SECONDS: f64 = 6.0;

/// Greatest number of points of all trails together: those of many bodies are farther apart.
const POINTS: usize = 27_000;

/// Greatest number of bodies that leave a trail: lines are for looking at, not for a crowd.
pub(crate) const BODIES: usize = 300;

/// Place of a body at the end of a tick, m, and the time, s.
type Point = (DVec3, f64);

/// The points that a body passed, oldest first.
#[derive(Clone, Debug, Default)]
struct Trail {
    points: VecDeque<Point>,
    /// Place of the body at the end of the last tick, m.
    last: Option<DVec3>,
}

/// The trails of a world.
///
/// Ordered, because translucent lines blend in the order in which they are drawn.
#[derive(Default)]
pub(crate) struct Trails {
    trails: BTreeMap<Entity, Trail>,
    /// End of the last tick, s.
    time: Option<f64>,
    /// Number of movable bodies of the world, including those without a trail.
    movable: usize,
}

impl Trails {
    /// Records where bodies are at the end of a tick, at `time`, s; `pace` is simulated seconds per second of watching. Points
    /// are due by time, whatever the frames are.
    ///
    /// A body that was not at its [`PreviousPosition`] at the end of the last tick was put there, or is a particle of another
    /// life: its trail restarts there.
    pub fn after_tick(&mut self, world: &World, time: f64, pace: f64) {
        let longest = SECONDS * pace;
        for body in query::<Entity, With<Dormant>>(world).iter(world) {
            self.trails.remove(&body);
        }
        let mut bodies = query::<
            (Entity, &Transform, &PhysicsBody, Option<&PreviousPosition>),
            Without<Dormant>,
        >(world);
        let movable = bodies.iter(world).filter(|(_, _, body, _)| body.inverse_mass > 0.0);
        self.movable = movable.clone().count();
        #[expect(clippy::cast_precision_loss, reason = "at most hundreds")]
        let spacing = longest * self.movable.min(BODIES) as f64 / POINTS as f64;
        let before = self.time.replace(time);
        let is_due =
            before.is_none_or(|before| (time / spacing).floor() > (before / spacing).floor());
        for (body, Transform { position, .. }, _, previous) in movable.take(BODIES) {
            let trail = self.trails.entry(body).or_default();
            let began =
                previous.map(|previous| previous.0).filter(|began| trail.last != Some(*began));
            if let Some(began) = began {
                trail.points.clear();
                trail.points.push_back((began, before.unwrap_or(time)));
            }
            // A body at rest keeps its trail.
            if is_due && trail.last.replace(*position) != Some(*position) {
                trail.points.push_back((*position, time));
                while trail.points.front().is_some_and(|(_, then)| time - then > longest) {
                    trail.points.pop_front();
                }
            }
            trail.last = Some(*position);
        }
    }

    /// The number of bodies that leave a trail and of all that could, if there are more of these.
    pub fn left_out(&self) -> Option<(usize, usize)> {
        (self.movable > BODIES).then_some((BODIES, self.movable))
    }

    /// The bodies and the points that they passed up to `time`, s, so that no trail runs ahead of a body that is drawn between
    /// two ticks.
    pub fn until(
        &self,
        time: f64,
    ) -> impl Iterator<Item = (Entity, impl Iterator<Item = DVec3> + Clone)> {
        self.trails.iter().map(move |(body, trail)| {
            let passed = trail.points.iter().filter(move |(_, then)| *then <= time);
            (*body, passed.map(|(point, _)| *point))
        })
    }
}

#[cfg(test)]
mod tests {
    use motion::remember_positions;

    use super::*;
    use crate::stage::register_drawn;

    const TICK: f64 = 1.0 / 120.0;

    fn world(bodies: usize) -> World {
        let mut world = World::new();
        register_drawn(&mut world);
        world.spawn((Transform::at(DVec3::ZERO), PhysicsBody::IMMOVABLE));
        for _ in 0..bodies {
            let before = PreviousPosition(DVec3::ZERO);
            world.spawn((Transform::at(DVec3::ZERO), PhysicsBody::with_mass(1.0), before));
        }
        world
    }

    /// Moves every body 1 m along x, in tick number `tick`.
    fn tick(world: &mut World, trails: &mut Trails, tick: u32) {
        world.run_system_cached(remember_positions).expect("a query and nothing else");
        for mut transform in
            world.query_filtered::<&mut Transform, With<PreviousPosition>>().iter_mut(world)
        {
            transform.position.x += 1.0;
        }
        trails.after_tick(world, f64::from(tick) * TICK, 1.0);
    }

    fn points(trails: &Trails, time: f64) -> Vec<Vec<DVec3>> {
        trails.until(time).map(|(_, points)| points.collect()).collect()
    }

    #[test]
    fn a_trail_goes_six_seconds_back_and_ends_where_its_body_is_drawn() {
        let (mut world, mut trails) = (world(2), Trails::default());
        (1..=1000).for_each(|number| tick(&mut world, &mut trails, number));
        for trail in points(&trails, 1000.0 * TICK) {
            assert!(
                (280.0..=281.0).contains(&trail[0].x)
                    && trail[trail.len() - 1] == DVec3::X * 1000.0
            );
            assert!(trail.windows(2).all(|points| points[1] - points[0] == DVec3::X));
        }
        // Half a tick before the last one.
        assert_eq!(points(&trails, 999.5 * TICK)[0].last(), Some(&(DVec3::X * 999.0)));
    }

    #[test]
    fn many_bodies_leave_points_farther_apart_and_only_the_first_leave_any() {
        let (mut world, mut trails) = (world(BODIES + 5), Trails::default());
        (1..=1000).for_each(|number| tick(&mut world, &mut trails, number));
        let trails_drawn = points(&trails, 1000.0 * TICK);
        assert_eq!(trails_drawn.len(), BODIES);
        assert!(
            trails_drawn
                .iter()
                .all(|trail| (POINTS / BODIES - 2..=POINTS / BODIES + 1).contains(&trail.len()))
        );
        assert_eq!(trails.left_out(), Some((BODIES, BODIES + 5)));
    }

    #[test]
    fn a_body_that_was_put_elsewhere_and_a_particle_of_another_life_leave_no_line_from_there() {
        let (mut world, mut trails) = (world(2), Trails::default());
        (1..=3).for_each(|number| tick(&mut world, &mut trails, number));
        let body = world
            .query_filtered::<Entity, With<PreviousPosition>>()
            .iter(&world)
            .last()
            .expect("two");
        // As a request does it, and a birth in the slot of a particle that still lived.
        world.entity_mut(body).insert((Transform::at(DVec3::Y), PreviousPosition(DVec3::Y)));
        tick(&mut world, &mut trails, 4);
        let mut both = points(&trails, 1.0);
        both.sort_by_key(Vec::len);
        assert_eq!((both[1].len(), &both[0][..]), (5, &[DVec3::Y, DVec3::Y + DVec3::X][..]));
        world.entity_mut(body).insert(Dormant);
        tick(&mut world, &mut trails, 5);
        assert_eq!(points(&trails, 1.0).len(), 1);
    }

    #[test]
    fn a_body_at_rest_keeps_its_trail() {
        let (mut world, mut trails) = (world(1), Trails::default());
        (1..=4).for_each(|number| tick(&mut world, &mut trails, number));
        for number in 5..2000 {
            world.run_system_cached(remember_positions).expect("a query and nothing else");
            trails.after_tick(&world, f64::from(number) * TICK, 1.0);
        }
        assert_eq!(points(&trails, 100.0)[0].len(), 5);
    }
}
