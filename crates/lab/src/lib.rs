//! Experiments on whole scenes: what each effect of a scene does and costs, and what other methods make of it.
//!
//! Runs are worlds of their own, made from a scene as often as needed, on one thread. Time is thread CPU time and
//! nothing but a report of costs reads it.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test"))]

mod ablation;
pub mod cost;
pub mod limits;
mod receipt;
pub mod recommend;
mod run;
pub mod stability;

pub use ablation::{Ablation, Absence, ablate};
pub use receipt::{Receipt, ReceiptLine, look, receipt};
pub use run::{AttractionTick, ByEffect, attraction_tick, watch_time};
