//! Observation: the ledger, the forecast, totals and forces by cause. They read a world and change nothing in it.

pub(crate) mod forces_on;
pub(crate) mod law_texts;
pub(crate) mod ledger;
pub(crate) mod margin;
pub(crate) mod oscillator;
pub(crate) mod totals;
