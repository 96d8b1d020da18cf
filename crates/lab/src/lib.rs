//! Experiments on whole scenes: what each effect of a scene does and costs, and what other methods make of it.
//!
//! Runs are worlds of their own, made from a scene as often as needed, on one thread. Time is thread CPU time and
//! nothing but a report of costs reads it.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test"))]

mod ablation;
mod attraction;
pub mod cost;
mod distances;
mod input;
pub mod limits;
mod receipt;
pub mod recommend;
mod run;
pub mod stability;
mod timeline;
mod twin;

pub use ablation::{Ablation, Absence, ablate};
pub use attraction::{AttractionTick, attraction_tick};
pub use distances::{Bodies, Distances};
pub use input::{Input, asked, give, pending};
pub use receipt::{Receipt, Row, because, look, receipt, receipt_without};
pub use run::watch_time;
pub use timeline::{
    BadRerun, Broken, ENERGY_JUMP, Fault, Journey, Replay, Rerun, TIMELINE_BYTES, TIMELINE_SECONDS, Timeline,
    Watch, happen,
};
pub use twin::{Failure, Leader, REFERENCE_METHOD, REFERENCE_SUBSTEPS, Twin};
