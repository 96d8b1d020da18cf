//! The study of accuracy and cost of the running scene: on a copy, a little in every frame.

use history::RunSettings;
use lab::cost::{Bench, Study};
use motion::Method;
use motion::effects::Effect;
use scene::Substepping;

use crate::stage::Stage;

/// Part of a frame's time that the study may take.
pub(super) const SHARE: f64 = 0.1;

/// Longest frame time to which [`SHARE`] applies, s, so that one hitch does not cause another.
pub(super) const LONGEST_FRAME: f64 = 0.05;

/// A study of the scene with its present settings.
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

/// The settings on which the result of a study of the running scene depends: not method and substeps, which the study varies, and
/// with gravity on or off as in the scene.
pub(super) fn settings(stage: &Stage) -> RunSettings {
    let now = RunSettings::of(stage.sim());
    let mut settings =
        RunSettings { method: Method::default(), substeps: Substepping::Fixed(1), ..now };
    if let Some(gravity) = &mut settings.effects.gravity {
        gravity.on = stage.sim().scene.gravity.is_none_or(|there| there.on);
    }
    settings.effects.off.retain(|effect| *effect != Effect::Gravity);
    settings
}
