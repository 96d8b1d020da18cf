//! Ghosts: the same run by every method, beside a fine reference.

mod edges;
pub(crate) mod panel;
mod picture;
pub(crate) mod state;
