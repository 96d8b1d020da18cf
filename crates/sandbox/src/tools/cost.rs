//! Accuracy and cost, measured on a copy of the running scene.

mod panel;
mod state;

pub(crate) use state::Cost;
