//! Counts of evaluations of laws and of iterations of solvers.

use bevy_ecs::prelude::*;

use crate::kernels::{Counts, StepStatistics, count};

/// Counts of evaluations and of solver iterations since the world was made.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct Evaluations {
    accelerations: u64,
    #[cfg_attr(feature = "serde", serde(with = "by_law"))]
    laws: Counts,
    newton_iterations: u64,
    cg_iterations: u64,
    unconverged_steps: u64,
}

/// Counts of iterations, and of steps that did not converge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
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

#[cfg(feature = "serde")]
mod by_law {
    //! Counts by law in files.

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::Counts;
    use crate::laws::{LawName, law_name};
    use crate::lists::list;

    #[derive(Serialize, Deserialize)]
    struct Name(#[serde(with = "law_name")] LawName);

    pub(super) fn serialize<S: Serializer>(counts: &Counts, out: S) -> Result<S::Ok, S::Error> {
        out.collect_seq(counts.iter().map(|(law, count)| (Name(law), *count)))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<Counts, D::Error> {
        Ok(list(source)?.into_iter().map(|(Name(law), count)| (law, count)).collect())
    }
}

impl Evaluations {
    /// Makes counts to continue from: accelerations, evaluations by law, and iterations.
    #[must_use]
    pub fn from_counts(
        accelerations: u64,
        laws: impl IntoIterator<Item = (&'static str, u64)>,
        iterations: Iterations,
    ) -> Self {
        let Iterations { newton, cg, unconverged_steps } = iterations;
        let laws = laws.into_iter().collect();
        Self {
            accelerations,
            laws,
            newton_iterations: newton,
            cg_iterations: cg,
            unconverged_steps,
        }
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
        self.newton_iterations
    }

    /// Iterations of conjugate gradients of implicit steps of groups.
    #[must_use]
    pub const fn cg_iterations(&self) -> u64 {
        self.cg_iterations
    }

    /// Implicit steps of a body or a group that did not converge; their state is that of the last iteration.
    #[must_use]
    pub const fn unconverged_steps(&self) -> u64 {
        self.unconverged_steps
    }

    /// Allocated bytes of the list of laws.
    #[must_use]
    pub fn list_bytes(&self) -> usize {
        if self.laws.spilled() { self.laws.capacity() * size_of::<(&str, u64)>() } else { 0 }
    }

    /// Counts evaluations of a law, which is listed once there is one.
    pub(crate) fn count(&mut self, law: &'static str, evaluations: u64) {
        count(&mut self.laws, law, evaluations);
    }

    /// Adds the statistics of a table in which the laws `affine` acted without being called.
    pub(crate) fn add(
        &mut self,
        statistics: &StepStatistics,
        affine: impl Iterator<Item = &'static str>,
    ) {
        if statistics.accelerations == 0 {
            return;
        }
        self.accelerations += statistics.accelerations;
        affine.for_each(|law| self.count(law, statistics.accelerations));
        statistics.laws.as_slice().iter().for_each(|(law, calls)| self.count(law, *calls));
        let Iterations { newton, cg, unconverged_steps } = statistics.iterations;
        self.newton_iterations += newton;
        self.cg_iterations += cg;
        self.unconverged_steps += unconverged_steps;
    }
}
