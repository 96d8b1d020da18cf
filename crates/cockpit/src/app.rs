//! A session: a stage, its view and its tools, and the input of a person or a script.

pub mod arrangement;
pub mod bundle;
mod cockpit;
mod fingers;
pub mod focus;
mod hands;
mod held;
mod layout;
pub mod player;
pub mod script;
pub mod session;
#[cfg(test)]
mod tests;
pub mod ui;
