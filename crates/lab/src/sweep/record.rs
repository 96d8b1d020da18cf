//! The plan and record of a sweep: the plain data of `sweep.json`, which is read again.

use scene::Keeps;
use serde::{Deserialize, Serialize};

use super::axis::Axis;
use super::measure::Measure;
use crate::column::{Column, Kind};
use crate::shard::Shard;

/// The plan of a sweep, as it is written beside its table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// What varies. The last axis varies fastest: each run has its next value, or its first value and the next one of
    /// the axis before it.
    pub axes: Vec<Axis>,
    /// Length of each run, s.
    pub seconds: f64,
    /// What is measured, in the order of the columns.
    pub measures: Vec<Measure>,
}

impl Plan {
    /// Number of runs; `None` if it exceeds `u64`.
    #[must_use]
    pub fn runs(&self) -> Option<u64> {
        self.axes.iter().try_fold(1_u64, |runs, axis| runs.checked_mul(axis.values.len() as u64))
    }

    /// For each axis, the index of its value in run number `run`.
    #[must_use]
    pub fn indices(&self, mut run: u64) -> Vec<usize> {
        let mut indices: Vec<_> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let length = axis.values.len() as u64;
                let index = run % length;
                run /= length;
                index as usize
            })
            .collect();
        indices.reverse();
        indices
    }

    /// The values of run number `run`, one for each axis.
    #[must_use]
    pub fn values(&self, run: u64) -> Vec<&str> {
        let indices = self.indices(run);
        self.axes.iter().zip(indices).map(|(axis, index)| &*axis.values[index]).collect()
    }

    /// What a run keeps for its measures.
    pub(super) fn keeps(&self) -> Keeps {
        let measures = |measure| self.measures.contains(&measure);
        Keeps {
            ledger: measures(Measure::Drift),
            // A trial has its start, two finer runs and its own run, and ends before the others begin.
            compared: Some(if measures(Measure::Survives) {
                4
            } else if measures(Measure::Error) {
                2
            } else {
                0
            }),
            ..Keeps::default()
        }
    }

    /// The columns of the table of runs: `run`, from 0, a column for each axis with its place as name, `outcome`, `why` and
    /// those of the measures.
    #[must_use]
    pub fn columns(&self) -> Vec<Column> {
        let of_axes = self.axes.iter().map(|axis| {
            Column::new(
                &axis.place,
                if axis.numbers().is_some() { Kind::Number } else { Kind::Text },
            )
        });
        let outcome = ["outcome", "why"].map(|name| Column::new(name, Kind::Text));
        let simulated = Column::new("simulated_s", Kind::Number);
        let measured = self.measures.iter().flat_map(|measure| measure.columns());
        std::iter::once(Column::new("run", Kind::Count))
            .chain(of_axes)
            .chain(outcome)
            .chain([simulated])
            .chain(measured.map(|(name, kind)| Column::new(*name, *kind)))
            .collect()
    }
}

/// The record that is written beside a table of runs, in `sweep.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Version of this format: [`FORMAT`].
    pub format: u32,
    /// Version of the program.
    pub version: String,
    /// The scene, as the command line names it.
    pub scene: String,
    /// XXH3-64 of its text, 16 hexadecimal digits.
    pub scene_hash: String,
    /// What is run.
    #[serde(flatten)]
    pub plan: Plan,
    /// Which part of the sweep was run.
    pub shard: Shard,
    /// The processors that it was run on.
    pub processors: Vec<String>,
    /// Whether every run is in the table.
    pub complete: bool,
    /// XXH3-64 of the complete table, 16 hexadecimal digits.
    pub table_hash: Option<String>,
}

/// [`Record::format`] of this program.
pub const FORMAT: u32 = 2;

impl Record {
    /// Why two records do not belong to one sweep, as the end of a sentence.
    #[must_use]
    pub fn differs(&self, other: &Self) -> Option<&'static str> {
        if self.format != other.format || self.version != other.version {
            Some("another version of the program")
        } else if self.scene_hash != other.scene_hash {
            Some("another scene")
        } else if self.plan.axes != other.plan.axes {
            Some("other values")
        } else if self.plan.seconds != other.plan.seconds {
            Some("runs of another length")
        } else if self.plan.measures != other.plan.measures {
            Some("other measures")
        } else if self.shard.of() != other.shard.of() {
            Some("another number of shards")
        } else {
            None
        }
    }
}
