//! Detects faults of a run: quarantined bodies, energy from nowhere, and bound bodies that become free.

mod escape;

use std::sync::Arc;

use bevy_ecs::prelude::*;
use escape::Escapes;
use motion::clock::StepClock;
use motion::ledger::Ledger;
use motion::{Dormant, KineticEnergy, PhysicsBody, Quarantine, StableId, totals};
use scene::{EXPLODES, Names};

use crate::bundle::{EnergyGrowth, EnergyLook, EnergyState, FaultEntry};
use crate::simulation::Simulation;
use crate::timeline::Replay;

/// Two ticks in a row that each invent more than this many times the largest energy before them are a fault. One tick
/// is not enough: the first tick of a fall from rest invents as much energy as there then is. With a method beyond
/// its stability limit the energy grows in every tick, and more than triples in a tick above this limit.
pub const ENERGY_JUMP: f64 = 2.0;

/// A look begins when kinetic energy exceeds the largest energy at the last look by this factor.
const GROWTH: f64 = 1.5;

/// Ticks for which a ledger is kept after the last tick that multiplied the energy by [`GROWTH`]: in an oscillation
/// that explodes, kinetic energy grows only in some ticks.
const PATIENCE: u64 = 8;

/// Most ticks of a look, which would never end if every tick multiplied the energy.
const LONGEST_LOOK: u64 = 4 * PATIENCE;

/// Most bodies for which leaps are detected: computing their potential energy takes as long as a tick.
const SMALL: usize = 256;

/// Share of a growth that a cause must explain to count as its cause.
const MOST: f64 = 0.5;

/// A look that finds no cause ends a growth, if kinetic plus potential energy has increased by no more than this part
/// of the largest energy when the growth was first seen.
const GROWN: f64 = 0.25;

/// A fault of a run: a quarantined body, energy from nowhere, or bound bodies that become free.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Number of the tick that went wrong, counted from 1; the last good one is before it.
    pub tick: u64,
    /// Number of the tick after which it was certain.
    pub found: u64,
    /// Stable id of the body that was quarantined, or that has most of the energy.
    pub body: Option<u32>,
    /// Whether the body was quarantined; else the method created or destroyed energy, or bodies became free.
    pub quarantined: bool,
    /// What happened, and in which part of the step.
    pub what: String,
}

impl Fault {
    /// The fault as an entry of a bundle or a summary, with the name that the body has in `names`.
    #[must_use]
    pub fn named(&self, names: &Names) -> FaultEntry {
        let body = self.body.and_then(|id| Some(names.get(id)?.into_owned()));
        FaultEntry { tick: self.tick, body, what: self.what.clone() }
    }

    /// Whether `entry` is this fault. Earlier versions of the program worded faults of energy otherwise.
    #[must_use]
    pub fn is(&self, entry: &FaultEntry, names: &Names) -> bool {
        let own = self.named(names);
        let is_of_energy = entry.what.contains("energy") || entry.what.contains("orbit");
        (own.tick, &own.body) == (entry.tick, &entry.body)
            && (own.what == entry.what || !self.quarantined && is_of_energy)
    }
}

/// Simulates a run and checks every tick for faults.
///
/// Energy is checked in two stages, because a ledger costs more than a small tick. Kinetic energy is summed after
/// every tick. When it has grown by half since the last look, the next look begins: a ledger is kept for some ticks
/// and shows how much energy the method invents. Faults are the same whether or not the caller keeps a ledger anyway.
///
/// One look suffices to detect a jump, and also a *leap*: a single tick that invents more energy than the run had. A
/// slow growth takes several looks, each of which finds that most of the added energy was invented; it is a fault
/// when it exceeds [`EXPLODES`] times the energy at the end of the first look. Demonstrations of methods grow less,
/// and the ledger explains the growth of falls, pushes and swings.
///
/// Bodies that attraction holds are checked, too: where nothing else can free them, they stay bound.
#[derive(Debug)]
pub struct Watch {
    records: usize,
    kinetic: KineticEnergy,
    energy: EnergyState,
    /// Ledger of the look in progress, opened in the tick after its first; `None` if the caller keeps a ledger
    /// anyway.
    ledger: Option<Ledger>,
    escapes: Escapes,
    /// Whether the energy is computed after every tick, to see what a single tick invents.
    is_small: bool,
}

