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

/// Which words are written over the scene. Without all of them, the picture has the program's own look instead of the tutorial's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Words {
    /// The tutorial's, the state of the run, and labels.
    #[default]
    All,
    /// What the scene shows, its time, and labels.
    Captions,
    /// The labels of bodies, and what pushes and pulls do.
    Labels,
    /// As [`Self::Labels`], on white and without panels: for paper.
    Paper,
    /// None.
    None,
}

/// Options of a session.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Size of the picture at the start, pixels; later it is the view's.
    pub size_px: [u32; 2],
    /// Whether frames are drawn; without pictures the panels are laid out only while one is open.
    pub pictures: bool,
    /// Words over the scene.
    pub words: Words,
    /// Whether poses between two ticks are drawn and picked. A run without input and pictures needs none.
    pub interpolate: bool,
    /// Longest frame that is caught up with, s, if not the usual quarter of a second.
    pub catch_up: Option<f64>,
    /// Simulated seconds per second of frame time at the start, if not those of the scene.
    pub pace: Option<f64>,
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
            words: Words::All,
            interpolate: true,
            catch_up: None,
            pace: None,
            paused: false,
            overrides: Overrides::default(),
            threads: None,
        }
    }
}
