//! Studies of whole runs: what effects do and cost, what accuracy costs, which method is cheapest, and what survives.
//!
//! Each run has its own world, made from a scene as often as needed. Time is thread CPU time of one thread.
//!
//! - [`cost`]: every method at every step on a problem or a scene, its error beside its cost, and what is cheapest at an error.
//! - [`recommend`]: the cheapest method and substeps below an error, or the most accurate within a time, for each part of a scene.
//! - [`stability`]: the survival matrix, every method on every hard case.
//! - [`receipt`](receipt()): each effect of a scene, and what it costs; [`ablate`]: the scene run again without each effect in turn.
//! - [`lesson`]: what lessons measure.
//! - [`sweep`]: a scene run once for every combination of the given values. [`Shard`]: the parts that a sweep
//!   is divided into for several machines. [`Column`]: a column of a table for other programs.
//! - `run`: what these share: a running scene, and the time of its steps.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test"))]

mod ablation;
mod clock;
mod column;
pub mod cost;
mod jobs;
pub mod lesson;
mod ordered;
mod receipt;
pub mod recommend;
mod run;
mod shard;
pub mod stability;
pub mod sweep;
pub mod trial;

pub use ablation::{Ablation, Absence, ablate};
pub use clock::IS_THREAD_TIME;
pub use column::{Column, Kind, Value};
pub use receipt::{Receipt, ReceiptLine, ReceiptRun, receipt, receipt_without_running};
pub use run::{AttractionTick, ByEffect, attraction_tick, watch_time};
pub use shard::Shard;
