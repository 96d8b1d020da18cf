//! Running scenes that can be copied, followed and gone back in.
//!
//! A [`Simulation`] is a scene that runs, a [`Snapshot`] its state between two ticks, a [`Timeline`] its last minute, a
//! [`Bundle`] a run in a file. A [`Twin`] follows a simulation with a method of its own.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test"))]

mod bundle;
mod change;
mod distances;
mod lists;
mod simulation;
mod snapshot;
mod timeline;
mod twin;

pub use bundle::{
    BUNDLE_FORMAT, BadBundle, Bundle, EnergyGrowth, EnergyLook, EnergyState, Event, FaultEntry, Keyframe,
    Manifest, RunSettings,
};
pub use change::{Change, Gone};
pub use distances::{Distances, DistancesSoFar};
pub use simulation::Simulation;
pub use snapshot::{BadSnapshot, Snapshot, words};
pub use timeline::{
    Broken, ENERGY_JUMP, Fault, Replay, Rerun, Seek, TIMELINE_BYTES, TIMELINE_SECONDS, Timeline, Watch,
};
pub use twin::{Failure, REFERENCE_METHOD, REFERENCE_SUBSTEPS, Twin};
