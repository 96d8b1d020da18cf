//! Kinds of entities: which components a world has seen together.

use bevy_ecs::archetype::Archetype;
use bevy_ecs::prelude::*;

/// Whether there is a kind of entity with that component, be there none of the kind at present: another one is
/// noticed only when its kind is new.
pub(crate) fn may_exist<C: Component>(world: &World) -> bool {
    world.archetypes().iter().any(|kind| contains::<C>(world, kind))
}

pub(crate) fn contains<C: Component>(world: &World, kind: &Archetype) -> bool {
    world.components().component_id::<C>().is_some_and(|component| kind.contains(component))
}
