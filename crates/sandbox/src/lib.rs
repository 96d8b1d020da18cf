//! The physics sandbox on a desktop: the window, headless runs and the command line around the library [`cockpit`].
//!
//! - [`commands`]: the command line. [`report`] is what runs write.

mod args;
pub mod commands;
mod failure;
mod output;
mod window;

pub use cockpit::{
    Camera, Control, GhostRow, GhostState, LessonState, Measured, Mode, Options, Order, Panel,
    PanelRow, QuarantinedBody, Repetition, SceneFile, Session, Simulated, Stage, SwitchedBy, Tools,
    View, Words, actions, clock, input, methods, player, pointable,
};
pub use commands::plan;
pub use history::Overrides;
pub use output::files::end_without_memory;
pub use output::{report, tell};
