//! A session: a stage, its view and its tools, and the input of a person or a script.

pub mod arrangement;
pub mod bundle;
mod cockpit;
mod fingers;
pub mod focus;
pub mod frame_loop;
mod hands;
mod held;
mod layout;
pub mod pictures;
pub mod player;
pub mod pupil;
pub mod script;
pub mod session;
mod speed;
#[cfg(test)]
mod tests;
pub mod ui;
