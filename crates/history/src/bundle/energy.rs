//! What the energy watch ([`Watch`](crate::Watch)) knows between two ticks, saved so that a bundle can continue it.
//!
//! A *look* is a span of ticks with a ledger, taken when energy has grown; see [`EnergyLook`].

use serde::{Deserialize, Serialize};

/// The energy of a run as a watch has seen it. The default is that of a run without energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EnergyState {
    /// The largest energy so far, J: the magnitude of the energy at the start, or the largest kinetic energy since.
    pub largest_j: f64,
    /// Tick at which the last look ended.
    pub looked_tick: u64,
    /// `largest_j` when the last look ended, J.
    pub looked_j: f64,
    /// Kinetic and potential energy then, J.
    pub total_j: Option<f64>,
    /// Kinetic and potential energy after the last tick, J, in a world that is small enough.
    pub last_j: Option<f64>,
    /// The first tick after that look by whose end total energy had risen by more than half of `looked_j`.
    pub grew_tick: Option<u64>,
    /// The first tick after the last change from outside.
    pub changed_tick: u64,
    /// The growth in progress: every look since it began found that the method invented it.
    pub growth: Option<EnergyGrowth>,
    /// The look in progress, for which a ledger is kept.
    pub look: Option<EnergyLook>,
}

impl EnergyState {
    /// The state of a run whose largest energy so far is `largest_j`. With `largest_j` infinite nothing counts as growth,
    /// which switches the watch off.
    #[must_use]
    pub fn at(tick: u64, largest_j: f64) -> Self {
        Self { largest_j, looked_tick: tick, looked_j: largest_j, ..Self::default() }
    }
}

/// A growth of energy that the method invents, look by look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EnergyGrowth {
    /// The tick in which it was first seen.
    pub since: u64,
    /// `largest_j` at the end of the first look, J.
    pub own_j: f64,
    /// Kinetic and potential energy then, J.
    pub total_j: Option<f64>,
    /// How much `largest_j` rose in later looks in which the method invented too little to explain it, J.
    pub elsewhere_j: f64,
    /// Whether it was reported.
    pub reported: bool,
}

/// A look: some ticks with a ledger, which finds the cause of a growth of energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EnergyLook {
    /// The tick in which energy had grown; the ledger begins after it.
    pub since: u64,
    /// The last tick after which kinetic energy exceeded 1.5 times the largest before that tick; at first `since`.
    pub last: u64,
    /// Energy that the method invented since the ledger began, J.
    pub invented_j: f64,
    /// Energy that pushes, laws without a potential, damping and all other causes added since then, J.
    pub caused_j: f64,
    /// Whether something else may add energy at any time: an engine, wind, births.
    pub fed: bool,
    /// Kinetic and potential energy when the ledger began, J.
    pub total_j: Option<f64>,
    /// The first tick by whose end the method had invented more than half of `looked_j`.
    pub grew: Option<u64>,
    /// The first of the ticks in a row that invented too much.
    pub jumped: Option<u64>,
    /// `largest_j` before the first tick of this look that alone added more than that, J.
    pub leapt_over_j: Option<f64>,
    /// Kinetic and potential energy before that tick, J.
    pub leapt_from_j: Option<f64>,
    /// The least kinetic and potential energy after a tick since then, J.
    pub least_j: Option<f64>,
    /// The largest of these, J.
    pub most_j: Option<f64>,
}