impl Watch {
    /// A watch over a run that begins in the present state of `simulation`.
    #[must_use]
    pub fn new(simulation: &Simulation) -> Self {
        let totals = totals(&simulation.world);
        let energy = (totals.kinetic_energy + totals.potential_energy).abs();
        // The sum of infinite energies of both signs is NaN: then only the kinetic energy counts.
        let largest = if energy.is_nan() { 0.0 } else { energy };
        let tick = simulation.ticks();
        Self::resume(
            simulation,
            EnergyState {
                total_j: Some(totals.kinetic_energy + totals.potential_energy),
                last_j: Some(totals.kinetic_energy + totals.potential_energy),
                ..EnergyState::at(tick, largest)
            },
        )
    }

    /// Continues the watch over the run of `simulation`. `energy` is what [`Watch::energy`] returned at that state of the
    /// run.
    #[must_use]
    pub fn resume(simulation: &Simulation, energy: EnergyState) -> Self {
        let escapes = Escapes::of(simulation);
        let world = &simulation.world;
        let records = world.resource::<Quarantine>().records().len();
        let mut bodies = world.try_query::<&PhysicsBody>().expect("a stepper registers it");
        let is_small = bodies.iter(world).count() <= SMALL;
        Self {
            records,
            kinetic: KineticEnergy::new(world),
            energy,
            ledger: None,
            escapes,
            is_small,
        }
    }

    /// The state of the watch over energy, for [`Watch::resume`].
    #[must_use]
    pub const fn energy(&self) -> EnergyState {
        self.energy
    }

    /// Bytes of a watch while no energy grows.
    #[must_use]
    pub const fn bytes() -> usize {
        size_of::<Self>()
    }

    /// Simulates one tick, bit for bit as [`Simulation::tick`] does, and records it in `ledger` if there is one.
    /// Returns the fault that the tick makes certain.
    pub fn tick(
        &mut self,
        simulation: &mut Simulation,
        ledger: Option<&mut Ledger>,
    ) -> Option<Fault> {
        if !simulation.pending().is_empty() {
            self.note_change(simulation.ticks());
        }
        let births = !simulation.scene.emitters.is_empty();
        let own = self.energy.look.is_some().then_some(&mut self.ledger);
        let opened = || Ledger::open(&simulation.world);
        let booked = match ledger.or_else(|| Some(own?.get_or_insert_with(opened))) {
            Some(ledger) => {
                simulation.tick_with(ledger);
                Booked::of(ledger, births)
            }
            None => {
                simulation.tick();
                Booked::default()
            }
        };
        self.look_at(simulation, booked)
    }

    fn look_at(&mut self, simulation: &Simulation, booked: Booked) -> Option<Fault> {
        let jump = self.look_at_energy(&simulation.world, booked);
        let escape = self.escapes.look(simulation);
        let fault = self.look_for_quarantined(&simulation.world).or(jump);
        if fault.is_some() {
            self.escapes.forget();
        }
        fault.or(escape)
    }

    /// Checks a tick that was simulated without the watch, to measure what a check costs.
    pub fn check(&mut self, simulation: &Simulation) {
        self.look_at(simulation, Booked::default());
    }

    /// The fault in the last ticks of a run that ends in the present state of `simulation`, if none of its ticks made it certain: a copy
    /// continues until the look in progress ends.
    pub fn finish(&self, simulation: &Simulation) -> Option<Fault> {
        self.energy.look?;
        let (end, snapshot) = (simulation.ticks(), simulation.snapshot().without_inputs());
        let scene = Arc::clone(&simulation.scene);
        let Replay { mut simulation, mut watch } =
            Replay::of(scene, &snapshot, self.energy).ok()?;
        let faults = (0..LONGEST_LOOK).filter_map(|_| watch.tick(&mut simulation, None));
        let fault = { faults }.find(|fault| fault.tick <= end)?;
        Some(Fault { found: end, ..fault })
    }

