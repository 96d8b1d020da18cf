//! The books of energy and momentum: what added to them, and what the method invented or lost.
//!
//! A ledger stands outside the world and its systems: it looks at every body before and after a tick, and whoever
//! keeps none pays nothing.

mod bodies;
mod groups;
mod lines;
mod path;
mod tick;

use std::collections::VecDeque;

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

pub use lines::{Energies, LedgerLines, LedgerTotals};

use crate::groups::{Groups, compile_groups};
use crate::kernels::record::{TickRecord, TickRecords};
use crate::methods::table::Method;
use crate::schedule::emission::emit_particles;
use crate::schedule::stepper::Stepper;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::emitter::Emissions;
use crate::units::{Scalar, Vector};
use bodies::{Bodies, Body, Opening};
use path::Path;
use tick::Around;

/// Samples a second that the rates of the last second are taken from.
const SAMPLES_PER_SECOND: Scalar = 128.0;

/// Keeps books of the energy and momentum of all movable bodies, tick by tick:
/// `change = pushes + laws + damping + limits + anchors + interventions + residual`.
///
/// The *residual* is what is left of the change when everything that acted is accounted for: what the method
/// invented, or lost. How the other lines are found, for a tick of h seconds:
///
/// - a push is constant over the tick: its impulse is F h, its work the kinetic energy that it gives. In the three Eulers,
///   which change velocity and position one after the other, that is in each step the impulse times the mean of the
///   velocities around the kick; in all other methods it is `F (x1 - x0)`;
/// - a law [with a potential](crate::Law::has_potential) works through the change of that potential, which is part of
///   the energy. The work of all others is their power, and the impulse of all laws their force, integrated by
///   Simpson's rule along the cubic that has position and velocity of both ends (Hermite 1878), split where a law
///   jumps. Both are of order 4, as the best of the methods are, in the length of the *tick*: substeps are not seen;
/// - damping and limits are written down by the kernels, substep by substep, as the velocities before and after them.
///   Exact damping in the two explicit Eulers goes along the exponential between the velocities of a step, in all other
///   methods it is a law.
///
/// Position Verlet shows velocities half a step late, and with them its kinetic energy. Sums are in stable-id order.
/// A tick takes a time in proportion to bodies and springs, and to pairs under mutual gravity.
#[derive(Clone, Debug)]
pub struct Ledger {
    opened_at: Scalar,
    now: Scalar,
    at_opening: Sums,
    closing: Sums,
    peak_kinetic: Scalar,
    last: LedgerTotals,
    since_opening: LedgerTotals,
    recent: VecDeque<(Scalar, LedgerTotals)>,
}

/// Energy and momentum of all movable bodies.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sums {
    energies: Energies,
    momentum: Vector,
}

impl Sums {
    fn add_momentum(&mut self, bodies: &[Body<'_>], end: usize) {
        let momentum = |body: &Body<'_>| body.ends[end].velocity / body.inverse_mass;
        self.momentum += bodies.iter().filter(|body| body.is_movable()).map(momentum).sum::<Vector>();
    }
}

impl Ledger {
    /// Opens the books of `world`.
    pub fn open(world: &mut World) -> Self {
        compile_groups(world);
        let mut query = Bodies::new(world);
        let world = &*world;
        let mut bodies = bodies::bodies(world, &mut query, Method::default(), &Opening::default());
        let members = groups::members(world.get_resource::<Groups>(), &mut bodies);
        let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
        let around = Around::of(world, Method::default(), clock, 0.0);
        let mut sums = Sums::default();
        around.add_energies(&bodies, 1, &mut sums.energies);
        members.iter().for_each(|group| group.add_energies(&around, &bodies, 1, &mut sums.energies));
        sums.add_momentum(&bodies, 1);
        let now = clock.seconds();
        Self {
            opened_at: now,
            now,
            peak_kinetic: sums.energies.kinetic,
            at_opening: sums.clone(),
            closing: sums,
            last: LedgerTotals::default(),
            since_opening: LedgerTotals::default(),
            recent: VecDeque::from([(now, LedgerTotals::default())]),
        }
    }

    /// Simulates one tick, as [`Stepper::tick`] does and to the same bits, and books it.
    pub fn tick(&mut self, stepper: &mut Stepper, world: &mut World) {
        stepper.make_ready(world);
        if world.contains_resource::<Emissions>() {
            // The tick finds nothing left to do.
            world.run_system_cached(emit_particles).expect("it asks for nothing but the world");
        }
        let opening = Opening::of(world);
        let clock = *world.resource::<StepClock>();
        world.resource_mut::<TickRecords>().0 = Some(EntityHashMap::default());
        stepper.tick(world);
        let records = world.resource_mut::<TickRecords>().0.take().unwrap_or_default();
        self.close_tick(world, stepper.method(), clock, &opening, &records);
    }

