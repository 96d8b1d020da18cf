//! Effects: what acts, why, and at what cost.

mod panel;
mod state;

pub use state::SwitchedBy;
pub(crate) use state::{ENERGY_WATCH, Effects, picture_rows};
