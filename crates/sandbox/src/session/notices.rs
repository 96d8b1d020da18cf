//! What a session tells the person after its ticks.

use motion::{Cause, Evaluations, Fault, Quarantine, QuarantineRecord};

use super::{QuarantinedBody, Session};

/// So many quarantined bodies of a world are told of, one by one.
const TOLD: usize = 3;

impl Session {
    pub(super) fn note_quarantined(&mut self) {
        let seen = self.records_seen;
        let records = self.world.resource::<Quarantine>().records()[seen..].to_vec();
        self.records_seen += records.len();
        for (number, QuarantineRecord { body, tick, cause, .. }) in (seen..).zip(records) {
            let (body, what, Cause { system, component, fault }) = (self.name(body), cause.what(), cause);
            if number < TOLD {
                self.ui.notice(format!("{body} was quarantined in tick {tick}: {what}"));
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

    pub(super) fn note_unconverged(&mut self) {
        let steps = self.world.resource::<Evaluations>().unconverged_steps();
        if steps > 0 && !self.unconverged_told {
            self.unconverged_told = true;
            self.ui.notice("an implicit step did not converge; a higher step rate may help".to_owned());
        }
    }
}
