//! Where bodies are.

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{PhysicsBody, StableId, Transform};

/// Position and velocity of every body with physics in `world`, in stable-id order.
pub fn states(world: &mut World) -> Vec<(u32, Vector, Vector)> {
    let mut bodies = world.query::<(&StableId, &Transform, &PhysicsBody)>();
    let states = bodies.iter(world).map(|(id, transform, body)| (id.0, transform.position, body.velocity));
    let mut states: Vec<_> = states.collect();
    states.sort_unstable_by_key(|(id, ..)| *id);
    states
}
