//! The ledger: where energy and momentum go.

pub(crate) mod panel;
pub(crate) mod state;
