//! Experiments on whole scenes: what each effect of a scene does and costs.
//!
//! Runs are worlds of their own, made from a scene as often as needed, on one thread. Time is thread CPU time and
//! nothing but a report of costs reads it.

mod ablation;
mod memory;
mod receipt;
mod run;

pub use ablation::{Ablation, Absence, ablate};
pub use receipt::{Receipt, Row, because, look, receipt, receipt_without};
