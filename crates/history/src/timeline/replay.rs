//! A run that is simulated again from a snapshot and what came from outside.

use std::iter::Peekable;
use std::sync::Arc;

use scene::Scene;

use super::{Fault, Watch};
use crate::bundle::{EnergyState, Event};
use crate::simulation::Simulation;
use crate::snapshot::{BadSnapshot, Snapshot};

/// A run that came out differently when it was simulated again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("tick {tick} comes out differently when it is simulated again")]
pub struct Broken {
    /// The tick at which it was looked at.
    pub tick: u64,
}

/// A run that is simulated again.
pub struct Replay {
    /// The simulation.
    pub simulation: Simulation,
    /// What looks for faults.
    pub watch: Watch,
}

impl Replay {
    /// A simulation of `scene` in the state of `snapshot`, when `energy` was what [`Watch::energy`] was.
    ///
    /// # Errors
    /// A snapshot of another scene.
    pub fn of(
        scene: impl Into<Arc<Scene>>,
        snapshot: &Snapshot,
        energy: EnergyState,
    ) -> Result<Self, BadSnapshot> {
        let mut simulation = Simulation::restore(scene, snapshot)?;
        let watch = Watch::going_on(&mut simulation.world, energy);
        Ok(Self { simulation, watch })
    }

    /// Simulates a tick with the next of `events` that belong to it; what went wrong in it.
    pub fn tick<'a>(&mut self, events: &mut Peekable<impl Iterator<Item = &'a Event>>) -> Option<Fault> {
        let now = self.simulation.ticks();
        if self.carry_out(events) {
            self.watch.note_change(now);
        }
        self.watch.tick(&mut self.simulation, None)
    }

    /// Does what the next of `events` did at this tick; those of ticks before it are passed over. Pushes wait for the
    /// coming tick. Whether there were some.
    pub fn carry_out<'a>(&mut self, events: &mut Peekable<impl Iterator<Item = &'a Event>>) -> bool {
        let now = self.simulation.ticks();
        let mut some = false;
        while let Some(event) = events.next_if(|event| event.tick <= now) {
            if event.tick == now {
                self.simulation.apply(&event.what);
                some = true;
            }
        }
        some
    }
}
