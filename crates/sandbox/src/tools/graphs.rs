//! Graphs: how quantities of bodies, and of their ghosts, go over the last seconds.

mod panel;
mod state;
mod table;

use egui::{Align2, Ui};
use motion::clock::StepClock;

use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::stage::Stage;

pub(crate) use state::Graphs;

impl Tool for Graphs {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::RIGHT_TOP, [-8.0, 100.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        panel::show(ui, self, desk);
    }

    fn restart(&mut self, stage: &mut Stage) {
        self.go_to(stage.sim.world.resource::<StepClock>().scene_seconds());
    }
}
