//! The watch for faults: bodies that are quarantined, and energy out of nowhere.

use bevy_ecs::prelude::*;
use motion::{Dormant, KineticEnergy, Ledger, PhysicsBody, Quarantine, StableId, StepClock, Stepper, totals};
use scene::{FaultEntry, Names};

/// Energy that a tick invents, relative to the largest of the run before it, from which two such ticks in a row are a
/// fault. The first tick of a fall from rest invents as much as it has, whatever comes after it; of a method beyond
/// its limit of stability the energy grows in every tick, and from 2 on it more than triples.
pub const ENERGY_JUMP: f64 = 2.0;

/// Kinetic energy, relative to the largest of the run before it, from which on books are kept for a while. A fall from
/// rest has that much in each of its first four ticks, a jump in every one.
const GROWTH: f64 = 1.5;

/// Ticks for which books are kept after the last one of such a growth: in an oscillation that explodes, kinetic energy
/// grows in some of them only.
const PATIENCE: u64 = 8;

/// Something that went wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Number of the tick that went wrong, counted from 1; the last good one is before it.
    pub tick: u64,
    /// Stable id of the body that was quarantined, or that has most of the energy.
    pub body: Option<u32>,
    /// Whether the body was quarantined; else energy came out of nowhere.
    pub quarantined: bool,
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

/// Simulates a run and looks at every tick.
///
/// Energy is watched in two stages, because books of a tick cost more than small ticks do. Kinetic energy is summed up
/// after every one; where it grows beyond what the run had, books are kept for some ticks, and they say whether
/// something acted or the method invented it. A fault is the same whether books are kept anyway or not.
#[derive(Debug)]
pub struct Watch {
    records: usize,
    scale: f64,
    kinetic: KineticEnergy,
    doubt: Option<Doubt>,
}

/// Energy has grown, and books say by what.
#[derive(Debug)]
struct Doubt {
    /// The tick with which it began.
    since: u64,
    /// The last tick with such a growth.
    last: u64,
    /// From the tick after the first on, unless books are kept anyway.
    ledger: Option<Ledger>,
    /// The first of the ticks in a row that invented too much.
    jumped: Option<u64>,
}

impl Watch {
    /// A watch over `world` from now on. What is too much is measured by `scale`, J, if a run goes on, else by the
    /// energy that there is; by an infinite one energy is not watched.
    #[must_use]
    pub fn new(world: &mut World, scale: Option<f64>) -> Self {
        let present = |world: &mut World| {
            let totals = totals(world);
            let energy = (totals.kinetic_energy + totals.potential_energy).abs();
            // Infinite ones of both signs: it is measured by what moves.
            if energy.is_nan() { 0.0 } else { energy }
        };
        Self {
            records: world.resource::<Quarantine>().records().len(),
            scale: scale.unwrap_or_else(|| present(world)),
            kinetic: KineticEnergy::new(world),
            doubt: None,
        }
    }

    /// The largest energy so far, J: the magnitude of the first, or the largest kinetic one since.
    #[must_use]
    pub const fn scale(&self) -> f64 {
        self.scale
    }

    /// Bytes that it takes while nothing grows.
    #[must_use]
    pub const fn bytes() -> usize {
        size_of::<Self>()
    }

    /// Simulates one tick, as [`Stepper::tick`] does and to the same bits, booked by `books` if there are some; what
    /// went wrong in it.
    pub fn tick(
        &mut self,
        stepper: &mut Stepper,
        world: &mut World,
        books: Option<&mut Ledger>,
    ) -> Option<Fault> {
        let ledger = match (books, &mut self.doubt) {
            (Some(books), _) => Some(books),
            (None, Some(doubt)) => Some(doubt.ledger.get_or_insert_with(|| Ledger::open(world))),
            (None, None) => None,
        };
        let invented = match ledger {
            Some(ledger) => {
                ledger.tick(stepper, world);
                ledger.last_tick().energy.residual.abs()
            }
            None => {
                stepper.tick(world);
                0.0
            }
        };
        self.look(world, invented)
    }

    /// What went wrong in a tick that is over, and invented so much energy, J, if it was booked.
    pub(crate) fn look(&mut self, world: &mut World, invented: f64) -> Option<Fault> {
        let jump = self.look_at_energy(world, invented);
        self.look_for_quarantined(world).or(jump)
    }

    fn look_for_quarantined(&mut self, world: &World) -> Option<Fault> {
        let records = world.resource::<Quarantine>().records();
        let first = records.get(self.records).copied();
        self.records = records.len();
        first.map(|record| Fault {
            tick: record.tick,
            body: record.id.map(|id| id.0),
            quarantined: true,
            what: record.cause.what(),
        })
    }

    fn look_at_energy(&mut self, world: &mut World, invented: f64) -> Option<Fault> {
        let (tick, scale, kinetic) =
            (world.resource::<StepClock>().ticks(), self.scale, self.kinetic.sum(world));
        self.scale = scale.max(kinetic);
        let fault = self.doubt.as_mut().and_then(|doubt| doubt.judge(tick, invented, scale));
        if kinetic > GROWTH * scale {
            let new = Doubt { since: tick, last: tick, ledger: None, jumped: None };
            self.doubt.get_or_insert(new).last = tick;
        }
        self.doubt.take_if(|doubt| doubt.jumped.is_none() && tick >= doubt.last + PATIENCE);
        let first = fault?;
        Some(Fault {
            tick: first,
            body: most_energetic(world),
            quarantined: false,
            what: format!(
                "energy out of nowhere from here on, {invented:.3e} J in tick {tick}, where there were {scale:.3e} J"
            ),
        })
    }
}

/// Stable id of the body with the most kinetic energy.
fn most_energetic(world: &mut World) -> Option<u32> {
    let mut bodies = world.query_filtered::<(&StableId, &PhysicsBody), Without<Dormant>>();
    let energies = bodies.iter(world).map(|(id, body)| (body.kinetic_energy(), id.0));
    energies.max_by(|(a, ida), (b, idb)| a.total_cmp(b).then(idb.cmp(ida))).map(|(_, id)| id)
}

impl Doubt {
    /// Looks at a tick that was booked; the first that went wrong, if this one is not the only one.
    fn judge(&mut self, tick: u64, invented: f64, scale: f64) -> Option<u64> {
        // Written so that what is not a number is too much; beyond every number there is nothing to compare.
        if invented <= ENERGY_JUMP * scale || scale.is_infinite() {
            self.jumped = None;
            return None;
        }
        let first = *self.jumped.get_or_insert(tick);
        // The tick that raised the doubt was not booked: where the next one invents, it did.
        let went_wrong = if first == self.since + 1 { self.since } else { first };
        (first < tick).then_some(went_wrong)
    }
}
