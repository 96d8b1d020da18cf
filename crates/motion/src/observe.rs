//! Observation: what is computed from a world and changes nothing in it, such as the ledger and the forecast.

pub(crate) mod cached_accelerations;
pub(crate) mod forces_on;
pub(crate) mod forecast;
pub(crate) mod law_texts;
pub(crate) mod ledger;
pub(crate) mod totals;
