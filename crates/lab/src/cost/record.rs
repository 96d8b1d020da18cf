//! The results of a study of accuracy and cost: the plain data of `report.json`, which is read again.

use motion::Method;
pub use scene::Setting;
use serde::{Deserialize, Serialize};

/// Errors of a run against the truth, over all bodies after all ticks, or after all substeps if the truth is a closed
/// form: the largest of each kind, and a mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// `max sqrt((|dx| / X)² + (|dv| / V)²)` with the scales of the study, no unit.
    pub relative: f64,
    /// Largest distance of a body from its true position, m.
    pub position_m: f64,
    /// Largest error of the velocity, m/s. Position Verlet shows the velocity half a step before its positions.
    pub velocity_m_s: f64,
    /// Root of the mean square of the distances, m.
    pub position_rms_m: f64,
    /// Phase and amplitude apart, for a problem with a closed form and a period.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<Phase>,
}

/// Phase and amplitude errors of the last state of a run. It is compared with the state nearest to it that the closed form
/// passes within half a period before or after the end of the run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// How much later the run reaches that state than the closed form, s.
    pub late_s: f64,
    /// Relative distance from that state, with the scales of [`Errors::relative`]: the error of amplitude and shape.
    pub off_path: f64,
}

/// Why a run produced no data point.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Failure {
    /// Its relative error exceeded [`BLOWN_UP`], or it turned non-finite.
    #[error("blew up")]
    BlewUp,
    /// A body was quarantined.
    #[error("{body} was quarantined in tick {tick}")]
    Quarantined {
        /// Name of the body.
        body: String,
        /// The tick in which it was quarantined.
        tick: u64,
    },
    /// Implicit steps did not converge; their last iterates were used.
    #[error("{steps} steps did not converge")]
    Unconverged {
        /// Number of such steps.
        steps: u64,
    },
    /// The study was stopped before this run.
    #[error("was not run")]
    NotRun,
    /// The method cannot solve what the scene declares.
    #[error("{why}")]
    Unsolvable {
        /// Why.
        why: String,
    },
}

/// Relative error above which a run has blown up.
pub const BLOWN_UP: f64 = 100.0;

/// The outcome of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It finished.
    Finished(Errors),
    /// It failed: charts show a mark at its cost instead of a point.
    Failed(Failure),
}

/// Evaluations of a run, counted in the run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Accelerations of one body by all laws together, evaluated once.
    pub accelerations: u64,
    /// Work of solvers on top, in accelerations of one body: one per Newton iteration, and one per body per iteration
    /// of conjugate gradients.
    pub solver: u64,
}

/// Thread CPU time of a run with [`Study::size`] bodies: the sum of the least times of its blocks of ticks over all
/// passes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Time {
    /// Per body per step, ns; a share of the fixed cost of the tick is in it.
    pub ns_per_body_step: f64,
    /// Simulated seconds of all bodies per second of CPU time.
    pub real_time_factor: f64,
    /// Per body per step, in steps of the yardstick: a fixed loop of semi-implicit Euler, timed in turns with the
    /// run.
    pub yardsticks: f64,
    /// Quartiles of the times of whole passes, as ratios to that sum: 1 on a quiet machine.
    pub quartiles: [f64; 3],
}

/// The host of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Host {
    /// The world of entities, as in the program.
    World,
    /// A loop over plain arrays of the same arithmetic, without this program: the price of the method alone.
    Arithmetic,
}

/// The thread CPU time of a tick as a line: a fixed cost, and a cost per body per step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickTime {
    /// Method of every body.
    pub method: Method,
    /// World or loop.
    pub host: Host,
    /// Cost of a tick that does not depend on its bodies and steps, ns.
    pub fixed_ns: f64,
    /// Additional cost per body per step, ns.
    pub ns_per_body_step: f64,
    /// Number of substeps of a problem's tick whose length the timed steps have; `None` for a scene, which is timed at
    /// several.
    pub substeps: Option<u32>,
    /// A step of the yardstick, timed in turns with it, ns.
    pub yardstick_ns: f64,
    /// The timed ticks, of copies of a problem or of a scene at its ladder of substeps; ascending.
    pub points: Vec<TimedTick>,
}

/// A tick of one size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedTick {
    /// Bodies times steps of the tick.
    pub body_steps: f64,
    /// Thread CPU time of the tick, ns: the least, as in [`Time`].
    pub ns: f64,
    /// Quartiles of the times of whole passes, as in [`Time`].
    pub quartiles: [f64; 3],
}

/// A setting and its results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// What was run.
    #[serde(flatten)]
    pub setting: Setting,
    /// Its errors, or why it failed.
    pub outcome: Outcome,
    /// Evaluations of the whole run.
    pub counts: Counts,
    /// Time in the world of entities; `None` if not measured (yet).
    pub time: Option<Time>,
    /// Time of the arithmetic alone: a loop over arrays in which the compiler sees the law; only for problems.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arithmetic_time: Option<Time>,
}

impl Cell {
    /// The cell of a setting that was not run yet.
    pub(crate) const fn not_run(setting: Setting) -> Self {
        Self {
            setting,
            outcome: Outcome::Failed(Failure::NotRun),
            counts: Counts { accelerations: 0, solver: 0 },
            time: None,
            arithmetic_time: None,
        }
    }

    /// Whether it has been run.
    pub fn is_run(&self) -> bool {
        self.outcome != Outcome::Failed(Failure::NotRun)
    }

