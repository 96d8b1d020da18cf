//! The ledger: where energy, momentum and angular momentum go.

mod panel;
mod state;

use egui::{Align2, Ui};

use crate::stage::{Origin, Stage};
use crate::tools::tool::{Anchor, Desk, Tool};

pub(crate) use state::Ledger;

impl Tool for Ledger {
    /// Puts the panel where other panels leave room.
    fn anchor(&self, open: &[&str]) -> Anchor {
        let any = |titles: [&str; 2]| titles.iter().any(|title| open.contains(title));
        match (any(["Effects", "Accuracy and cost"]), any(["Settings", "Ghosts"])) {
            (false, _) => (Align2::RIGHT_CENTER, [-8.0, 0.0]),
            (true, false) => (Align2::LEFT_CENTER, [8.0, 0.0]),
            (true, true) => (Align2::CENTER_BOTTOM, [0.0, -8.0]),
        }
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        if let Some(ledger) = self.kept() {
            ui.set_width(desk.width(panel::WIDTH));
            panel::show(ui, desk.stage, ledger, self.past(), self.points());
        }
    }

    /// Keeps `always`: a run that asked for a ledger asked for one of every scene.
    fn next_scene(&mut self, _: bool) {
        self.close();
    }

    fn restart(&mut self, stage: &Stage) {
        if stage.here().origin == Origin::Seek || !self.always {
            self.reopen(stage);
        }
    }

    fn begin_frame(&mut self, stage: &Stage, open: bool) {
        self.keep(stage, open || self.always);
        self.follow_method(stage);
    }

    fn before_tick(&mut self, stage: &Stage, _: bool) {
        self.follow_method(stage);
    }
}
