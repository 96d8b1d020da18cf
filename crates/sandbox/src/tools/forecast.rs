//! The forecast: how near everything is to instability.

pub(crate) mod panel;
pub(crate) mod state;
