//! The ledger: where energy and momentum go.

mod panel;
mod state;

pub(crate) use state::Ledger;
