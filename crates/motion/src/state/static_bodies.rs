//! Static bodies, which a step skips.

use bevy_ecs::prelude::*;

use crate::state::components::PhysicsBody;
use crate::state::coupling::structure_changed;

/// Marks a body that is immovable and at rest. No step can change it, so that steps skip it.
///
/// The mark is set when a schedule is compiled and by the requests that change velocity or mass. Code that writes a
/// [`PhysicsBody`] directly has to remove it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_discard = structure_changed)]
pub struct Static;

fn is_static(body: &PhysicsBody) -> bool {
    // Only inverse masses above 0 are movable. A step turns -0 into 0, so that a body with a -0 is not static yet.
    let rests = body.velocity.to_array().iter().all(|part| part.to_bits() == 0);
    body.inverse_mass <= 0.0 && rests
}

/// Marks every body that has become static since the last call.
pub(crate) fn mark_static(world: &mut World) {
    let mut bodies = world.query_filtered::<(Entity, &PhysicsBody), Without<Static>>();
    let found: Vec<_> =
        bodies.iter(world).filter(|(_, body)| is_static(body)).map(|(body, _)| (body, Static)).collect();
    world.insert_batch(found);
}

/// Adds or removes the mark of one body, as its state demands.
pub(crate) fn update_static_mark(world: &mut World, body: Entity) {
    let Some(now) = world.get::<PhysicsBody>(body).map(is_static) else { return };
    let mut body = world.entity_mut(body);
    if now != body.contains::<Static>() {
        if now {
            body.insert(Static);
        } else {
            body.remove::<Static>();
        }
    }
}
