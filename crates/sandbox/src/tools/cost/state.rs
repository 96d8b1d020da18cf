//! What accuracy costs in the running scene: a study of a copy, a little in every frame.

use lab::cost::{Bench, Plan, Study, Subject};
use motion::clock::FrameTime;
use motion::effects::{Effect, EffectState};
use motion::{Damping, Gravity, TimeStep};
use scene::Scene;

use crate::tools::cost::panel::{self, Axes};
use crate::tools::tool::{Desk, Tool};
use crate::view::stage::Stage;

/// Part of a frame's time that the study may take.
pub(crate) const SHARE: f64 = 0.1;

/// The longest frame of which that part is taken, s: a hitch is no reason for another.
const LONGEST_FRAME: f64 = 0.05;

/// A study of the scene as it is set at present.
struct Live {
    bench: Bench,
    of: Settings,
}

/// What a study would come out differently with.
#[derive(Clone, Debug, PartialEq)]
struct Settings {
    gravity: Option<Gravity>,
    damping: Option<Damping>,
    step: f64,
    off: Vec<Effect>,
}

/// The study of the running scene, and how its panel shows it.
#[derive(Default)]
pub(crate) struct Cost {
    live: Option<Live>,
    pub(super) axes: Axes,
}

impl Cost {
    /// The study of the running scene so far, while its panel is open.
    pub fn study(&self) -> Option<&Study> {
        self.live.as_ref().map(|live| live.bench.study())
    }

    /// What is done of the study, in [0, 1].
    pub fn progress(&self) -> f64 {
        self.live.as_ref().map_or(0.0, |live| live.bench.progress())
    }
}

impl Tool for Cost {
    fn show(&mut self, desk: &mut Desk<'_>) {
        if panel::show(self, desk) {
            // The next frame begins another study.
            self.live = None;
        }
    }

    /// Goes on with the study for its part of a frame.
    fn after_ticks(&mut self, stage: &mut Stage, open: bool, time: FrameTime) {
        if !open {
            return;
        }
        let settings = settings(stage);
        if self.live.as_ref().is_none_or(|live| live.of != settings) {
            let mut scene = Scene::clone(&stage.sim.scene);
            (scene.gravity, scene.damping) = (settings.gravity, settings.damping);
            scene.step_hz = 1.0 / settings.step;
            let subject = Subject::of_scene(scene, None).without(settings.off.clone());
            self.live = Some(Live { bench: Bench::new(subject, Plan::live()), of: settings });
        }
        if let Some(live) = &mut self.live {
            live.bench.work(time.length().min(LONGEST_FRAME) * SHARE);
        }
    }

    fn works(&self) -> bool {
        self.progress() < 1.0
    }
}

fn settings(stage: &mut Stage) -> Settings {
    let off = |effect: &Effect| motion::effects::state(&mut stage.sim.world, *effect) == EffectState::Off;
    let off: Vec<_> = Effect::ALL.into_iter().filter(off).collect();
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
