//! The measures of a sweep, and their columns in the table of runs.

use serde::{Deserialize, Serialize};

use crate::column::Kind;

/// A measure of a run, over all of its ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The largest distance, m, of a body from its position in a run of the reference method at far finer steps,
    /// after any tick; and the same distance of a run with half as many substeps, which says how far the reference
    /// itself can be trusted.
    Error,
    /// The largest energy that the method has invented or lost after any tick, by the ledger, relative to the larger of the
    /// energy at the start and the peak kinetic energy.
    Drift,
    /// Whether no body was quarantined, and none was thrown out: by a [trial](crate::trial) of the whole run beside far finer ones, in
    /// which no speed, distance from what holds a body, or energy exceeds 3 times the true one. Also until when that was so, s.
    Survives,
    /// The largest speed of a body, m/s.
    LargestSpeed,
    /// The largest distance of a body that is no particle of an emitter from where it began, m.
    LargestDistance,
    /// Evaluations of the acceleration per movable body, including those of solvers.
    Evaluations,
    /// Implicit steps that did not converge.
    Unconverged,
    /// Hash of the state at the end, as summaries have it.
    StateHash,
    /// Thread CPU time of the ticks, s, including the cost of the other measures, and the processor. It differs from
    /// run to run.
    Time,
}

impl Measure {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Error,
        Self::Drift,
        Self::Survives,
        Self::LargestSpeed,
        Self::LargestDistance,
        Self::Evaluations,
        Self::Unconverged,
        Self::StateHash,
        Self::Time,
    ];

    /// Its word on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Drift => "drift",
            Self::Survives => "survives",
            Self::LargestSpeed => "largest_speed",
            Self::LargestDistance => "largest_distance",
            Self::Evaluations => "evaluations",
            Self::Unconverged => "unconverged",
            Self::StateHash => "state_hash",
            Self::Time => "time",
        }
    }

    /// The measure of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|measure| measure.name() == name)
    }

    /// Its columns; figures show the first.
    #[must_use]
    pub const fn columns(self) -> &'static [(&'static str, Kind)] {
        match self {
            Self::Error => &[("error_m", Kind::Number), ("reference_error_m", Kind::Number)],
            Self::Drift => &[("drift", Kind::Number)],
            Self::Survives => &[("survives", Kind::Flag), ("survived_s", Kind::Number)],
            Self::LargestSpeed => &[("largest_speed_m_s", Kind::Number)],
            Self::LargestDistance => &[("largest_distance_m", Kind::Number)],
            Self::Evaluations => &[("evaluations_per_body", Kind::Number)],
            Self::Unconverged => &[("unconverged_steps", Kind::Count)],
            Self::StateHash => &[("state_hash", Kind::Text)],
            Self::Time => &[("cpu_s", Kind::Number), ("processor", Kind::Text)],
        }
    }
}
