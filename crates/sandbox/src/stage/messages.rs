//! Tells the person: notices, refusals and quarantined bodies, from the state of a stage.

use bevy_ecs::entity::Entity;
use motion::{Cause, Evaluations, Fault, Quarantine, QuarantineRecord};

use crate::stage::Stage;
use crate::stage::notices::{QuarantinedBody, Topic};

/// Refusals that wait to be told.
const MOST_REFUSALS: usize = 16;

/// So many quarantined bodies of a world are told of, one by one.
const TOLD: usize = 3;

impl Stage {
    /// Says something to the person for a few seconds.
    pub fn notice(&mut self, text: impl Into<String>) {
        self.notices.say(Topic::Other, text.into());
    }

    /// The present notices.
    pub fn notices(&self) -> impl Iterator<Item = &str> {
        self.notices.texts()
    }

    /// Says to the person, and to a run that no person looks at, that something was not done.
    pub(crate) fn refuse(&mut self, what: impl Into<String>) {
        self.refuse_about(Topic::Other, what);
    }

    pub(crate) fn refuse_about(&mut self, topic: Topic, what: impl Into<String>) {
        let what = what.into();
        if self.refusals.len() < MOST_REFUSALS {
            self.refusals.push(what.clone());
        }
        self.notices.say(topic, what);
    }

    pub(crate) fn note_quarantined(&mut self) {
        let seen = self.here.records_seen;
        let records = self.sim.world.resource::<Quarantine>().records()[seen..].to_vec();
        self.here.records_seen += records.len();
        let times = self.times();
        for (number, QuarantineRecord { body, tick, cause, .. }) in (seen..).zip(records) {
            let (body, what, Cause { system, component, fault }) = (self.name(body), cause.what(), cause);
            if number < TOLD {
                self.notice(format!("{body} was quarantined at {}: {what}", times.words(tick)));
            }
            let cause = match fault {
                Fault::Law(law) => format!("law {law}"),
                Fault::Spring(other) => format!("spring to {}", self.name(other)),
                fault => fault.name().to_owned(),
            };
            // A run that continues from the past may repeat what came after.
            if self.run.quarantined.len() == self.run.quarantined_before + number {
                self.run.quarantined.push(QuarantinedBody { body, tick, what, system, component, cause });
            }
        }
    }

    pub(crate) fn note_unconverged(&mut self) {
        let steps = self.sim.world.resource::<Evaluations>().unconverged_steps();
        if self.here.unconverged_before.take_if(|before| steps > *before).is_some() {
            let what = "an implicit step did not converge; a higher step rate may help";
            self.notices.say(Topic::Unconverged, what.to_owned());
        }
    }

    /// Every body that was quarantined in the run up to now, in earlier scenes and before a reset too, in that order.
    #[must_use]
    pub fn quarantined(&self) -> &[QuarantinedBody] {
        &self.run.quarantined[..self.quarantined_end()]
    }

    /// The same with those that the run has gone back before, and whose ticks it has not dropped.
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

    /// Those of this world.
    pub(crate) fn quarantined_here(&self) -> &[QuarantinedBody] {
        &self.run.quarantined[self.run.quarantined_before..self.quarantined_end()]
    }

    fn quarantined_end(&self) -> usize {
        let here = self.sim.world.resource::<Quarantine>().records().len();
        (self.run.quarantined_before + here).min(self.run.quarantined.len())
    }
}
