//! Accuracy and cost, measured on a copy of the running scene.

pub(crate) mod panel;
pub(crate) mod state;
