//! Running scenes that can be copied, followed and gone back in.
//!
//! A [`Snapshot`] is the state of a world between two ticks, a [`Timeline`] the last minute of a run, a [`Bundle`] a run
//! in a file. A [`Twin`] follows a world with a method of its own.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test"))]

mod bundle;
mod distances;
mod input;
mod snapshot;
mod states;
mod timeline;
mod twin;

pub use bundle::{
    BUNDLE_FORMAT, BadBundle, Bundle, EnergyGrowth, EnergyLook, EnergyState, Event, FaultEntry, Happening,
    Keyframe, Manifest, Settings,
};
pub use distances::{Bodies, Distances};
pub use input::{Input, asked, give, pending};
pub use snapshot::{BadSnapshot, EffectsState, Snapshot, hash_of_states};
pub use states::states;
pub use timeline::{
    BadRerun, Broken, ENERGY_JUMP, Fault, Journey, Replay, Rerun, TIMELINE_BYTES, TIMELINE_SECONDS, Timeline,
    Watch, happen,
};
pub use twin::{Failure, Leader, REFERENCE_METHOD, REFERENCE_SUBSTEPS, Twin};
