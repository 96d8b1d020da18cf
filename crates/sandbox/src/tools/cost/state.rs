//! What accuracy costs in the running scene: a study of a copy, a little in every frame.

use lab::cost::{Bench, Study};
use motion::effects::Effect;
use motion::{Damping, Gravity, TimeStep};

use crate::stage::Stage;

/// Part of a frame's time that the study may take.
pub(super) const SHARE: f64 = 0.1;

/// The longest frame of which that part is taken, s: a hitch is no reason for another.
pub(super) const LONGEST_FRAME: f64 = 0.05;

/// A study of the scene as it is set at present.
pub(crate) struct Live {
    pub bench: Bench,
    pub(super) of: Settings,
}

/// What a study would come out differently with.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Settings {
    pub gravity: Option<Gravity>,
    pub damping: Option<Damping>,
    pub step: f64,
    pub off: Vec<Effect>,
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

pub(super) fn settings(stage: &mut Stage) -> Settings {
    let off = stage.effects_off();
    let (scene, world) = (&stage.sim.scene, &stage.sim.world);
    Settings {
        // A study has it on in any case.
        gravity: world
            .get_resource::<Gravity>()
            .map(|gravity| Gravity { on: scene.gravity.is_none_or(|there| there.on), ..*gravity }),
        damping: world.get_resource::<Damping>().copied().or(scene.damping),
        step: world.resource::<TimeStep>().0,
        off: off.into_iter().filter(|effect| *effect != Effect::Gravity).collect(),
    }
}
