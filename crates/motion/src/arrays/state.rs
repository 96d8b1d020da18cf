//! Saved states of arrays.

use super::{Bare, Residues};
use crate::real::Real;
use crate::state::clock::StepClock;
use crate::state::emitter::Emission;

/// A saved state of a [`Bare`].
#[derive(Clone, Debug)]
pub struct BareState<T> {
    positions: Vec<[T; 3]>,
    bodies: Vec<[T; 4]>,
    last_steps: Vec<T>,
    residues: Option<Residues<T>>,
    emissions: Vec<Emission>,
    clock: StepClock,
}

impl<T: Real> Bare<T> {
    /// Saves the state.
    #[must_use]
    pub fn save(&self) -> BareState<T> {
        let Self { positions, bodies, last_steps, residues, sources, clock, .. } = self;
        BareState {
            positions: positions.clone(),
            bodies: bodies.clone(),
            last_steps: last_steps.clone(),
            residues: residues.clone(),
            emissions: sources.iter().map(|source| source.emission.clone()).collect(),
            clock: *clock,
        }
    }

    /// Restores a saved state of these bodies. Counts stay as they are, and cached accelerations are evaluated again.
    ///
    /// # Panics
    /// If bodies were added since.
    pub fn restore(&mut self, state: &BareState<T>) {
        self.positions.copy_from_slice(&state.positions);
        self.bodies.copy_from_slice(&state.bodies);
        self.last_steps.clone_from(&state.last_steps);
        self.residues.clone_from(&state.residues);
        let sources = self.sources.iter_mut().zip(&state.emissions);
        sources.for_each(|(source, emission)| source.emission.clone_from(emission));
        self.update_living();
        self.clock = state.clock;
        self.has_failed = false;
        self.forget_accelerations();
        self.individuals.outdated = true;
    }
}
