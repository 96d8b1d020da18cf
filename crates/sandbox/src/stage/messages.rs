//! Messages to the person about the state of a stage: quarantined bodies and unconverged steps.

use std::borrow::Cow;

use bevy_ecs::entity::Entity;
use motion::{Cause, Evaluations, Fault, Quarantine, QuarantineRecord, StableId};

use crate::stage::Stage;
use crate::stage::notices::{QuarantinedBody, Topic};

/// Number of quarantined bodies per world that get a notice of their own.
const TOLD: usize = 3;

impl Stage {
    pub(crate) fn note_quarantined(&mut self) {
        let seen = self.here.records_seen;
        let records = self.sim.world.resource::<Quarantine>().records()[seen..].to_vec();
        self.here.records_seen += records.len();
        let times = self.times();
        for (number, QuarantineRecord { body, id, other_end, tick, cause }) in (seen..).zip(records)
        {
            // A body may have been removed since.
            let name = |id: Option<StableId>, body: Entity| {
                let name = id.and_then(|id| self.sim.scene.names.get(id.0)).map(Cow::into_owned);
                name.unwrap_or_else(|| self.name(body))
            };
            let (body, what, Cause { system, component, fault }) =
                (name(id, body), cause.what(), cause);
            let fault = match fault {
                Fault::Law(law) => format!("law {law}"),
                Fault::Spring(other) => format!("spring to {}", name(other_end, other)),
                fault => fault.name().to_owned(),
            };
            if number < TOLD {
                self.notices.say(
                    Topic::Other,
                    format!("{body} was quarantined at {}: {what}", times.words(tick)),
                );
            }
            // A run that continues from the past may repeat a quarantine that is already listed.
            if self.run.quarantined.len() == self.run.quarantined_before + number {
                self.run.quarantined.push(QuarantinedBody {
                    body,
                    tick,
                    what,
                    system,
                    component,
                    cause: fault,
                });
            }
        }
    }

    pub(crate) fn note_unconverged(&mut self) {
        let steps = self.sim.world.resource::<Evaluations>().unconverged_steps();
        if self.here.unconverged_before.take_if(|before| steps > *before).is_some() {
            let what = "an implicit step did not converge; a higher step rate may help";
            self.notices.say(Topic::Unconverged, what);
        }
    }

    /// All bodies quarantined in the run up to now, in order, including earlier scenes and the time before a reset.
    #[must_use]
    pub fn quarantined(&self) -> &[QuarantinedBody] {
        &self.run.quarantined[..self.quarantined_end()]
    }

    /// All quarantined bodies, including those ahead after going back whose ticks have not been dropped.
    #[must_use]
    pub fn all_quarantined(&self) -> &[QuarantinedBody] {
        &self.run.quarantined
    }

    /// When and by which system `body` was quarantined, in a few words.
    pub(crate) fn quarantined_because(&self, body: Entity) -> Option<String> {
        let records = self.sim.world.resource::<Quarantine>().records();
        let record = records.iter().find(|record| record.body == body)?;
        Some(format!("at {} by {}", self.times().words(record.tick), record.cause.system))
    }

    /// The quarantined bodies of this world.
    pub(crate) fn quarantined_here(&self) -> &[QuarantinedBody] {
        &self.run.quarantined[self.run.quarantined_before..self.quarantined_end()]
    }

    fn quarantined_end(&self) -> usize {
        let here = self.sim.world.resource::<Quarantine>().records().len();
        (self.run.quarantined_before + here).min(self.run.quarantined.len())
    }
}
