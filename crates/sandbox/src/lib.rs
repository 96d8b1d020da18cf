//! The physics sandbox as a library: sessions, headless runs, the window and the command line.
//!
//! - [`Session`]: a running scene. A frame of input goes in; ticks are simulated; a frame for the renderer comes out.
//! - [`Stage`]: the run of a session, without any picture: simulation, clock, recording, selection, messages.
//! - [`View`]: the view of a stage: camera, pointer, what is drawn and what is under the pointer.
//! - [`Tools`]: the tools that can be opened beside the picture; [`Panel`] names each.
//! - [`input`] is what reaches a session from outside, [`actions`] the table of what keys, buttons and scripts can do, and
//!   [`player`] plays a script.
//! - [`commands`]: the command line. [`report`] is what runs write.
//!
//! Does not include: physics (`motion`), file formats (`scene`), rays (`pick`), pixels (`render`).

pub mod actions;
mod app;
mod args;
pub mod clock;
pub mod commands;
mod failure;
pub mod input;
mod intent;
pub mod methods;
mod output;
mod panels;
mod stage;
mod tools;
mod view;
mod window;

pub use app::bundle::Repetition;
pub use app::focus::pointable;
pub use app::player;
pub use app::session::Session;
pub use app::ui::Control;
pub use commands::plan;
pub use history::Overrides;
pub use input::SwitchedBy;
pub use output::files::end_without_memory;
pub use output::{STDOUT_IS_CLOSED, report, tell};
pub use panels::{Panel, PanelRow};
pub use stage::options::{Options, Words};
pub use stage::quarantines::QuarantinedBody;
pub use stage::{Order, SceneFile, Simulated, Stage};
pub use tools::Tools;
pub use tools::ghosts::{GhostRow, GhostState};
pub use tools::learn::LessonState;
pub use view::camera::Camera;
pub use view::{Measured, Mode, View};
