//! A black box: one file that holds a run, to be attached to a report.
//!
//! A ZIP archive of `scene.ron`, the text of the scene as it was read; `manifest.json`, the description of the run
//! and its faults; `state.cbor`, the snapshot from which the run is repeated and the events after it, in CBOR (RFC
//! 8949), whose numbers are exact; and `picture.png`, if there was a GPU adapter. The archive's comment ends with the
//! XXH3-64 of all bytes before it.

mod archive;
mod energy;
mod manifest;

use motion::Request;
use scene::{Scene, SceneError};
use serde::{Deserialize, Serialize};

pub use archive::BadBundle;
pub(crate) use archive::{CONTRADICTION, UNDAMAGED};
pub use energy::{EnergyGrowth, EnergyLook, EnergyState};
pub use manifest::{BUNDLE_FORMAT, FaultEntry, Keyframe, Manifest};

use crate::change::Change;
use crate::snapshot::Snapshot;

/// A run that can be repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// Text of the scene file.
    pub scene: String,
    /// The description of the run.
    pub manifest: Manifest,
    /// The snapshot from which the run is repeated.
    pub snapshot: Snapshot,
    /// The events after the snapshot, in their order.
    pub events: Vec<Event>,
    /// The state of the watch over energy at the snapshot, if the run was watched.
    pub energy: Option<EnergyState>,
    /// A PNG of the last good tick.
    pub picture: Option<Vec<u8>>,
}

/// A change of a run from outside, with its tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Number of ticks simulated before the change.
    pub tick: u64,
    /// The change.
    pub what: Change,
}

impl Event {
    /// Bytes of memory of the event.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let list = match &self.what {
            Change::Requests(requests) => requests.capacity() * size_of::<Request<u32>>(),
            Change::Method(_) | Change::Substeps(_) | Change::Step(_) | Change::Push(..) => 0,
        };
        size_of::<Self>() + list
    }
}

impl Bundle {
    /// Parses the scene and applies the settings of the run. Error messages call the scene `name`.
    ///
    /// # Errors
    /// If the text is not a valid scene.
    pub fn scene(&self, name: &str) -> Result<Scene, SceneError> {
        let mut scene = Scene::parse(name, &self.scene)?;
        self.manifest.settings.apply(&mut scene);
        scene.name.clone_from(&self.manifest.scene);
        Ok(scene)
    }
}