    fn close_tick(
        &mut self,
        world: &mut World,
        method: Method,
        clock: StepClock,
        opening: &Opening,
        records: &EntityHashMap<TickRecord>,
    ) {
        // Without the springs of a body that was frozen in the tick: it was as if it had been gone before.
        compile_groups(world);
        let mut query = Bodies::new(world);
        let world = &*world;
        let TimeStep(tick) = *world.resource::<TimeStep>();
        let mut bodies = bodies::bodies(world, &mut query, method, opening);
        let members = groups::members(world.get_resource::<Groups>(), &mut bodies);
        let around = Around::of(world, method, clock, tick);
        let [mut start, mut end] = [Sums::default(), Sums::default()];
        for (number, sums) in [&mut start, &mut end].into_iter().enumerate() {
            around.add_energies(&bodies, number, &mut sums.energies);
            members.iter().for_each(|group| group.add_energies(&around, &bodies, number, &mut sums.energies));
            sums.add_momentum(&bodies, number);
        }
        let mut totals = LedgerTotals::default();
        let mut paths = Vec::with_capacity(bodies.len());
        for body in &bodies {
            let record = records.get(&body.entity).copied().unwrap_or_default();
            paths.push(match body.acts() {
                true => around.add_tick(body, &record, &mut totals),
                false => Path::new(body.ends, tick),
            });
        }
        members.iter().for_each(|group| group.add_tick(&around, &bodies, &paths, &mut totals));
        let between = start.energies.total() - self.closing.energies.total();
        totals.energy.residual =
            end.energies.total() - start.energies.total() - totals.energy.accounted_for();
        totals.energy.interventions = between;
        totals.momentum.residual = end.momentum - start.momentum - totals.momentum.accounted_for();
        totals.momentum.interventions = start.momentum - self.closing.momentum;
        self.now = clock.after(tick).seconds();
        self.peak_kinetic = self.peak_kinetic.max(end.energies.kinetic);
        self.closing = end;
        self.since_opening.add(&totals);
        self.last = totals;
        self.sample();
    }

    /// Keeps what the rates of the last second are taken from: a second and one sample.
    fn sample(&mut self) {
        let due = |(time, _): &(Scalar, LedgerTotals)| (self.now - time) * SAMPLES_PER_SECOND >= 1.0;
        if self.recent.back().is_none_or(due) {
            self.recent.push_back((self.now, self.since_opening.clone()));
        }
        while self.recent.get(1).is_some_and(|(time, _)| self.now - time >= 1.0) {
            self.recent.pop_front();
        }
    }

    /// The books of the last tick.
    #[must_use]
    pub const fn last_tick(&self) -> &LedgerTotals {
        &self.last
    }

    /// The books since they were opened.
    #[must_use]
    pub const fn since_opening(&self) -> &LedgerTotals {
        &self.since_opening
    }

    /// What was added a second, W and N, over the last simulated second, or since the opening if that is nearer.
    #[must_use]
    pub fn last_second(&self) -> LedgerTotals {
        let earlier = self.recent.front().filter(|(time, _)| self.now > *time);
        earlier.map_or_else(LedgerTotals::default, |(time, totals)| {
            self.since_opening.rate_since(totals, self.now - time)
        })
    }

    /// Simulated time since the opening, s.
    #[must_use]
    pub fn seconds(&self) -> Scalar {
        self.now - self.opened_at
    }

    /// Energy now, by kind.
    #[must_use]
    pub const fn energies(&self) -> &Energies {
        &self.closing.energies
    }

    /// Energy at the opening, by kind.
    #[must_use]
    pub const fn energies_at_opening(&self) -> &Energies {
        &self.at_opening.energies
    }

    /// Momentum now, kg m/s.
    #[must_use]
    pub const fn momentum(&self) -> Vector {
        self.closing.momentum
    }

    /// Momentum at the opening, kg m/s.
    #[must_use]
    pub const fn momentum_at_opening(&self) -> Vector {
        self.at_opening.momentum
    }

    /// Mean rate of the energy's residual since the opening, W; 0 before the first tick.
    #[must_use]
    pub fn mean_residual_rate(&self) -> Scalar {
        let seconds = self.seconds();
        if seconds > 0.0 { self.since_opening.energy.residual / seconds } else { 0.0 }
    }

    /// Magnitude of the energy's residual since the opening, relative to the larger of the magnitude of the energy
    /// then and the largest kinetic energy since. Not a number where both are 0.
    #[must_use]
    pub fn relative_residual(&self) -> Scalar {
        let scale = self.at_opening.energies.total().abs().max(self.peak_kinetic);
        self.since_opening.energy.residual.abs() / scale
    }
}
