//! The ledger: where energy and momentum go.

mod panel;
mod state;

use crate::tools::tool::{Desk, Tool};

pub(crate) use state::Ledger;

impl Tool for Ledger {
    fn show(&mut self, desk: &mut Desk<'_>) {
        if let Some(ledger) = self.kept() {
            panel::show(desk, ledger, self.points());
        }
    }
}