    /// Its time in the world, or of the arithmetic alone.
    pub const fn time_in(&self, host: Host) -> Option<Time> {
        match host {
            Host::World => self.time,
            Host::Arithmetic => self.arithmetic_time,
        }
    }

    /// The errors of a run that finished.
    pub const fn errors(&self) -> Option<Errors> {
        match self.outcome {
            Outcome::Finished(errors) => Some(errors),
            Outcome::Failed(_) => None,
        }
    }
}

/// The truth that errors are measured against.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Truth {
    /// A closed form.
    ClosedForm {
        /// Author, year or equation.
        source: String,
    },
    /// A run at far finer steps.
    Reference {
        /// Its method.
        method: Method,
        /// Its substeps per tick.
        substeps: u32,
        /// Its own error as [`Errors::relative`], estimated as its distance to a run with half as many substeps.
        relative_error: f64,
        /// Its own error of positions, m.
        position_error_m: f64,
        /// Whether it has the exact model of damping instead of the model of the subject.
        exact_damping: bool,
    },
}

impl Truth {
    /// The error of the truth itself, relative and in m: smaller errors cannot be measured.
    pub const fn own_error(&self) -> (f64, f64) {
        match self {
            Self::ClosedForm { .. } => (0.0, 0.0),
            Self::Reference { relative_error, position_error_m, .. } => {
                (*relative_error, *position_error_m)
            }
        }
    }
}

/// The energy that residuals are relative to: the larger of the two over the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EnergyScale {
    /// The magnitude of the energy at the start.
    Start,
    /// The peak kinetic energy.
    PeakKinetic,
}

/// Energy that a method invented or lost over a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    /// What was run.
    #[serde(flatten)]
    pub setting: Setting,
    /// Whether it is the long run.
    pub long: bool,
    /// Length of the run, s.
    pub simulated_s: f64,
    /// What `start`, `largest` and `series` are relative to.
    pub scale: EnergyScale,
    /// Energy at the start.
    pub start: f64,
    /// Largest magnitude of the ledger's residual of energy after any tick; `None` if the run failed.
    pub largest: Option<f64>,
    /// Times, s, and residuals of some of the ticks, evenly spread: positive if the method invented energy, negative
    /// if it lost energy.
    pub series: Vec<(f64, f64)>,
}

/// One simulated second at a frame rate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RateRow {
    /// Frames per second.
    pub frame_hz: f64,
    /// `frame` for one tick per frame, of the frame's length, or `fixed` for ticks of the scene's own length.
    pub step: String,
    /// Model of damping, `none` without.
    pub damping: String,
    /// How the pushed body was pushed in the first frame: `force` for one tick, or `impulse`.
    pub push: String,
    /// Ticks that were simulated.
    pub ticks: u64,
    /// How far the pushed body moved, m; `None` if it was quarantined.
    pub moved_m: Option<f64>,
    /// Distance of the pushed body from its place after the same impulse in a run with 100 substeps, m.
    pub off_m: Option<f64>,
}

/// Everything found about one subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// The problem or scene, by the name on the command line.
    pub subject: String,
    /// One line about it.
    pub description: String,
    /// Ticks per second; substeps divide them.
    pub step_hz: f64,
    /// Ticks of a run.
    pub ticks: u64,
    /// Length of a run, s.
    pub simulated_s: f64,
    /// Bodies that can move.
    pub bodies: usize,
    /// Length of a natural period, s, for subjects that have one.
    pub period_s: Option<f64>,
    /// The scene's own setting.
    pub own: Setting,
    /// What errors are measured against.
    pub truth: Truth,
    /// Scale X of positions, m: the largest distance from the origin in the truth.
    pub position_scale_m: f64,
    /// Scale V of velocities, m/s: the largest speed there.
    pub velocity_scale_m_s: f64,
    /// The cells, in the order of substeps and methods.
    pub cells: Vec<Cell>,
    /// Bodies of the copies of a problem that were timed; `None` if the subject itself was timed.
    #[serde(default)]
    pub timed_bodies: Option<usize>,
    /// Times of ticks by method and host.
    #[serde(default)]
    pub tick_times: Vec<TickTime>,
    /// Energy over short and long runs.
    pub drifts: Vec<Drift>,
    /// One second at several frame rates; empty if it was not asked for.
    pub rates: Vec<RateRow>,
    /// Notes for the reader: what was switched on, left out, or cut short.
    pub notes: Vec<String>,
}

/// The machine and the compiler of a report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Model of the processor.
    pub processor: String,
    /// Its cores that this program may use.
    pub cores: usize,
    /// Sizes of its data caches, bytes, the nearest first; empty if the system does not report them.
    #[serde(default)]
    pub caches: Vec<u64>,
    /// Operating system and architecture.
    pub system: String,
    /// Vector instructions that the kernels use.
    pub instructions: String,
    /// Version of this program.
    pub version: String,
    /// The compiler that it was built with, and whether optimized.
    pub compiler: String,
}

/// Studies that were made together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Version of this format.
    pub format: u32,
    /// The command line that reproduces the report.
    pub command: String,
    /// Where it was measured.
    pub machine: Machine,
    /// Whether every planned run is in it.
    pub complete: bool,
    /// One study per subject.
    pub studies: Vec<Study>,
}

/// [`Report::format`] of this program.
pub const FORMAT: u32 = 4;
