//! Bodies that stay where they are: a step passes them by.

use bevy_ecs::prelude::*;

use crate::state::components::PhysicsBody;
use crate::state::coupling::structure_changed;

/// A body that is immovable and at rest. Nothing that a step does could change it, so that no step looks at it.
///
/// Set when a schedule is compiled and by the requests that change velocity or mass. Whoever writes a
/// [`PhysicsBody`] without asking takes the mark away.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_discard = structure_changed)]
pub struct Static;

fn is_static(body: &PhysicsBody) -> bool {
    // Only values above 0 count as movable. A step turns -0 into 0: what has one is not passed by yet.
    let rests = body.velocity.to_array().iter().all(|part| part.to_bits() == 0);
    body.inverse_mass <= 0.0 && rests
}

/// Marks every body that has come to be static since.
pub(crate) fn mark_static(world: &mut World) {
    let mut bodies = world.query_filtered::<(Entity, &PhysicsBody), Without<Static>>();
    let found: Vec<_> =
        bodies.iter(world).filter(|(_, body)| is_static(body)).map(|(body, _)| (body, Static)).collect();
    world.insert_batch(found);
}

/// Marks one body, or takes the mark away.
pub(crate) fn look_again(world: &mut World, body: Entity) {
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
