//! Archetypes: which components a world has seen together.

use bevy_ecs::archetype::Archetype;
use bevy_ecs::prelude::*;

/// Whether an archetype with that component exists, even if it is empty now: a schedule that was compiled while it was
/// empty is not compiled again when it fills.
pub(crate) fn may_exist<C: Component>(world: &World) -> bool {
    world.archetypes().iter().any(|archetype| contains::<C>(world, archetype))
}

pub(crate) fn contains<C: Component>(world: &World, archetype: &Archetype) -> bool {
    world.components().component_id::<C>().is_some_and(|component| archetype.contains(component))
}
