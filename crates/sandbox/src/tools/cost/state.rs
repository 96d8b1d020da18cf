//! What accuracy costs in the running scene: a study of a copy, a little in every frame.

use history::RunSettings;
use lab::cost::{Bench, Study};
use motion::Method;
use motion::effects::Effect;

use crate::stage::Stage;

/// Part of a frame's time that the study may take.
pub(super) const SHARE: f64 = 0.1;

/// The longest frame of which that part is taken, s: a hitch is no reason for another.
pub(super) const LONGEST_FRAME: f64 = 0.05;

/// A study of the scene as it is set at present.
pub(crate) struct Live {
    pub bench: Bench,
    pub(super) of: RunSettings,
}

/// The study of the running scene, while its panel is open.
#[derive(Default)]
pub(crate) struct Cost {
    pub(crate) live: Option<Live>,
}

impl Cost {
    /// The study of the running scene so far, while its panel is open.
    pub fn study(&self) -> Option<&Study> {
        self.live.as_ref().map(|live| live.bench.study())
    }

    /// The part of the study that is done, in [0, 1].
    pub fn progress(&self) -> f64 {
        self.live.as_ref().map_or(0.0, |live| live.bench.progress())
    }
}

/// What a study of the running scene would come out differently with: it has methods and substeps of its own, so that those of the run do not count, and gravity on if the scene has.
pub(super) fn settings(stage: &mut Stage) -> RunSettings {
    let now = RunSettings::of(&mut stage.sim);
    let mut settings = RunSettings { method: Method::default(), substeps: 1, ..now };
    if let Some(gravity) = &mut settings.effects.gravity {
        gravity.on = stage.sim.scene.gravity.is_none_or(|there| there.on);
    }
    settings.effects.off.retain(|effect| *effect != Effect::Gravity);
    settings
}
