//! A session: a scene that runs, what a person does to it, and the panels beside it.

pub(crate) mod control;
mod held;
mod notices;
pub(crate) mod panels;
pub(crate) mod past;
pub mod player;
mod repeat;
pub(crate) mod rerun;
pub(crate) mod rest;
pub(crate) mod script;
pub(crate) mod session;
pub(crate) mod ui;
pub(crate) mod worlds;
