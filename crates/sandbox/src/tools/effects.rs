//! Effects: what acts, why, and at what cost.

pub(crate) mod panel;
pub(crate) mod state;
