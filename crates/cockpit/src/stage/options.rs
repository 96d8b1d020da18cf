//! Options of a session: drawing, pace, and overrides of scenes.

use history::Overrides;
use scene::Scene;

use crate::refused::Refused;

/// Checks that `scene` can have `overrides`.
///
/// # Errors
/// A method that cannot solve one of its laws.
pub fn check(overrides: Overrides, scene: &Scene) -> Result<(), Refused> {
    match overrides.unsolvable(scene) {
        Some(why) => Err(Refused(format!("{}: {why}; take another method", scene.name))),
        None => Ok(()),
    }
}

/// The words written over the scene. Any value but `All` gives the picture the program's own look instead of the tutorial's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Words {
    /// The tutorial's words, the state of the run, and labels.
    #[default]
    All,
    /// The caption of the scene, its time, and labels.
    Captions,
    /// The labels of bodies, and the effects of pushes and pulls.
    Labels,
    /// [`Self::Labels`] on white and without panels, for paper.
    Paper,
    /// No words.
    None,
}

/// Options of a session.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Initial size of the picture, pixels; later the view has the size.
    pub size_px: [u32; 2],
    /// Whether frames are drawn; without pictures the panels are laid out only while one is open.
    pub pictures: bool,
    /// Words over the scene.
    pub words: Words,
    /// Whether poses between two ticks are drawn and picked. A run without input and pictures needs no such poses.
    pub interpolate: bool,
    /// Longest frame that is caught up with, s; 0.25 s if `None`.
    pub catch_up: Option<f64>,
    /// Initial simulated seconds per second of frame time; overrides the scene.
    pub pace: Option<f64>,
    /// Whether the session starts paused.
    pub paused: bool,
    /// Overrides of every scene.
    pub overrides: Overrides,
    /// Number of threads that integrate, at least 1.
    pub threads: usize,
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
            threads: 1,
        }
    }
}
