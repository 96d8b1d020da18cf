//! The watch for faults: bodies that are quarantined, and energy out of nowhere.

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::ledger::Ledger;
use motion::{Dormant, KineticEnergy, PhysicsBody, Quarantine, StableId, totals};
use scene::{EXPLODES, Names};

use crate::bundle::{EnergyGrowth, EnergyLook, EnergyState, FaultEntry};
use crate::simulation::Simulation;

/// Energy that a tick invents, relative to the largest of the run before it, from which two such ticks in a row are a
/// fault. The first tick of a fall from rest invents as much as it has, whatever comes after it; of a method beyond
/// its limit of stability the energy grows in every tick, and from 2 on it more than triples.
pub const ENERGY_JUMP: f64 = 2.0;

/// Growth of the kinetic energy that is looked into, relative to the largest energy at the last look.
const GROWTH: f64 = 1.5;

/// Ticks for which a ledger is kept after the last one that multiplied the energy by [`GROWTH`]: in an oscillation that
/// explodes, kinetic energy grows in some of them only.
const PATIENCE: u64 = 8;

/// Most ticks of a look: where each multiplies the energy, it would have no end.
const LONGEST_LOOK: u64 = 4 * PATIENCE;

/// Share of a growth from which on what invents it is what makes it grow.
const MOST: f64 = 0.5;

/// Something that went wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Number of the tick that went wrong, counted from 1; the last good one is before it.
    pub tick: u64,
    /// Number of the tick after which it was certain.
    pub found: u64,
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
/// Energy is watched in two stages, because a ledger costs more than small ticks do. Kinetic energy is summed up
/// after every tick; where it has grown by half since the last look, a ledger is kept for some ticks, and says what the
/// method invents. A fault is the same whether a ledger is kept anyway or not.
///
/// A jump is seen in one look. Slow growth is what look after look finds to be invented for the larger part; it is a
/// fault when it comes to [`EXPLODES`] times the energy at the end of the first of them. Less is what demonstrations of methods live
/// from, and what falls, is pushed or swings grows by less than that, or by what a ledger knows.
#[derive(Debug)]
pub struct Watch {
    records: usize,
    kinetic: KineticEnergy,
    energy: EnergyState,
    /// During a look, from the tick after the first on, unless a ledger is kept anyway.
    ledger: Option<Ledger>,
}

impl Watch {
    /// A watch over `world` from now on, where a run begins.
    #[must_use]
    pub fn new(world: &mut World) -> Self {
        let totals = totals(world);
        let energy = (totals.kinetic_energy + totals.potential_energy).abs();
        // Infinite ones of both signs: it is measured by what moves.
        let largest = if energy.is_nan() { 0.0 } else { energy };
        let tick = world.resource::<StepClock>().ticks();
        Self::going_on(world, EnergyState::at(tick, largest))
    }

    /// The watch over a run that goes on in `world`, with what [`Watch::energy`] was then.
    #[must_use]
    pub fn going_on(world: &mut World, energy: EnergyState) -> Self {
        let records = world.resource::<Quarantine>().records().len();
        Self { records, kinetic: KineticEnergy::new(world), energy, ledger: None }
    }

    /// What is known of the energy, to go on from.
    #[must_use]
    pub const fn energy(&self) -> EnergyState {
        self.energy
    }

    /// Bytes that it takes while nothing grows.
    #[must_use]
    pub const fn bytes() -> usize {
        size_of::<Self>()
    }

    /// Simulates one tick, as [`Simulation::tick`] does and to the same bits, in `ledger` if there is one; what went wrong
    /// in it.
    pub fn tick(&mut self, simulation: &mut Simulation, ledger: Option<&mut Ledger>) -> Option<Fault> {
        let Simulation { world, stepper, .. } = simulation;
        let own = self.energy.look.is_some().then_some(&mut self.ledger);
        let ledger = ledger.or_else(|| Some(own?.get_or_insert_with(|| Ledger::open(world))));
        let invented = match ledger {
            Some(ledger) => {
                ledger.tick(stepper, world);
                ledger.last_tick().energy.residual
            }
            None => {
                stepper.tick(world);
                0.0
            }
        };
        self.look(world, invented)
    }

    /// What went wrong in a tick that is over, and invented so much energy, J, if it was booked.
    pub fn look(&mut self, world: &mut World, invented: f64) -> Option<Fault> {
        let jump = self.look_at_energy(world, invented);
        self.look_for_quarantined(world).or(jump)
    }

    fn look_for_quarantined(&mut self, world: &World) -> Option<Fault> {
        let records = world.resource::<Quarantine>().records();
        let first = records.get(self.records).copied();
        self.records = records.len();
        first.map(|record| Fault {
            tick: record.tick,
            found: record.tick,
            body: record.id.map(|id| id.0),
            quarantined: true,
            what: record.cause.what(),
        })
    }

