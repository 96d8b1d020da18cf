//! A black box: one file that holds a run, to be attached to a report.
//!
//! A ZIP archive of `scene.ron`, the text of the scene as it was read; `manifest.json`, what the run was and what
//! went wrong; `state.cbor`, the snapshot that the run is repeated from and what came from outside after it, in
//! CBOR (RFC 8949), whose numbers are exact; and `picture.png`, if there was an adapter. The archive's comment ends
//! with the XXH3-64 of all bytes before it.

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
    /// What the run was.
    pub manifest: Manifest,
    /// Where it is repeated from.
    pub snapshot: Snapshot,
    /// What came from outside after the snapshot, in its order.
    pub events: Vec<Event>,
    /// What was known of the energy of the run at the snapshot, if it was watched.
    pub energy: Option<EnergyState>,
    /// A PNG of the last good tick.
    pub picture: Option<Vec<u8>>,
}

/// Something that was done to a run from outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Ticks that had been simulated.
    pub tick: u64,
    /// What it was.
    pub what: Change,
}

impl Event {
    /// Bytes of memory that it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let list = match &self.what {
            Change::Requests(requests) => requests.capacity() * size_of::<Request<u32>>(),
            _ => 0,
        };
        size_of::<Self>() + list
    }
}

impl Bundle {
    /// The scene, with the settings of the run, known in messages as `name`.
    ///
    /// # Errors
    /// A text that this program does not read as a scene.
    pub fn scene(&self, name: &str) -> Result<Scene, SceneError> {
        let mut scene = Scene::parse(name, &self.scene)?;
        self.manifest.settings.apply(&mut scene);
        scene.name.clone_from(&self.manifest.scene);
        Ok(scene)
    }
}
