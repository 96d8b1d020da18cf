//! What a session tells the person after its ticks.

use motion::{Cause, Evaluations, Fault, Quarantine, QuarantineRecord};

use crate::app::session::{QuarantinedBody, Session};
use crate::app::ui::Topic;

/// So many quarantined bodies of a world are told of, one by one.
const TOLD: usize = 3;

impl Session {
    pub(crate) fn note_quarantined(&mut self) {
        let seen = self.records_seen;
        let records = self.sim.world.resource::<Quarantine>().records()[seen..].to_vec();
        self.records_seen += records.len();
        for (number, QuarantineRecord { body, tick, cause, .. }) in (seen..).zip(records) {
            let (body, what, Cause { system, component, fault }) = (self.name(body), cause.what(), cause);
            if number < TOLD {
                self.notice(format!("{body} was quarantined in tick {tick}: {what}"));
            }
            let cause = match fault {
                Fault::Law(law) => format!("law {law}"),
                Fault::Spring(other) => format!("spring to {}", self.name(other)),
                fault => fault.name().to_owned(),
            };
            // A run that goes on from the past may repeat what came after.
            if self.quarantined.len() == self.quarantined_before + number {
                self.quarantined.push(QuarantinedBody { body, tick, what, system, component, cause });
            }
        }
    }

    pub(crate) fn note_unconverged(&mut self) {
        let steps = self.unconverged();
        if self.unconverged_before.take_if(|before| steps > *before).is_some() {
            let what = "an implicit step did not converge; a higher step rate may help";
            self.ui.notice(Topic::Unconverged, what.to_owned());
        }
    }

    fn unconverged(&self) -> u64 {
        self.sim.world.resource::<Evaluations>().unconverged_steps()
    }

    /// Begins to count steps that do not converge.
    pub(crate) fn count_unconverged_from_now(&mut self) {
        self.unconverged_before = Some(self.unconverged());
    }
}
