//! A session: a scene that runs, what a person or a script does to it, and its tools.

mod arrangement;
mod camera;
mod changes;
mod cockpit;
mod control;
mod editing;
mod held;
mod layout;
mod past;
pub mod player;
pub(crate) mod rerun;
pub(crate) mod script;
pub(crate) mod session;
#[cfg(test)]
mod tests;
pub(crate) mod ui;
