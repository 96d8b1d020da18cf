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
mod panels;
mod tools;
mod view;
mod window;

pub use app::player;
pub use app::rerun::Repetition;
pub use app::session::{Session, Simulated};
pub use app::ui::Control;
pub use commands::plan;
pub use input::SwitchedBy;
pub use output::{STDOUT_IS_CLOSED, files, report, tell};
pub use panels::{Panel, PanelRow};
pub use tools::forecast::ForecastRow;
pub use tools::ghosts::{GhostRow, GhostState};
pub use view::camera::Camera;
pub use view::options::{Options, Overrides};
pub use view::stage::{Measured, Mode, Order, QuarantinedBody, SceneFile, Stage};