    /// Records a change from outside after tick number `tick`: no growth that is found later begins before it.
    pub fn note_change(&mut self, tick: u64) {
        self.energy.changed_tick = tick.saturating_add(1);
        self.escapes.forget();
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

    fn look_at_energy(&mut self, world: &World, booked: Booked) -> Option<Fault> {
        let (tick, kinetic) = (world.resource::<StepClock>().ticks(), self.kinetic.sum(world));
        enter(&mut self.energy, tick, booked);
        let jump = jump(&mut self.energy, tick, booked);
        let growth = growth(&mut self.energy);
        let now = self.is_small.then(|| {
            let totals = totals(world);
            totals.kinetic_energy + totals.potential_energy
        });
        let leap = take_in(&mut self.energy, tick, kinetic, booked.total, now);
        self.ledger.take_if(|_| self.energy.look.is_none());
        let Nowhere { since, joules, before } = jump.or(growth).or(leap)?;
        Some(Fault {
            tick: since,
            found: tick,
            body: most_energetic(world),
            quarantined: false,
            what: if joules < 0.0 {
                format!(
                    "the method destroyed {:.3e} J of energy from here on; the run had {before:.3e} J",
                    -joules
                )
            } else {
                format!(
                    "the method created {joules:.3e} J of energy from here on; the run had {before:.3e} J"
                )
            },
        })
    }
}

/// The ledger's entries for a tick; all 0 without a ledger.
#[derive(Clone, Copy, Default)]
struct Booked {
    /// Energy that the method invented, J.
    invented: f64,
    /// Energy that everything else added, J.
    caused: f64,
    /// Kinetic and potential energy at the end of the tick, J.
    total: f64,
    /// Whether anything but the method may add energy at any time.
    fed: bool,
}

impl Booked {
    fn of(ledger: &Ledger, births: bool) -> Self {
        let lines = &ledger.last_tick().energy;
        let caused = lines.change() - lines.residual;
        // A law that does no work in this tick, such as an idle engine, has a line, too. Damping of springs only takes
        // energy, and so does drag unless there is wind.
        let gives = |(law, joules): &(&str, f64)| {
            !matches!(*law, "drag" | "spring_damping") || *joules > 0.0
        };
        let fed = births || caused > 0.0 || lines.laws.iter().any(gives);
        Self { invented: lines.residual, caused, total: ledger.energies().total(), fed }
    }
}

/// Energy that the method invented or lost, for the message of a fault.
struct Nowhere {
    /// The first tick that invented it.
    since: u64,
    /// The invented energy, J; below 0 if energy was lost.
    joules: f64,
    /// Energy of the run before it, J.
    before: f64,
}

/// Adds the ledger entries of a tick to the look in progress.
fn enter(energy: &mut EnergyState, tick: u64, Booked { invented, caused, total, fed }: Booked) {
    let Some(look) = &mut energy.look else { return };
    look.total_j = look.total_j.or(Some(total - invented - caused));
    look.fed |= fed;
    if invented.is_finite() {
        look.invented_j += invented;
        look.caused_j += caused;
    }
    if look.grew.is_none() && look.invented_j > (GROWTH - 1.0) * energy.looked_j {
        look.grew = Some(tick);
    }
}

/// The jump that this tick makes certain, if a ledger was kept of it: it is the second tick in a row that invents too
/// much.
fn jump(
    energy: &mut EnergyState,
    tick: u64,
    Booked { invented, total, .. }: Booked,
) -> Option<Nowhere> {
    let (before, began, alone) =
        (energy.largest_j, first_tick(energy, tick, total), is_alone(energy));
    let found_before = energy
        .growth
        .filter(|growth| energy.looked_tick <= growth.since.saturating_add(2 * LONGEST_LOOK));
    let look = energy.look.as_mut()?;
    // What drag takes in the same tick was never there.
    let is_gone = invented > 0.0 && look.total_j.is_some_and(|at_first| total <= at_first);
    // NaN counts as too much; with an infinite energy before, no jump can be judged.
    if invented.abs() <= ENERGY_JUMP * before || is_gone || before.is_infinite() {
        look.jumped = None;
        return None;
    }
    let first = *look.jumped.get_or_insert(tick);
    let grew = look.grew.unwrap_or(first);
    // No ledger was kept of the tick that began the look: if the next tick invents energy, that tick did, too.
    let multiplied = look.total_j.is_some_and(|at_first| at_first > GROWTH * energy.looked_j);
    let since =
        if grew == look.since.saturating_add(1) || (alone && multiplied) { began } else { grew };
    // If the look before this one found invented energy, both are one explosion.
    let since = found_before.map_or(since, |growth| growth.since.min(since));
    // An unstable spring takes energy in some ticks and gives it in others: report its net gain.
    let joules = if invented < 0.0 && total > before { total - before } else { invented };
    (tick == first.saturating_add(1)).then_some(Nowhere { since, joules, before })
}

/// The growth that exceeds its limit with this tick, if a ledger was kept of it.
fn growth(energy: &mut EnergyState) -> Option<Nowhere> {
    let (look, growth) = (energy.look.as_ref()?, energy.growth.as_mut()?);
    let joules = energy.looked_j - growth.own_j - growth.elsewhere_j + look.invented_j;
    let too_much = joules > EXPLODES * growth.own_j && !growth.reported;
    growth.reported |= too_much;
    too_much.then_some(Nowhere { since: growth.since, joules, before: growth.own_j })
}

/// Updates the state of the watch with the kinetic energy after a tick: begins, continues or ends a look. `total` is
/// kinetic plus potential energy by the ledger, 0 without one; `now` is the same energy without a ledger, in a small
/// world. Returns the leap that the end of a look makes certain.
fn take_in(
    energy: &mut EnergyState,
    tick: u64,
    kinetic: f64,
    total: f64,
    now: Option<f64>,
) -> Option<Nowhere> {
    let before = energy.largest_j;
    let last = std::mem::replace(&mut energy.last_j, now);
    let invented = now.zip(last).map(|(now, last)| now - last);
    energy.largest_j = before.max(kinetic);
    let grown = now
        .zip(energy.total_j)
        .is_some_and(|(now, then)| now - then > (GROWTH - 1.0) * energy.looked_j);
    if grown && energy.grew_tick.is_none() {
        energy.grew_tick = Some(tick);
    }
    let leaps = invented.is_some_and(|invented| invented > before);
    if (kinetic > GROWTH * energy.looked_j || leaps) && energy.look.is_none() {
        energy.look = Some(EnergyLook { since: tick, last: tick, ..EnergyLook::default() });
    }
    let look = energy.look.as_mut()?;
    // No ledger is kept of the tick that began the look, but if nothing else gives energy, the method invented all
    // that is new.
    if leaps && look.leapt_over_j.is_none() {
        look.leapt_over_j = Some(before);
        look.leapt_from_j = last;
    }
    if look.leapt_over_j.is_some() && tick > look.since {
        look.least_j = Some(look.least_j.map_or(total, |least| least.min(total)));
        look.most_j = Some(look.most_j.map_or(total, |most| most.max(total)));
    }
    if kinetic > GROWTH * before {
        look.last = tick;
    }
    let over = look.last.saturating_add(PATIENCE).min(look.since.saturating_add(LONGEST_LOOK));
    if look.jumped.is_some() || tick < over {
        return None;
    }
    let leap = leap(energy);
    energy.growth = growth_after_look(energy, tick, total);
    energy.look = None;
    energy.grew_tick = None;
    (energy.looked_tick, energy.looked_j, energy.total_j) = (tick, energy.largest_j, Some(total));
    leap
}

/// The leap in a look that ends, if a tick invented more energy than there was, and what it invented stayed. A method that
/// only shows too much energy in some phases of a swing shows the old one in others. The first tick of a fall from rest
/// invents as much energy as there then is, but later ticks outgrow it.
fn leap(energy: &EnergyState) -> Option<Nowhere> {
    let look = energy.look.filter(|_| is_alone(energy))?;
    // A method that destroyed energy since the last look, and creates it again, has not created more than there was.
    let (before, then) = (look.leapt_over_j?, look.leapt_from_j?.max(energy.total_j?));
    let [least, joules] = [look.least_j? - then, look.most_j? - then];
    let stays = least > before && joules >= MOST * energy.largest_j;
    stays.then(|| Nowhere { since: energy.grew_tick.unwrap_or(look.since), joules, before })
}

/// The growth that a look leaves in progress when it ends with tick number `now` and energy `total`.
#[expect(clippy::cast_precision_loss, reason = "ticks of a run")]
fn growth_after_look(energy: &EnergyState, now: u64, total: f64) -> Option<EnergyGrowth> {
    let look = energy.look?;
    let added = energy.largest_j - energy.looked_j;
    let [all, seen] =
        [energy.looked_tick, look.since].map(|first| now.saturating_sub(first) as f64);
    let explains = |joules: f64| joules * all >= MOST * added * seen;
    // On a spring that is no longer than its swing, a method gives and takes energy within each swing: a look of a
    // few ticks may see a loss while energy grows in the long run. If nothing else gives energy, the method invented
    // the growth.
    let in_the_long_run =
        is_alone(energy) && energy.total_j.is_some_and(|before| total - before >= MOST * added);
    if in_the_long_run || explains(look.invented_j) {
        // A push, or an engine that starts, multiplies an energy near 0: the growth is measured from the end of the
        // first look.
        let own_j = energy.largest_j;
        let begins = EnergyGrowth {
            since: first_tick(energy, now, total),
            own_j,
            total_j: Some(total),
            ..EnergyGrowth::default()
        };
        return energy.growth.or(Some(begins));
    }
    let mut growth = energy.growth.filter(|_| !explains(look.caused_j))?;
    growth.elsewhere_j += added;
    growth.total_j.is_none_or(|first| total - first > GROWN * growth.own_j).then_some(growth)
}

/// Whether nothing but the method can have added energy since the last look.
fn is_alone(energy: &EnergyState) -> bool {
    energy.look.is_some_and(|look| !look.fed) && energy.changed_tick <= energy.looked_tick
}

/// The first tick in which the method invented energy, for a look that has reached tick number `now` with energy
/// `total`. It is the tick that began the look, unless energy had multiplied by then. In that case it is the tick
/// that raised the energy by half, extrapolated back at the growth rate of the look: on a stiff spring, kinetic
/// energy shows little of the growth in some ticks.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "a small count of ticks"
)]
fn first_tick(energy: &EnergyState, now: u64, total: f64) -> u64 {
    let Some(EnergyLook { since, total_j: Some(at_first), .. }) = energy.look else { return now };
    let grown = at_first / (GROWTH * energy.looked_j);
    let per_tick = libm::log(total / at_first) / now.saturating_sub(since) as f64;
    // The first tick of a spring from rest multiplies energy by more than later ticks.
    let ticks = (libm::log(grown) / per_tick).ceil() + f64::from(per_tick > libm::log(GROWTH));
    // NaN counts as no earlier tick.
    let earlier = if grown > 1.0 && per_tick > 0.0 && ticks.is_finite() { ticks as u64 } else { 0 };
    let earliest = energy.changed_tick.max(energy.looked_tick.saturating_add(1));
    since.saturating_sub(earlier).max(earliest).min(since)
}

/// Stable id of the body with the most kinetic energy.
fn most_energetic(world: &World) -> Option<u32> {
    let mut bodies = world.try_query_filtered::<(&StableId, &PhysicsBody), Without<Dormant>>()?;
    let energies = bodies.iter(world).map(|(id, body)| (body.kinetic_energy(), id.0));
    energies.max_by(|(a, ida), (b, idb)| a.total_cmp(b).then(idb.cmp(ida))).map(|(_, id)| id)
}
