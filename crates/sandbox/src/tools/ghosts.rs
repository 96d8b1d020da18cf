//! Ghosts: the same run by every method, beside a fine reference.

mod edges;
mod panel;
mod picture;
mod state;

pub(crate) use state::Ghosts;
pub use state::{GhostRow, GhostState};
