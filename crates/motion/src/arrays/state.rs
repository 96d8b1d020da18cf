//! Saved states of arrays.

use super::Bare;
use crate::state::clock::StepClock;
use crate::state::emitter::Emission;

/// A saved state of a [`Bare`].
#[derive(Clone, Debug)]
pub struct BareState {
    positions: Vec<[f64; 3]>,
    bodies: Vec<[f64; 4]>,
    last_steps: Vec<f64>,
    emissions: Vec<Emission>,
    clock: StepClock,
}

impl Bare {
    /// Saves the state.
    #[must_use]
    pub fn save(&self) -> BareState {
        let Self { positions, bodies, last_steps, sources, clock, .. } = self;
        BareState {
            positions: positions.clone(),
            bodies: bodies.clone(),
            last_steps: last_steps.clone(),
            emissions: sources.iter().map(|source| source.emission.clone()).collect(),
            clock: *clock,
        }
    }

    /// Restores a saved state of these bodies. Counts stay as they are, and cached accelerations are evaluated again.
    ///
    /// # Panics
    /// If bodies were added since.
    pub fn restore(&mut self, state: &BareState) {
        self.positions.copy_from_slice(&state.positions);
        self.bodies.copy_from_slice(&state.bodies);
        self.last_steps.clone_from(&state.last_steps);
        let sources = self.sources.iter_mut().zip(&state.emissions);
        sources.for_each(|(source, emission)| source.emission.clone_from(emission));
        self.update_living();
        self.clock = state.clock;
        self.has_failed = false;
        self.forget_accelerations();
        self.individuals.outdated = true;
    }
}
