//! The watch for faults: bodies that are quarantined, and energy out of nowhere.

use bevy_ecs::prelude::*;
use motion::{Ledger, Quarantine, StableId, StepClock};
use scene::{FaultEntry, Names};

/// Energy that a tick invents, relative to the largest of the run before it, from which two such ticks in a row are a
/// fault. The first tick of a fall from rest invents as much as it has, whatever comes after it; of a method beyond
/// its limit of stability the energy grows in every tick, and from 2 on it more than triples.
pub const ENERGY_JUMP: f64 = 2.0;

/// Something that went wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Number of the tick that went wrong, counted from 1; the last good one is before it.
    pub tick: u64,
    /// Stable id of the body that was quarantined, if one was.
    pub body: Option<u32>,
    /// What happened, and in which part of the step.
    pub what: String,
}

impl Fault {
    /// The same for people and programs elsewhere, by the name that the body has in `names`.
    #[must_use]
    pub fn named(&self, names: &Names) -> FaultEntry {
        let body = self.body.and_then(|id| Some(names.get(id)?.into_owned()));
        FaultEntry { tick: self.tick, body, what: self.what.clone() }
    }
}

/// Looks at a run after every tick.
#[derive(Clone, Debug)]
pub struct Watch {
    records: usize,
    scale: f64,
    bound: f64,
    /// The first of the ticks in a row that invented too much.
    jumped: Option<u64>,
}

impl Watch {
    /// A watch over `world` from now on. Energies are watched where books are kept, by `scale` if a run goes on, J;
    /// `bound` is what [`ENERGY_JUMP`] is else.
    #[must_use]
    pub fn new(world: &World, ledger: Option<&Ledger>, scale: Option<f64>, bound: f64) -> Self {
        let at_opening = ledger.map_or(0.0, |ledger| ledger.energies_at_opening().total().abs());
        let records = world.resource::<Quarantine>().records().len();
        Self { records, scale: scale.unwrap_or(at_opening), bound, jumped: None }
    }

    /// The largest energy so far, J: the magnitude of the first, or the largest kinetic one since.
    #[must_use]
    pub const fn scale(&self) -> f64 {
        self.scale
    }

    /// What went wrong in the tick that is over; `ledger` has booked it.
    pub fn look(&mut self, world: &World, ledger: Option<&Ledger>) -> Option<Fault> {
        let records = world.resource::<Quarantine>().records();
        let first = records.get(self.records).copied();
        self.records = records.len();
        let jump = ledger.and_then(|ledger| self.look_at_energy(world, ledger));
        let quarantined = first.map(|record| Fault {
            tick: record.tick,
            body: world.get::<StableId>(record.body).map(|id| id.0),
            what: record.cause.what(),
        });
        quarantined.or(jump)
    }

    fn look_at_energy(&mut self, world: &World, ledger: &Ledger) -> Option<Fault> {
        let invented = ledger.last_tick().energy.residual.abs();
        let (scale, tick) = (self.scale, world.resource::<StepClock>().ticks());
        self.scale = self.scale.max(ledger.energies().kinetic);
        // Written so that what is not a number is too much.
        if invented <= self.bound * scale {
            self.jumped = None;
            return None;
        }
        let first = *self.jumped.get_or_insert(tick);
        (first < tick).then(|| Fault {
            tick: first,
            body: None,
            what: format!(
                "energy out of nowhere from here on, {invented:.3e} J in tick {tick}, where there were {scale:.3e} J"
            ),
        })
    }
}
