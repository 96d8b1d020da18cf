//! The quarantined bodies of a session.

use std::borrow::Cow;

use bevy_ecs::entity::Entity;
use history::Simulation;
use motion::{Cause, Fault, Quarantine, QuarantineRecord, StableId};

use crate::stage::recorder::Recorder;
use crate::stage::things;

/// Number of quarantined bodies per world that get a notice of their own.
const TOLD: usize = 3;

/// A body that was quarantined, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct QuarantinedBody {
    /// Name in the scene.
    pub body: String,
    /// The tick that it did not survive.
    pub tick: u64,
    /// What happened, as a sentence.
    pub what: String,
    /// The system that found the fault.
    pub system: &'static str,
    /// The component or resource at fault.
    pub component: &'static str,
    /// The cause as a word, with the name of the law or of the body at the other end of the spring.
    pub cause: String,
}

/// All bodies quarantined in a session, in order.
#[derive(Default)]
pub struct Quarantines {
    all: Vec<QuarantinedBody>,
    /// Number of bodies in `all` that belong to earlier worlds.
    before: usize,
    /// Number of quarantined bodies of this world that have been noted.
    noted: usize,
}

impl Quarantines {
    /// The bodies quarantined up to now, including earlier scenes and the time before a reset.
    #[must_use]
    pub fn so_far(&self) -> &[QuarantinedBody] {
        &self.all[..self.end()]
    }

    /// All bodies, including those ahead after going back whose ticks have not been dropped.
    #[must_use]
    pub fn all(&self) -> &[QuarantinedBody] {
        &self.all
    }

    /// The quarantined bodies of this world.
    pub(crate) fn here(&self) -> &[QuarantinedBody] {
        &self.all[self.before..self.end()]
    }

    fn end(&self) -> usize {
        (self.before + self.noted).min(self.all.len())
    }

    /// Drops the bodies that are ahead of the present after going back.
    pub(super) fn forget_ahead(&mut self) {
        self.all.truncate(self.before + self.noted);
    }

    /// Begins another world, at the start of a scene.
    pub(super) fn begin_world(&mut self) {
        self.forget_ahead();
        (self.before, self.noted) = (self.all.len(), 0);
    }

    /// Takes the records of `sim`, another state of this world, as noted.
    pub(super) fn follow(&mut self, sim: &Simulation) {
        self.noted = sim.world.resource::<Quarantine>().records().len();
    }

    /// Lists the bodies of `sim` that were quarantined since the last call. Returns what to tell the person.
    pub(super) fn note(&mut self, sim: &Simulation, recorder: &Recorder) -> Vec<String> {
        let mut told = Vec::new();
        let records = &sim.world.resource::<Quarantine>().records()[self.noted..];
        if records.is_empty() {
            return told;
        }
        let times = recorder.times(sim);
        for (number, record) in (self.noted..).zip(records) {
            let QuarantineRecord { body, id, other_end, tick, cause } = *record;
            // A body may have been removed since.
            let name = |id: Option<StableId>, body: Entity| {
                let name = id.and_then(|id| sim.scene.names.get(id.0)).map(Cow::into_owned);
                name.unwrap_or_else(|| things::name(sim, body))
            };
            let (body, what, Cause { system, component, fault }) =
                (name(id, body), cause.what(), cause);
            let cause = match fault {
                Fault::Law(law) => format!("law {law}"),
                Fault::Spring(other) => format!("spring to {}", name(other_end, other)),
                fault @ (Fault::Found | Fault::Overflow | Fault::Range(_) | Fault::Request) => {
                    fault.name().to_owned()
                }
            };
            if number < TOLD {
                told.push(format!("{body} was quarantined at {}: {what}", times.words(tick)));
            }
            // A run that continues from the past may repeat a quarantine that is already listed.
            if self.all.len() == self.before + number {
                self.all.push(QuarantinedBody { body, tick, what, system, component, cause });
            }
        }
        self.noted += records.len();
        told
    }
}

/// When and by which system `body` was quarantined, in a few words.
pub(crate) fn quarantined_because(
    sim: &Simulation,
    recorder: &Recorder,
    body: Entity,
) -> Option<String> {
    let records = sim.world.resource::<Quarantine>().records();
    let record = records.iter().find(|record| record.body == body)?;
    let at = recorder.times(sim).words(record.tick);
    Some(format!("at {at} by {}", record.cause.system))
}
