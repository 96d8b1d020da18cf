//! What accuracy costs: the measuring measured.

mod measuring;
pub mod oscillator;
mod panel;
mod precision;
mod references;
mod timing;
