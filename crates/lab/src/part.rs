//! A part of a study that several machines share: the plain data of `part.json`, which is read again.

use scene::Scene;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use crate::cost::{Machine, Study};
use crate::recommend::Goal;
use crate::shard::Shard;
use crate::stability::CaseRow;

/// A part of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Version of this format: [`FORMAT`].
    pub format: u32,
    /// The command line that makes the whole study.
    pub command: String,
    /// XXH3-64 of the texts of all of its scenes, 16 hexadecimal digits.
    pub scenes_hash: String,
    /// Which part it is.
    pub shard: Shard,
    /// Where it was run.
    pub machine: Machine,
    /// Whether all of it was run.
    pub complete: bool,
    /// What was found.
    pub found: Found,
}

/// The results of a part of a study. Its pieces are those of the [shard](Part::shard), in their order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Found {
    /// Accuracy and cost: a study per subject.
    Cost(Vec<Study>),
    /// The survival matrix.
    Stability {
        /// Its rows.
        rows: Vec<CaseRow>,
    },
    /// Recommendations.
    Recommend {
        /// The scene, as the command line names it, and its text.
        scene: [String; 2],
        /// The goal of the recommendation.
        goal: Goal,
        /// Seconds over which errors are measured, if they were given.
        seconds: Option<f64>,
        /// A study per part of the scene.
        studies: Vec<Study>,
    },
}

/// [`Part::format`] of this program.
pub const FORMAT: u32 = 3;

impl Part {
    /// A part of the study that `command` makes of `scenes`, of which nothing was run yet.
    #[must_use]
    pub fn new<'s>(
        command: String,
        scenes: impl Iterator<Item = &'s Scene>,
        shard: Shard,
        found: Found,
    ) -> Self {
        let mut hash = Xxh3::new();
        for scene in scenes {
            hash.update(scene.text.as_bytes());
            hash.update(&[0]);
        }
        let scenes_hash = format!("{:016x}", hash.digest());
        Self {
            format: FORMAT,
            command,
            scenes_hash,
            shard,
            machine: Machine::here(),
            complete: false,
            found,
        }
    }

    /// Why two parts do not belong to one study, as the end of a sentence.
    #[must_use]
    pub fn differs(&self, other: &Self) -> Option<&'static str> {
        if self.machine.version != other.machine.version {
            Some("another version of the program")
        } else if self.command != other.command {
            Some("another command")
        } else if self.scenes_hash != other.scenes_hash {
            Some("other scenes")
        } else if self.shard.of() != other.shard.of() {
            Some("another number of shards")
        } else {
            None
        }
    }
}
