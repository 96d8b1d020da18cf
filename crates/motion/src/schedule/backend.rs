//! Particles that are not bodies: what the crate that keeps them does in a tick, for a request and for a receipt.

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleConfigs;
use bevy_ecs::system::ScheduleSystem;

/// A crate that keeps the particles of some emitters itself, for example on a graphics device. The pools of these emitters
/// are empty. A resource, which makes the crate a part of every tick; `due_particles` says which
/// particles are born and die.
#[derive(Resource, Clone, Copy, Debug)]
pub struct ParticleBackend {
    /// Checks its emitters before a schedule is compiled, and returns whether there are any. Panics if a number is out of its
    /// range.
    pub prepare: fn(&mut World) -> bool,
    /// The system that runs in every tick, after the births of bodies and before anything moves.
    pub system: fn() -> ScheduleConfigs<ScheduleSystem>,
    /// Reverses the velocities of its particles.
    pub reverse: fn(&mut World),
    /// Bytes of its lists in the world.
    pub bytes: fn(&World) -> usize,
}

impl ParticleBackend {
    /// Calls `call` with the backend of `world`; returns the default if there is none.
    pub(crate) fn with<T: Default>(
        world: &mut World,
        call: impl FnOnce(Self, &mut World) -> T,
    ) -> T {
        match world.get_resource().copied() {
            Some(backend) => call(backend, world),
            None => T::default(),
        }
    }
}
