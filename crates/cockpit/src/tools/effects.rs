//! Effects: which are on, why, and at what cost.

mod panel;
mod state;

use egui::{Align2, Ui};

use crate::clock::FrameTime;
use crate::stage::Stage;
use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::View;

pub use state::{ENERGY_WATCH, Effects, picture_rows};

impl Tool for Effects {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::RIGHT_CENTER, [-8.0, 0.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let rows = self.receipt(desk.stage, desk.view);
        if panel::show(ui, desk, &rows, self.measures()) {
            self.measure(desk.stage);
        }
    }

    fn after_ticks(&mut self, stage: &mut Stage, _: &View, open: bool, _: FrameTime) {
        if open {
            self.continue_measuring(stage);
        }
    }

    fn works(&self) -> bool {
        self.measures()
    }

    /// Counts evaluations per step from here on: earlier counts are of another world.
    fn restart(&mut self, stage: &Stage) {
        self.seen = (stage.sim().ticks(), stage.sim().evaluations().laws().to_vec());
    }
}
