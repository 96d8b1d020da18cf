//! Disabled bodies, springs and emitters: entities with Bevy's [`Disabled`], or with another component that hides entities from
//! queries.
//!
//! Queries skip them, so that no system moves them. Groups and pools, which are made from them, are made again when one is
//! disabled or enabled.
//!
//! [`Disabled`]: bevy_ecs::entity_disabling::Disabled

use bevy_ecs::entity_disabling::DefaultQueryFilters;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::state::components::{Force, PhysicsBody};
use crate::state::coupling::{CouplingChanged, Grouped};
use crate::state::emitter::{Emission, EmittersChanged, Particle};
use crate::state::springs::{SoftBody, Spring};
use crate::state::static_bodies::Static;
use crate::units::Vector;

/// Whether a world is watched for entities that are disabled and enabled.
#[derive(Resource)]
struct Watched;

/// Watches `world` for entities that are disabled and enabled, from the first call on.
pub(crate) fn watch_disabled(world: &mut World) {
    if world.contains_resource::<Watched>() {
        return;
    }
    world.insert_resource(Watched);
    let filters = world.get_resource::<DefaultQueryFilters>();
    let disabling: Vec<_> =
        filters.into_iter().flat_map(DefaultQueryFilters::disabling_ids).collect();
    if !disabling.is_empty() {
        world.spawn(Observer::new(disable).with_components(disabling.iter().copied()));
        world.spawn(Observer::new(enable).with_components(disabling));
    }
}

fn disable(added: On<Add<()>>, mut world: DeferredWorld) {
    changed(added.entity, &mut world);
    // An emitter begins as a new one when it is enabled.
    if let Some(mut emission) = world.get_mut::<Emission>(added.entity) {
        *emission = Emission::default();
    }
    // These marks are only for bodies in a tick, and are set again when the body is enabled.
    if let Ok(mut body) = world.commands().get_entity(added.entity) {
        body.try_remove::<(Grouped, Static)>();
    }
}

fn enable(removed: On<Remove<()>>, mut world: DeferredWorld) {
    changed(removed.entity, &mut world);
    // A force acts for one tick, in which the body was disabled.
    if let Some(mut force) = world.get_mut::<Force>(removed.entity) {
        *force.bypass_change_detection() = Force(Vector::ZERO);
    }
}

fn changed(entity: Entity, world: &mut DeferredWorld) {
    let Ok(entity) = world.get_entity(entity) else { return };
    let joined = entity.contains::<PhysicsBody>()
        || entity.contains::<Spring>()
        || entity.contains::<SoftBody>();
    let emits = entity.contains::<Emission>() || entity.contains::<Particle>();
    if let Some(mut coupling) = world.get_resource_mut::<CouplingChanged>().filter(|_| joined) {
        coupling.0 = true;
    }
    if let Some(mut emitters) = world.get_resource_mut::<EmittersChanged>().filter(|_| emits) {
        emitters.0 = true;
    }
}

/// Whether queries skip `entity`.
pub(crate) fn is_disabled(world: &World, entity: EntityRef) -> bool {
    let filters = world.get_resource::<DefaultQueryFilters>();
    filters.is_some_and(|filters| filters.disabling_ids().any(|id| entity.contains_id(id)))
}
