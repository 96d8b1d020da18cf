//! The inside of the sandbox's window, as a library: what a shell drives, on a desktop or elsewhere.
//!
//! It names no file, no thread, no terminal and no wall clock: a shell gives it [frames of input](input), carries out its
//! [orders](Order), and draws its [pictures](Session::picture).
//!
//! - [`Session`]: a running scene. A frame of input goes in; ticks are simulated; a frame for the renderer comes out.
//! - [`Stage`]: the run of a session, without any picture: simulation, clock, recording, selection, messages.
//! - [`View`]: the view of a stage: camera, pointer, what is drawn and what is under the pointer.
//! - [`Tools`]: the tools that can be opened beside the picture; [`Panel`] names each.
//! - [`input`] is what reaches a session from outside, [`actions`] the table of what keys, buttons and scripts can do, and
//!   [`player`] plays a script.

#![cfg_attr(test, allow(clippy::wildcard_enum_match_arm, reason = "a test is of some of them"))]

pub mod actions;
pub mod app;
pub mod clock;
pub mod input;
pub mod intent;
pub mod methods;
pub mod panels;
mod refused;
pub mod stage;
pub mod tools;
pub mod view;
mod words;

pub use app::bundle::Repetition;
pub use app::focus::pointable;
pub use app::player;
pub use app::session::Session;
pub use app::ui::Control;
pub use input::SwitchedBy;
pub use panels::{Panel, PanelRow};
pub use refused::Refused;
pub use stage::options::{Options, Words};
pub use stage::quarantines::QuarantinedBody;
pub use stage::{Order, SceneFile, Simulated, Stage};
pub use tools::Tools;
pub use tools::ghosts::{GhostRow, GhostState};
pub use tools::learn::LessonState;
pub use view::camera::Camera;
pub use view::{Measured, Mode, View};
