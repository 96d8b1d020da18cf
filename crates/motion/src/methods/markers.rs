//! Markers of bodies that have their own method.

use bevy_ecs::archetype::Archetype;
use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;

use super::table::Method;
use super::with_method;
use crate::state::archetypes::contains;
use crate::state::coupling::structure_changed;

/// Marks a body that has its own method instead of the world's. The component of that method is on the body too.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_insert = structure_changed, on_discard = structure_changed)]
pub struct OwnMethod;

/// Gives a body its own method; `None` returns it to the world's method.
///
/// Use it only on bodies that have not been integrated yet. A body in motion changes its method by
/// [`Request::SetBodyMethod`](crate::Request::SetBodyMethod), which also initializes the new method's state.
pub fn mark_method(body: &mut EntityWorldMut, method: Option<Method>) {
    while let Some(old) = own_method(body.as_readonly()) {
        let components =
            body.world_scope(|world| [world.register_component::<OwnMethod>(), marker(world, old)]);
        body.remove_by_ids(&components);
    }
    if let Some(method) = method {
        with_method!(method, M => body.insert(M::default()));
    }
}

/// The component that marks the bodies of a method.
pub(crate) fn marker(world: &mut World, method: Method) -> ComponentId {
    with_method!(method, M => world.register_component::<M>())
}

/// Whether bodies of the archetype `kind` have `method` as their own method.
pub(crate) fn is_marked(world: &World, kind: &Archetype, method: Method) -> bool {
    with_method!(method, M => contains::<M>(world, kind))
}

/// The body's own method, if it has one.
#[must_use]
pub fn own_method(body: EntityRef) -> Option<Method> {
    Method::ALL.into_iter().find(|method| with_method!(method, M => body.contains::<M>()))
}
