//! Rows of the survival matrix as a person writes them.

use serde::Deserialize;

use crate::action::Action;
use crate::lists::List;
use crate::substepping::Substepping;
use crate::text::syntax::{Triple, Word};

/// The keys that are common to all rows, and `rows` with the keys in which they differ.
#[derive(Deserialize)]
pub(crate) struct Survival {
    pub label: Option<String>,
    pub measure: Option<Word>,
    pub seconds: Option<f64>,
    pub ticks: Option<u64>,
    pub exact_below: Option<f64>,
    pub bounded_below: Option<f64>,
    pub explodes_above: Option<f64>,
    pub scale_j: Option<f64>,
    pub reference_substeps: Option<u32>,
    pub steps: Option<Steps>,
    pub step_hz: Option<f64>,
    pub substeps: Option<Substepping>,
    pub damping_model: Option<Word>,
    pub damping_per_s: Option<f64>,
    pub offset_m: Option<Triple>,
    pub script: Option<List<Step>>,
    #[serde(default)]
    pub rows: List<Survival>,
}

/// `constant`, `jittered(spread: 0.5)` or `hitch(at_s: 1, length_s: 1)`.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Steps {
    Constant,
    Jittered { spread: Option<f64>, seed: Option<u64> },
    Hitch { at_s: Option<f64>, length_s: Option<f64> },
}

/// A step of a script.
#[derive(Deserialize)]
pub(crate) struct Step {
    pub at_s: Option<f64>,
    pub at_tick: Option<u64>,
    #[serde(rename = "do")]
    pub action: Option<Action>,
}
