//! Options of a session: how it draws and paces, and what it changes of scenes.

use history::Overrides;
use scene::Scene;

use crate::failure::Failure;

/// Whether `scene` can have `overrides`.
///
/// # Errors
/// A method that cannot solve one of its laws.
pub(crate) fn check(overrides: Overrides, scene: &Scene) -> Result<(), Failure> {
    match overrides.unsolvable(scene) {
        Some(why) => Err(Failure::Usage(format!("{}: {why}; take another method", scene.name))),
        None => Ok(()),
    }
}

/// Options of a session.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Size of the picture at the start, pixels; later it is the view's.
    pub size_px: [u32; 2],
    /// Whether frames are drawn; without pictures the panels are laid out only while one is open.
    pub pictures: bool,
    /// Whether words are written over the scene.
    pub hud: bool,
    /// Whether poses between two ticks are drawn and picked. A run without input and pictures needs none.
    pub interpolate: bool,
    /// Longest frame that is caught up with, s, if not the usual quarter of a second.
    pub catch_up: Option<f64>,
    /// Simulate nothing until told so.
    pub paused: bool,
    /// Changes of every scene.
    pub overrides: Overrides,
    /// Threads that integrate, at least 1, if not the usual number.
    pub threads: Option<usize>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            size_px: [1280, 720],
            pictures: true,
            hud: true,
            interpolate: true,
            catch_up: None,
            paused: false,
            overrides: Overrides::default(),
            threads: None,
        }
    }
}
