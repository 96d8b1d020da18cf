//! Running scenes that can be changed, copied, followed and rewound.
//!
//! - [`Simulation`]: a scene that runs, with the world and the stepper that run it.
//! - [`Change`]: everything that is done to a running simulation from outside, and the one place that applies it.
//! - [`RunSettings`]: the present settings of a run; [`Overrides`]: the settings that replace those of its scenes.
//! - [`Snapshot`]: the state of a simulation between two ticks, by stable id, for files and for new worlds of the same scene.
//! - [`Timeline`]: the last minute of a run. [`Seek`] goes to another tick, [`Watch`] detects a [`Fault`], and [`Replay`]
//!   simulates the ticks from a snapshot again.
//! - [`Bundle`]: a run in a file; its parts are [`Manifest`], [`Event`] and [`EnergyState`]. [`Rerun`] simulates one again.
//! - [`Twin`]: a simulation that follows another one with its own method. [`Distances`] measures how far apart the two are.
//! - [`bonds`]: what holds each body: a well, another body, a spring.
//! - `lists`: lists that are read from files into a limited amount of memory.

#![cfg_attr(test, allow(clippy::wildcard_enum_match_arm, reason = "a test is of some of them"))]
#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test"))]

mod bonds;
mod bundle;
mod change;
mod distances;
mod settings;
mod simulation;
mod snapshot;
mod timeline;
mod twin;

pub use bonds::{Bond, Holder, bonds};
pub use bundle::{
    BUNDLE_FORMAT, BadBundle, Bundle, EnergyGrowth, EnergyLook, EnergyState, Event, FaultEntry,
    Keyframe, Manifest,
};
pub use change::{Change, Gone};
pub use distances::{Distances, DistancesSoFar};
pub use settings::{Overrides, RunSettings, rate_of};
pub use simulation::{FirstQuarantine, Simulation};
pub use snapshot::{BadSnapshot, Snapshot};
pub use timeline::{
    Broken, ENERGY_JUMP, Fault, Replay, Rerun, Seek, TIMELINE_BYTES, TIMELINE_SECONDS, Timeline,
    Watch,
};
pub use twin::{REFERENCE_METHOD, REFERENCE_SUBSTEPS, Twin, reference_substeps};
