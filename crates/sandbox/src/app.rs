//! A session: a stage, its view and its tools, and the input of a person or a script.

pub(crate) mod arrangement;
pub(crate) mod bundle;
mod cockpit;
mod fingers;
pub(crate) mod focus;
mod hands;
mod held;
mod layout;
pub mod player;
pub(crate) mod script;
pub(crate) mod session;
#[cfg(test)]
mod tests;
pub(crate) mod ui;
