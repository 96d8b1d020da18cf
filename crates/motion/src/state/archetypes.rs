//! Archetypes, and the values of a component.

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

/// What `of` makes of every entity with that component and its value, as far as it makes anything.
pub(crate) fn collect<'w, C: Component, T>(
    world: &'w World,
    of: impl FnMut((Entity, &'w C)) -> Option<T>,
) -> Vec<T> {
    // Where the component was never registered, no entity has it.
    let mut query = world.try_query::<(Entity, &C)>();
    query.iter_mut().flat_map(|query| query.iter(world)).filter_map(of).collect()
}

/// The values of a component in `world`, which stays as it is; none if the component was never registered.
pub fn values<C: Component>(world: &World) -> impl Iterator<Item = &C> {
    collect(world, |(_, value)| Some(value)).into_iter()
}
