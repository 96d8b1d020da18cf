//! Counts of evaluations of laws and of iterations of solvers.

use bevy_ecs::prelude::*;

use crate::kernels::{Counts, StepStatistics, count};

/// Evaluations since the world was made, as counted by the run.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Evaluations {
    accelerations: u64,
    laws: Counts,
    iterations: Iterations,
}

/// Counts of iterations, and of steps that did not converge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Iterations {
    /// Newton iterations of implicit steps.
    pub newton: u64,
    /// Iterations of conjugate gradients.
    pub cg: u64,
    /// Implicit steps that did not converge.
    pub unconverged_steps: u64,
}

impl Iterations {
    pub(crate) fn add(&mut self, other: Self) {
        self.newton += other.newton;
        self.cg += other.cg;
        self.unconverged_steps += other.unconverged_steps;
    }
}

impl Evaluations {
    /// Counts to continue from: accelerations, evaluations by law, and iterations.
    #[must_use]
    pub fn going_on(
        accelerations: u64,
        laws: impl IntoIterator<Item = (&'static str, u64)>,
        iterations: Iterations,
    ) -> Self {
        Self { accelerations, laws: laws.into_iter().collect(), iterations }
    }

    /// Evaluations of the acceleration of one body by all laws together.
    #[must_use]
    pub const fn accelerations(&self) -> u64 {
        self.accelerations
    }

    /// Evaluations of each law that acted, by name.
    #[must_use]
    pub fn laws(&self) -> &[(&'static str, u64)] {
        &self.laws
    }

    /// Newton iterations of implicit steps.
    #[must_use]
    pub const fn newton_iterations(&self) -> u64 {
        self.iterations.newton
    }

    /// Iterations of conjugate gradients of implicit steps of groups.
    #[must_use]
    pub const fn cg_iterations(&self) -> u64 {
        self.iterations.cg
    }

    /// Implicit steps of a body or a group that did not converge; their state is that of the last iteration.
    #[must_use]
    pub const fn unconverged_steps(&self) -> u64 {
        self.iterations.unconverged_steps
    }

    /// Counts evaluations of a law, which is listed once there is one.
    pub(crate) fn count(&mut self, law: &'static str, evaluations: u64) {
        count(&mut self.laws, law, evaluations);
    }

    /// Adds the statistics of a table in which the laws `affine` acted without being called.
    pub(crate) fn add(&mut self, statistics: &StepStatistics, affine: impl Iterator<Item = &'static str>) {
        if statistics.accelerations == 0 {
            return;
        }
        self.accelerations += statistics.accelerations;
        affine.for_each(|law| self.count(law, statistics.accelerations));
        statistics.laws.as_slice().iter().for_each(|(law, calls)| self.count(law, *calls));
        self.iterations.add(statistics.iterations);
    }
}
