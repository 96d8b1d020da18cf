//! Where bodies have been: a short line behind each, while trails are switched on.

use std::collections::{BTreeMap, VecDeque};

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{PhysicsBody, Transform};

/// Points of a trail; one a frame.
const POINTS: usize = 90;

/// Bodies that leave a trail, at most: lines are for looking at, not for a crowd.
const BODIES: usize = 300;

/// The points that bodies passed, oldest first.
///
/// Ordered, because translucent lines blend in the order in which they are drawn.
#[derive(Default)]
pub(crate) struct Trails(BTreeMap<Entity, VecDeque<DVec3>>);

impl Trails {
    pub fn record(&mut self, world: &mut World) {
        let mut bodies = world.query::<(Entity, &Transform, &PhysicsBody)>();
        let movable = bodies.iter(world).filter(|(_, _, body)| body.inverse_mass > 0.0);
        for (body, transform, _) in movable.take(BODIES) {
            let trail = self.0.entry(body).or_default();
            if trail.back() != Some(&transform.position) {
                trail.push_back(transform.position);
            }
            if trail.len() > POINTS {
                trail.pop_front();
            }
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = &VecDeque<DVec3>> {
        self.0.values()
    }
}
