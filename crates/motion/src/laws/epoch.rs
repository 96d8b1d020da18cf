//! Which laws act on every body, as a number that is another one whenever they are.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::change_detection::{DetectChanges, Tick};
use bevy_ecs::prelude::*;

use crate::laws::{Drag, Laws, Wells};

/// When drag, wells and further laws were changed last; `None` is one that is not there.
pub(crate) type Changed = [Option<Tick>; 3];

/// The laws of every body at a time. Of the world and not of a system: a schedule that is compiled anew goes on with
/// what was kept under the one before.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct Epoch {
    number: u64,
    changed: Changed,
}

impl Epoch {
    /// The number of laws that were changed last then.
    pub fn look(&mut self, changed: Changed) -> u64 {
        // Unlike any other number that a kept acceleration may have been noted with, in any world.
        static EPOCHS: AtomicU64 = AtomicU64::new(1);
        if self.changed != changed {
            *self = Self { number: EPOCHS.fetch_add(1, Ordering::Relaxed), changed };
        }
        self.number
    }

    /// The number of the laws of `world`.
    pub fn of(world: &mut World) -> u64 {
        fn changed<R: Resource>(world: &World) -> Option<Tick> {
            world.get_resource_ref::<R>().map(|law| law.last_changed())
        }
        let changed = [changed::<Drag>(world), changed::<Wells>(world), changed::<Laws>(world)];
        world.get_resource_or_init::<Self>().look(changed)
    }
}
