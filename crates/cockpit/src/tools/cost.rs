//! Accuracy and cost, measured on a copy of the running scene.

mod panel;
mod state;

use egui::{Align2, Ui};
use history::RunSettings;
use lab::cost::{Bench, Plan, Subject};
use scene::Scene;

use self::state::{LONGEST_FRAME, Live, SHARE, settings};
use crate::clock::FrameTime;
use crate::stage::Stage;
use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::View;

pub(crate) use state::Cost;

impl Tool for Cost {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::RIGHT_BOTTOM, [-8.0, -8.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        if panel::show(ui, self, desk) {
            // The next frame begins another study.
            self.live = None;
        }
    }

    /// Works on the study for its part of a frame.
    fn after_ticks(&mut self, stage: &mut Stage, _: &View, open: bool, time: FrameTime) {
        if !open {
            return;
        }
        let settings = settings(stage);
        if self.live.as_ref().is_none_or(|live| live.of != settings) {
            let mut scene = Scene::clone(&stage.sim().scene);
            let (method, substeps) = (scene.method, scene.substeps);
            RunSettings { method, substeps, ..settings.clone() }.apply(&mut scene);
            let subject = Subject::of_scene(scene, None);
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
