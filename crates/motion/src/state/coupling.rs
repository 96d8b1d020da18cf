//! Which bodies are integrated in groups, and whether the groups have to be compiled again.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

/// Whether springs, mutual gravity or the bodies that they join have changed since the groups were compiled. If so, the
/// groups are compiled again before the next tick. Present where there are [`Groups`](crate::groups::Groups).
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct CouplingChanged(pub bool);

impl CouplingChanged {
    /// Requests that the groups of `world`, if there are any, be compiled again before the next tick.
    pub fn set(world: &mut World) {
        if let Some(mut changed) = world.get_resource_mut::<Self>() {
            changed.0 = true;
        }
    }
}

/// Marks a body that is integrated in a group. [`compile_groups`](crate::groups::compile_groups) adds and removes it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(on_discard = structure_changed)]
pub struct Grouped;

/// [`CouplingChanged::set`] as a component hook.
pub(crate) fn structure_changed(mut world: DeferredWorld, _: HookContext) {
    if let Some(mut changed) = world.get_resource_mut::<CouplingChanged>() {
        changed.0 = true;
    }
}
