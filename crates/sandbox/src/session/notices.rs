//! What a session tells the person after its ticks.

use motion::{Cause, Evaluations, Fault, Quarantine, QuarantineRecord};

use super::{QuarantinedBody, Session};

impl Session {
    pub(super) fn note_quarantined(&mut self) {
        let records = &self.world.resource::<Quarantine>().records()[self.records_seen..];
        let records = records.to_vec();
        self.records_seen += records.len();
        for QuarantineRecord { body, tick, cause, .. } in records {
            let (body, what, Cause { system, component, fault }) = (self.name(body), cause.what(), cause);
            if self.quarantined.len() < 3 {
                self.ui.notice(format!("{body} was quarantined in tick {tick}: {what}"));
            }
            let cause = match fault {
                Fault::Law(law) => format!("law {law}"),
                Fault::Spring(other) => format!("spring to {}", self.name(other)),
                fault => fault.name().to_owned(),
            };
            self.quarantined.push(QuarantinedBody { body, tick, what, system, component, cause });
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
