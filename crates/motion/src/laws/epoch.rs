//! A version number of the laws of every body, which changes whenever one of them does.

use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::change_detection::Tick;
use bevy_ecs::prelude::*;

/// Ticks of the last change of drag, wells and your own laws; `None` for one that does not exist.
pub(crate) type Changed = [Option<Tick>; 3];

/// Version of the laws of every body. It belongs to the world and not to a system, so that cached accelerations stay
/// valid when the schedule is compiled again.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(crate) struct Epoch {
    number: u64,
    changed: Changed,
}

impl Epoch {
    /// The version of the laws with those last changes.
    pub fn look(&mut self, changed: Changed) -> u64 {
        // Unique across worlds, so that no cached acceleration of another world matches.
        static EPOCHS: AtomicU64 = AtomicU64::new(1);
        if self.changed != changed {
            *self = Self { number: EPOCHS.fetch_add(1, Ordering::Relaxed), changed };
        }
        self.number
    }
}
