//! What a world has: kinds of entities, and the values of a component.

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

/// Every entity with that component, and its value.
pub(crate) fn with_entities<C: Component>(world: &World) -> impl Iterator<Item = (Entity, &C)> {
    // Where the component was never registered, no entity has it.
    let mut query = world.try_query::<(Entity, &C)>();
    let found: Vec<_> = query.iter_mut().flat_map(|query| query.iter(world)).collect();
    found.into_iter()
}

/// The values of a component.
pub(crate) fn values<C: Component>(world: &World) -> impl Iterator<Item = &C> {
    with_entities(world).map(|(_, value)| value)
}