    fn look_at_energy(&mut self, world: &mut World, invented: f64) -> Option<Fault> {
        let (tick, kinetic) = (world.resource::<StepClock>().ticks(), self.kinetic.sum(world));
        let jump = jump(&mut self.energy, tick, invented);
        let growth = growth(&mut self.energy, invented);
        take_in(&mut self.energy, tick, kinetic);
        self.ledger.take_if(|_| self.energy.look.is_none());
        let Nowhere { since, joules, before } = jump.or(growth)?;
        Some(Fault {
            tick: since,
            found: tick,
            body: most_energetic(world),
            quarantined: false,
            what: format!(
                "energy out of nowhere from here on, {joules:.3e} J until tick {tick}, where there were {before:.3e} J"
            ),
        })
    }
}

/// Energy out of nowhere.
struct Nowhere {
    /// The first tick that invented it.
    since: u64,
    /// How much it is, J.
    joules: f64,
    /// What there was, J.
    before: f64,
}

/// A jump that this tick makes certain, if it was booked: the second in a row that invents too much.
fn jump(energy: &mut EnergyState, tick: u64, invented: f64) -> Option<Nowhere> {
    let before = energy.largest_j;
    let look = energy.look.as_mut()?;
    // Written so that what is not a number is too much; beyond every number there is nothing to compare.
    if invented.abs() <= ENERGY_JUMP * before || before.is_infinite() {
        look.jumped = None;
        return None;
    }
    let first = *look.jumped.get_or_insert(tick);
    // The tick that raised the doubt was not booked: where the next one invents, it did.
    let since = if first == look.since.saturating_add(1) { look.since } else { first };
    (tick == first.saturating_add(1)).then_some(Nowhere { since, joules: invented, before })
}

/// A growth that has come to too much with this tick, if it was booked.
fn growth(energy: &mut EnergyState, invented: f64) -> Option<Nowhere> {
    let look = energy.look.as_mut()?;
    if invented.is_finite() {
        look.invented_j += invented;
    }
    let growth = energy.growth.as_mut()?;
    let joules = energy.looked_j - growth.own_j + look.invented_j;
    let too_much = joules > EXPLODES * growth.own_j && !growth.reported;
    growth.reported |= too_much;
    too_much.then_some(Nowhere { since: growth.since, joules, before: growth.own_j })
}

/// Takes in the kinetic energy after a tick: begins a look, goes on with it, or ends it.
fn take_in(energy: &mut EnergyState, tick: u64, kinetic: f64) {
    let before = energy.largest_j;
    energy.largest_j = before.max(kinetic);
    if kinetic > GROWTH * energy.looked_j && energy.look.is_none() {
        energy.look = Some(EnergyLook { since: tick, last: tick, ..EnergyLook::default() });
    }
    let Some(look) = &mut energy.look else { return };
    if kinetic > GROWTH * before {
        look.last = tick;
    }
    let over = look.last.saturating_add(PATIENCE).min(look.since.saturating_add(LONGEST_LOOK));
    if look.jumped.is_some() || tick < over {
        return;
    }
    // A push, or an engine that starts, multiplies what was next to nothing: it is counted from the end of the first look.
    let begins = EnergyGrowth { since: look.since, own_j: energy.largest_j, reported: false };
    let invented = is_invented(energy, tick);
    energy.growth = invented.then(|| energy.growth.unwrap_or(begins));
    (energy.look, energy.looked_tick, energy.looked_j) = (None, tick, energy.largest_j);
}

/// Whether the method, at the rate at which it invents in this look, which ends with tick number `now`, invented the
/// larger part of what was added since the last one.
#[expect(clippy::cast_precision_loss, reason = "ticks of a run")]
fn is_invented(energy: &EnergyState, now: u64) -> bool {
    let Some(look) = energy.look else { return false };
    let [all, seen] = [energy.looked_tick, look.since].map(|first| now.saturating_sub(first) as f64);
    look.invented_j * all >= MOST * (energy.largest_j - energy.looked_j) * seen
}

/// Stable id of the body with the most kinetic energy.
fn most_energetic(world: &mut World) -> Option<u32> {
    let mut bodies = world.query_filtered::<(&StableId, &PhysicsBody), Without<Dormant>>();
    let energies = bodies.iter(world).map(|(id, body)| (body.kinetic_energy(), id.0));
    energies.max_by(|(a, ida), (b, idb)| a.total_cmp(b).then(idb.cmp(ida))).map(|(_, id)| id)
}
