//! Graphs: quantities of bodies and of their ghosts over the last seconds.

mod panel;
mod state;
mod table;

use egui::{Align2, Ui};
use motion::clock::StepClock;

use crate::stage::Stage;
use crate::tools::tool::{Anchor, Desk, Tool};

pub(crate) use state::Graphs;

impl Tool for Graphs {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::RIGHT_TOP, [-8.0, 100.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        panel::show(ui, self, desk);
    }

    /// Finds the kept bodies by name if the scene has another text.
    fn next_scene(&mut self, rewritten: bool) {
        match rewritten {
            true => self.renamed = true,
            false => *self = Self::default(),
        }
    }

    fn restart(&mut self, stage: &Stage) {
        if std::mem::take(&mut self.renamed) {
            self.rebind_by_name(stage);
        }
        self.go_to(stage.sim().world.resource::<StepClock>().scene_seconds());
    }
}
