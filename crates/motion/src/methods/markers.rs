//! Methods of single bodies: markers instead of the world's method.

use bevy_ecs::prelude::*;

use super::table::Method;
use super::with_method;
use crate::state::coupling::structure_changed;

/// A body that has a method of its own, marked by the method's component, whatever the world's is.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_insert = structure_changed, on_discard = structure_changed)]
pub struct OwnMethod;

/// Marks a body as one that uses `method` whatever the world's is; `None` takes the mark away.
///
/// Only for bodies that have not been integrated yet: a running body changes its method by
/// [`Request::SetBodyMethod`](crate::Request::SetBodyMethod), which starts the new one as it should.
pub fn mark_method(body: &mut EntityWorldMut, method: Option<Method>) {
    while let Some(old) = own_method(body.as_readonly()) {
        with_method!(old, M => body.remove::<(OwnMethod, M)>());
    }
    if let Some(method) = method {
        with_method!(method, M => body.insert(M::default()));
    }
}

/// The method that a body is marked with.
#[must_use]
pub fn own_method(body: EntityRef) -> Option<Method> {
    Method::ALL.into_iter().find(|method| with_method!(method, M => body.contains::<M>()))
}
