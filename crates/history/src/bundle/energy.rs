//! The state of the watch over the energy of a run between two ticks, saved so that a bundle continues with it.

use serde::{Deserialize, Serialize};

/// The energy of a run as a watch has seen it. The default is that of a run without energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EnergyState {
    /// The largest energy so far, J: the magnitude of the energy at the start, or the largest kinetic energy since.
    pub largest_j: f64,
    /// Tick at which the last look ended.
    pub looked_tick: u64,
    /// The largest energy then, J.
    pub looked_j: f64,
    /// Kinetic and potential energy then, J.
    pub total_j: Option<f64>,
    /// Kinetic and potential energy after the last tick, J, in a world that is small enough.
    pub last_j: Option<f64>,
    /// The first tick since that look after which there was half as much again.
    pub grew_tick: Option<u64>,
    /// The first tick after the last change from outside.
    pub changed_tick: u64,
    /// The growth in progress: every look since it began found that the method invented it.
    pub growth: Option<EnergyGrowth>,
    /// The look in progress, for which a ledger is kept.
    pub look: Option<EnergyLook>,
}

impl EnergyState {
    /// The state of a run whose largest energy so far is `largest_j`. Infinite energy is not watched.
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
    /// The largest energy at the end of the first look, J.
    pub own_j: f64,
    /// Kinetic and potential energy then, J.
    pub total_j: Option<f64>,
    /// Energy that the looks since then attributed to other causes, J.
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
    /// The last tick that multiplied the energy.
    pub last: u64,
    /// Energy that the method invented since the ledger began, J.
    pub invented_j: f64,
    /// Energy that pushes, laws without a potential, damping and all other causes added since then, J.
    pub caused_j: f64,
    /// Whether something else may add energy at any time: an engine, wind, births.
    pub fed: bool,
    /// Kinetic and potential energy when the ledger began, J.
    pub total_j: Option<f64>,
    /// The first tick by which half of the largest energy before the look was invented.
    pub grew: Option<u64>,
    /// The first of the ticks in a row that invented too much.
    pub jumped: Option<u64>,
    /// The largest energy before the tick that raised the doubt, J, if that tick by itself invented more.
    pub leapt_over_j: Option<f64>,
}
