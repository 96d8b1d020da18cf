//! The physics sandbox as a library: sessions, headless runs, the window and the command line.
//!
//! Does not include: physics (`motion`), file formats (`scene`), rays (`pick`), pixels (`render`).

pub mod actions;
mod app;
mod args;
pub mod commands;
mod failure;
pub mod input;
pub mod methods;
mod output;
mod tools;
mod view;
mod window;

/// Name and version of the program, for files that it writes.
pub(crate) const PROGRAM: &str = concat!("sandbox ", env!("CARGO_PKG_VERSION"));

pub use app::control::Mode;
pub use app::player;
pub use app::session::{
    ForecastRow, GhostRow, GhostState, Measured, Options, Order, Overrides, QuarantinedBody, Repetition,
    Session, Simulated, SwitchedBy,
};
pub use app::ui::Panel;
pub use commands::plan;
pub use output::{files, report};
pub use view::camera::Camera;
