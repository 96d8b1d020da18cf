//! A version number of the laws of every body, which changes whenever one of them does.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::prelude::*;

use super::Changes;

/// Version of the laws of every body. It belongs to the world and not to a system, so that cached accelerations stay
/// valid when the schedule is compiled again.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct Epoch {
    number: u64,
    changes: Changes,
}

impl Epoch {
    /// The version of the laws.
    pub const fn number(&self) -> u64 {
        self.number
    }

    /// Makes a new version if the laws have changed.
    pub fn update(&mut self, changes: Changes) {
        // Unique across worlds, so that no cached acceleration of another world matches.
        static EPOCHS: AtomicU64 = AtomicU64::new(1);
        if self.changes != changes {
            *self = Self { number: EPOCHS.fetch_add(1, Ordering::Relaxed), changes };
        }
    }
}
