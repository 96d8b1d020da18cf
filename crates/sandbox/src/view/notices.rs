//! What the person is told for a few seconds.

use motion::{Cause, Evaluations, Fault, Quarantine, QuarantineRecord};

use crate::view::stage::{QuarantinedBody, Stage};

/// How long a notice stays, s.
const NOTICE_S: f64 = 4.0;

/// Refusals that wait to be told.
const MOST_REFUSALS: usize = 16;

/// So many quarantined bodies of a world are told of, one by one.
const TOLD: usize = 3;

/// What a notice is about. Of each topic but the last there is one notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Topic {
    /// A file that was written or opened: true whatever is simulated.
    File,
    Fault,
    Forecast,
    Gravity,
    Ghosts,
    Method,
    /// Where in the last minute the run stands.
    Place,
    Speed,
    Unconverged,
    Other,
}

/// Words in the picture.
struct Notice {
    topic: Topic,
    text: String,
    /// When it goes, s; known once it is seen.
    until: Option<f64>,
}

/// The notices of a session, oldest first.
#[derive(Default)]
pub(crate) struct Notices(Vec<Notice>);

impl Notices {
    /// Says something for a few seconds, in place of what was said of its topic before.
    pub fn say(&mut self, topic: Topic, text: String) {
        if topic != Topic::Other {
            self.retract(topic);
        }
        self.0.push(Notice { topic, text, until: None });
    }

    /// Takes back what is no longer true.
    pub fn retract(&mut self, topic: Topic) {
        self.0.retain(|notice| notice.topic != topic);
    }

    /// Takes back what was said of a run that has come to its end.
    pub fn retract_run(&mut self) {
        self.0.retain(|notice| notice.topic == Topic::File);
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Drops those that have been seen long enough at `now`, s.
    pub fn expire(&mut self, now: f64) {
        self.0.retain_mut(|notice| now <= *notice.until.get_or_insert(now + NOTICE_S));
    }

    /// When the next one goes, s; one that has not been seen yet goes `now`.
    pub fn next_end(&self, now: f64) -> f64 {
        self.0.iter().map(|notice| notice.until.unwrap_or(now)).fold(f64::INFINITY, f64::min)
    }

    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|notice| notice.text.as_str())
    }
}

impl Stage {
    /// Says something to the person for a few seconds.
    pub fn notice(&mut self, text: impl Into<String>) {
        self.notices.say(Topic::Other, text.into());
    }

    /// What is said to the person at present.
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
        let seen = self.seen.records_seen;
        let records = self.sim.world.resource::<Quarantine>().records()[seen..].to_vec();
        self.seen.records_seen += records.len();
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
            if self.run.quarantined.len() == self.run.quarantined_before + number {
                self.run.quarantined.push(QuarantinedBody { body, tick, what, system, component, cause });
            }
        }
    }

    pub(crate) fn note_unconverged(&mut self) {
        let steps = self.sim.world.resource::<Evaluations>().unconverged_steps();
        if self.seen.unconverged_before.take_if(|before| steps > *before).is_some() {
            let what = "an implicit step did not converge; a higher step rate may help";
            self.notices.say(Topic::Unconverged, what.to_owned());
        }
    }
}
