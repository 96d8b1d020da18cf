//! What effects that are off leave behind: their values, to be switched on again.

use bevy_ecs::prelude::*;

/// A component of an effect that is off, as it was.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Off<C: Component>(pub C);

/// A resource of an effect that is off, as it was.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct OffResource<R: Resource>(pub R);

/// Springs and soft bodies are off: their points are bodies like all others.
///
/// A mark and not taken out: a soft body is drawn and picked also while nothing holds it together.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SpringsOff;
