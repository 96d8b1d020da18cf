//! Values of effects that are switched off, kept to switch them on again.

use bevy_ecs::prelude::*;

/// The component of an effect that is switched off, unchanged.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Off<C: Component>(pub C);

/// The resource of an effect that is switched off, unchanged.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct OffResource<R: Resource>(pub R);

/// Present while springs and soft bodies are switched off. Their points are then bodies like all others.
///
/// This is a mark, and the springs stay in the world: a soft body is drawn and picked even while nothing holds it
/// together.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SpringsOff;
