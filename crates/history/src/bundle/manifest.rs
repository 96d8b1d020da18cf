//! What a bundle says of its run, for people and programs.

use std::fmt;

use motion::{DampingModel, Method, Substeps};
use scene::Scene;
use serde::{Deserialize, Serialize};

use crate::lists::list;
use crate::snapshot::Name;

/// Version of the format that this program writes and reads.
pub const BUNDLE_FORMAT: u32 = 1;

/// `manifest.json`. Keys beside these are passed over, absent ones have defaults; `format` has to be there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Manifest {
    /// [`BUNDLE_FORMAT`] of the program that wrote it.
    pub format: u32,
    /// Name and version of that program.
    pub program: String,
    /// Name of the scene.
    pub scene: String,
    /// What the run had in place of what the scene says.
    pub settings: RunSettings,
    /// Tick of the snapshot.
    pub snapshot_tick: u64,
    /// Tick that the run came to; the fault's, if there is one.
    pub end_tick: u64,
    /// State hash there, as summaries write it.
    pub end_state_hash: String,
    /// Ticks whose state hashes are known, ascending, the snapshot's first.
    #[serde(deserialize_with = "list")]
    pub keyframes: Vec<Keyframe>,
    /// What went wrong, if anything did.
    pub fault: Option<FaultEntry>,
}

/// A tick and its state hash.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Keyframe {
    /// Ticks simulated until then.
    pub tick: u64,
    /// As summaries write it.
    pub state_hash: String,
}

/// What went wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct FaultEntry {
    /// Number of the tick, counted from 1.
    pub tick: u64,
    /// Name of the body that was quarantined, or that had most of the energy.
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

/// What a run had in place of what its scene says; absent is what the scene says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RunSettings {
    method: Option<Name<Method>>,
    step_hz: Option<f64>,
    substeps: Option<u32>,
    damping: Option<Name<DampingModel>>,
}

impl RunSettings {
    /// Those of `scene` as it is.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        Self {
            method: Some(Name(scene.method)),
            step_hz: Some(scene.step_hz),
            substeps: Some(scene.substeps),
            damping: scene.damping.map(|damping| Name(damping.model)),
        }
    }

    /// Applies them to `scene`, without an invalid rate.
    pub fn apply(&self, scene: &mut Scene) {
        scene.method = self.method.map_or(scene.method, |Name(method)| method);
        let rate = self.step_hz.filter(|rate| *rate > 0.0 && rate.is_finite() && (1.0 / rate).is_finite());
        scene.step_hz = rate.unwrap_or(scene.step_hz);
        scene.substeps = self.substeps.map_or(scene.substeps, |parts| parts.clamp(1, Substeps::MOST));
        if let (Some(damping), Some(Name(model))) = (&mut scene.damping, self.damping) {
            damping.model = model;
        }
    }
}
