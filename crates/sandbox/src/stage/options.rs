//! Options of a session: how it draws and paces, and what it changes of scenes.

use motion::{DampingModel, Method};
use scene::{Scene, unsolvable};

use crate::failure::Failure;

/// Changes that a run makes to every scene that it opens.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Method of the scene; bodies with a method of their own keep it.
    pub method: Option<Method>,
    /// Ticks per second, positive and finite.
    pub step_hz: Option<f64>,
    /// Damping model, where the scene declares damping.
    pub damping: Option<DampingModel>,
    /// Substeps per tick, at least 1; bodies with their own substeps keep them.
    pub substeps: Option<u32>,
}

impl Overrides {
    /// Whether `scene` can be changed so.
    ///
    /// # Errors
    /// A method that cannot solve one of its laws.
    pub fn check(self, scene: &Scene) -> Result<(), Failure> {
        match self.method.and_then(|method| unsolvable(method, scene.mutual_gravity.is_some())) {
            Some(why) => Err(Failure::Usage(format!("{}: {why}; take another method", scene.name))),
            None => Ok(()),
        }
    }

    /// Changes `scene`.
    pub fn apply(self, scene: &mut Scene) {
        let solves = |method: &Method| unsolvable(*method, scene.mutual_gravity.is_some()).is_none();
        scene.method = self.method.filter(solves).unwrap_or(scene.method);
        scene.step_hz = self.step_hz.unwrap_or(scene.step_hz);
        scene.substeps = self.substeps.unwrap_or(scene.substeps);
        if let (Some(damping), Some(model)) = (&mut scene.damping, self.damping) {
            damping.model = model;
        }
    }
}

/// Options of a session.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Size of the picture, pixels.
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
