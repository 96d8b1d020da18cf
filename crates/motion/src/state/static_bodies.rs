//! Static bodies, which a step skips.

use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemState;

use crate::state::components::PhysicsBody;
use crate::state::coupling::structure_changed;

/// Marks a body that is immovable and at rest. No step can change it, so that steps skip it.
///
/// The mark follows the [`PhysicsBody`]: a schedule that is compiled sets it, and a tick removes it from a body that was
/// given a mass or a velocity, by whatever code.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(on_discard = structure_changed)]
pub struct Static(());

fn is_static(body: &PhysicsBody) -> bool {
    // Only inverse masses above 0 are movable. A step turns -0 into 0, so that a body with a -0 is not static yet.
    let rests = body.velocity.to_array().iter().all(|part| part.to_bits() == 0);
    body.inverse_mass <= 0.0 && rests
}

/// Marks every body that has become static since the last call.
pub(crate) fn mark_static(world: &mut World) {
    let mut bodies = world.query_filtered::<(Entity, &PhysicsBody), Without<Static>>();
    let found: Vec<_> = bodies
        .iter(world)
        .filter(|(_, body)| is_static(body))
        .map(|(body, _)| (body, Static(())))
        .collect();
    world.insert_batch(found);
}

/// Adds or removes the mark of one body, as its state demands.
pub(crate) fn update_static_mark(world: &mut World, body: Entity) {
    let Some(now) = world.get::<PhysicsBody>(body).map(is_static) else { return };
    let mut body = world.entity_mut(body);
    if now != body.contains::<Static>() {
        if now {
            body.insert(Static(()));
        } else {
            body.remove::<Static>();
        }
    }
}

/// Finds static bodies that were given a mass or a velocity since the last check. A check costs nothing per body while no
/// code writes to a body.
pub(crate) struct StaticWatch(
    SystemState<Query<'static, 'static, (Entity, Ref<'static, PhysicsBody>), With<Static>>>,
);

impl StaticWatch {
    /// A watch whose first check covers every static body.
    pub fn new(world: &mut World) -> Self {
        Self(SystemState::new(world))
    }

    /// Removes the mark of every body that is static no longer.
    pub fn release(&mut self, world: &mut World) {
        let bodies = self.0.get(world).expect("a query is always valid");
        let mut moving = Vec::new();
        for (entities, bodies) in bodies.contiguous_iter().expect("bodies are stored in tables") {
            let (bodies, ticks) = ContiguousRef::split(bodies);
            if ticks.summary_tick_is_changed() != Some(false) {
                let pairs = entities.iter().zip(bodies);
                moving
                    .extend(pairs.filter(|(_, body)| !is_static(body)).map(|(entity, _)| *entity));
            }
        }
        for body in moving {
            world.entity_mut(body).remove::<Static>();
        }
    }
}
