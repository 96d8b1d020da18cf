//! What accuracy costs in the running scene: a study of a copy, a little in every frame.

use std::sync::Arc;

use history::Intervention;
use lab::cost::{Bench, Plan, Setting, Study, Subject};
use motion::clock::FrameTime;
use motion::effects::{Effect, EffectState};
use motion::{Damping, Gravity, Substeps, TimeStep};
use scene::Scene;

use crate::app::session::Session;
use crate::app::ui::{Panel, Topic};

/// Part of a frame's time that the study may take.
pub(crate) const SHARE: f64 = 0.1;

/// The longest frame of which that part is taken, s: a hitch is no reason for another.
const LONGEST_FRAME: f64 = 0.05;

/// A study of the scene as it is set at present.
pub(crate) struct LiveCost {
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

impl Session {
    /// The study of the running scene so far, while its panel is open.
    #[must_use]
    pub fn cost_study(&self) -> Option<&Study> {
        self.cost.as_ref().map(|cost| cost.bench.study())
    }

    /// What is done of the study, in [0, 1].
    #[must_use]
    pub fn cost_progress(&self) -> f64 {
        self.cost.as_ref().map_or(0.0, |cost| cost.bench.progress())
    }

    /// Method and substeps of the bodies without their own.
    #[must_use]
    pub fn setting(&self) -> Setting {
        Setting {
            method: self.sim.method(),
            substeps: self.sim.world.get_resource::<Substeps>().map_or(1, |substeps| substeps.0.max(1)),
            precision: lab::cost::Precision::F64,
        }
    }

    /// Goes on with another method and number of substeps of the scene.
    pub fn apply_setting(&mut self, setting: Setting) {
        Arc::make_mut(&mut self.sim.scene).substeps = setting.substeps;
        self.record(Intervention::Substeps(setting.substeps));
        self.ui.retract(Topic::Forecast);
        self.sim.world.insert_resource(Substeps(setting.substeps));
        self.set_method(setting.method);
        self.restart_ghosts();
    }

    /// Begins the study anew.
    pub(crate) fn measure_cost(&mut self) {
        self.cost = None;
    }

    /// Goes on with the study for its part of a frame.
    pub(crate) fn work_on_cost(&mut self, time: FrameTime) {
        if !self.ui.shows(Panel::Cost) {
            return;
        }
        let settings = self.cost_settings();
        if self.cost.as_ref().is_none_or(|cost| cost.of != settings) {
            let mut scene = Scene::clone(&self.sim.scene);
            (scene.gravity, scene.damping) = (settings.gravity, settings.damping);
            scene.step_hz = 1.0 / settings.step;
            let subject = Subject::of_scene(scene, None).without(settings.off.clone());
            self.cost = Some(LiveCost { bench: Bench::new(subject, Plan::live()), of: settings });
        }
        if let Some(cost) = &mut self.cost {
            cost.bench.work(time.length().min(LONGEST_FRAME) * SHARE);
        }
    }

    fn cost_settings(&mut self) -> Settings {
        let off = |effect: &Effect| motion::effects::state(&mut self.sim.world, *effect) == EffectState::Off;
        let off: Vec<_> = Effect::ALL.into_iter().filter(off).collect();
        let gravity = self.sim.world.get_resource::<Gravity>();
        Settings {
            // A study has it on in any case.
            gravity: gravity.map(|gravity| Gravity {
                on: self.sim.scene.gravity.is_none_or(|there| there.on),
                ..*gravity
            }),
            damping: self.sim.world.get_resource::<Damping>().copied().or(self.sim.scene.damping),
            step: self.sim.world.resource::<TimeStep>().0,
            off: off.into_iter().filter(|effect| *effect != Effect::Gravity).collect(),
        }
    }
}
