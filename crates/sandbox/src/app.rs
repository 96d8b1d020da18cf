//! A session: a stage, how it is looked at and its tools, and what a person or a script does to them.

pub(crate) mod arrangement;
pub(crate) mod bundle;
mod cockpit;
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
