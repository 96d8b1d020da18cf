//! Effects: what acts, why, and at what cost.

mod panel;
mod state;

use motion::Evaluations;

use crate::tools::tool::{Desk, Tool};
use crate::view::stage::Stage;

pub use state::SwitchedBy;
pub(crate) use state::{ENERGY_WATCH, Effects, picture_rows};

impl Tool for Effects {
    fn show(&mut self, desk: &mut Desk<'_>) {
        let rows = self.receipt(desk.stage);
        if panel::show(desk, &rows) {
            self.measure(desk.stage);
        }
    }

    /// Counts evaluations per step from here on: what was counted before was another world.
    fn restart(&mut self, stage: &mut Stage) {
        self.seen = (stage.ticks(), stage.sim.world.resource::<Evaluations>().laws().to_vec());
    }
}
