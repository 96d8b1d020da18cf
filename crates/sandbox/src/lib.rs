//! The physics sandbox as a library: sessions, headless runs, the window and the command line.
//!
//! Does not include: physics (`motion`), file formats (`scene`), rays (`pick`), pixels (`render`).

mod ablate;
pub mod actions;
mod black_box;
mod bundle;
mod camera;
pub mod cli;
mod control;
mod cost;
mod effects;
mod extract;
mod failure;
pub mod files;
mod headless;
pub mod input;
mod instructions;
mod list;
pub mod methods;
mod panels;
pub mod plan;
pub mod player;
mod progress;
mod recommend;
mod replay;
pub mod report;
mod session;
mod stability;
mod trails;
mod ui;
mod window;

/// Name and version of the program, for files that it writes.
pub(crate) const PROGRAM: &str = concat!("sandbox ", env!("CARGO_PKG_VERSION"));

pub use camera::Camera;
pub use control::Mode;
pub use session::{
    ForecastRow, GhostRow, GhostState, Measured, Options, Order, Overrides, QuarantinedBody, Repetition,
    Session, Simulated, SwitchedBy,
};
pub use ui::Panel;
