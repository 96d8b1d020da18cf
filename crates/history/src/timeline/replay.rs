//! A run that is simulated again from a snapshot and the events after it.

use std::iter::Peekable;
use std::sync::Arc;

use scene::Scene;

use super::{Fault, Watch};
use crate::bundle::{EnergyState, Event};
use crate::simulation::Simulation;
use crate::snapshot::{BadSnapshot, Snapshot};

/// A recorded run cannot be simulated again: a snapshot is missing, cannot be restored, or restores to another state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("tick {tick} comes out differently when it is simulated again")]
pub struct Broken {
    /// The tick at which the states were compared.
    pub tick: u64,
}

/// A run that is simulated again.
pub struct Replay {
    /// The simulation.
    pub simulation: Simulation,
    /// The watch for faults.
    pub watch: Watch,
}

impl Replay {
    /// A simulation of `scene` in the state of `snapshot`, with `energy` as [`Watch::energy`] returned it then.
    ///
    /// # Errors
    /// If the snapshot cannot be of a simulation of that scene.
    pub fn of(
        scene: impl Into<Arc<Scene>>,
        snapshot: &Snapshot,
        energy: EnergyState,
    ) -> Result<Self, BadSnapshot> {
        let simulation = Simulation::restore(scene, snapshot)?;
        let watch = Watch::resume(&simulation, energy);
        Ok(Self { simulation, watch })
    }

    /// Simulates a tick with the next of `events` that belong to it. Returns its fault, if it has one.
    pub fn tick<'a>(
        &mut self,
        events: &mut Peekable<impl Iterator<Item = &'a Event>>,
    ) -> Option<Fault> {
        let now = self.simulation.ticks();
        if self.carry_out(events) {
            self.watch.note_change(now);
        }
        self.watch.tick(&mut self.simulation, None)
    }

    /// Applies the events at the present tick number, after skipping earlier ones. A push waits for the coming tick. Returns
    /// whether one of them may add energy.
    ///
    /// It does not tell the watch. [`Self::tick`] does that right after; after a seek the next live tick does.
    pub fn carry_out<'a>(
        &mut self,
        events: &mut Peekable<impl Iterator<Item = &'a Event>>,
    ) -> bool {
        let now = self.simulation.ticks();
        let mut may_add_energy = false;
        while let Some(event) = events.next_if(|event| event.tick <= now) {
            if event.tick == now {
                self.simulation.give(&event.what);
                may_add_energy |= event.what.may_add_energy();
            }
        }
        may_add_energy
    }
}
