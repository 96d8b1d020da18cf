//! `manifest.json`: the description of the run in a bundle, for people and programs.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::settings::Overrides;
use scene::lists::list;

/// Version of the format that this program writes and reads.
pub const BUNDLE_FORMAT: u32 = 1;

/// The content of `manifest.json`. Unknown keys are ignored, and absent keys have defaults, except `format`, which is
/// required.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Manifest {
    /// [`BUNDLE_FORMAT`] of the program that wrote it. An absent key gives 0, which is refused when a bundle is read.
    pub format: u32,
    /// Name and version of that program.
    pub program: String,
    /// Name of the scene.
    pub scene: String,
    /// Settings of the run that override those of the scene.
    pub settings: Overrides,
    /// Tick of the snapshot.
    pub snapshot_tick: u64,
    /// Last tick of the run; the tick of the fault, if there is one.
    pub end_tick: u64,
    /// State hash at `end_tick`, as summaries write it.
    pub end_state_hash: String,
    /// Ticks whose state hashes are known, ascending, beginning with the tick of the snapshot.
    #[serde(deserialize_with = "list")]
    pub keyframes: Vec<Keyframe>,
    /// What went wrong, if anything did.
    pub fault: Option<FaultEntry>,
}

/// A tick and its state hash.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Keyframe {
    /// Number of ticks simulated.
    pub tick: u64,
    /// State hash after these ticks, as summaries write it.
    pub state_hash: String,
}

/// What went wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct FaultEntry {
    /// Number of the tick, counted from 1.
    pub tick: u64,
    /// Name of the body that was quarantined, that left its orbit, or that had most of the energy from nowhere.
    pub body: Option<String>,
    /// What happened, and in which part of the step.
    pub what: String,
}

impl fmt::Display for FaultEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(body) = &self.body {
            write!(f, "{body}, ")?;
        }
        write!(f, "tick {}: {}", self.tick, self.what)
    }
}
