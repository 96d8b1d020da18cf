//! The ledger of energy, momentum and angular momentum: the amount that each cause added, and the residual, which is the error
//! of the method.
//!
//! A ledger is not part of the world or its systems: it reads every body before and after a tick. A world without a
//! ledger pays nothing for it.

mod bodies;
mod groups;
mod installed;
mod lines;
mod path;
mod tick;

use std::collections::VecDeque;

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

#[cfg(feature = "bevy")]
pub use installed::LedgerPlugin;
pub use lines::{Energies, LedgerLines, LedgerTotals};

use crate::groups::{coming_couplings, couplings};
use crate::kernels::record::TickRecords;
use crate::laws::PrescribedMotion;
use crate::methods::table::Method;
use crate::schedule::emission::emit_particles;
use crate::schedule::stepper::Stepper;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::emitter::Emissions;
use crate::units::{Scalar, Vector};
use bodies::{BodyTick, Opening, PhasePoint};
use groups::LedgerGroup;
use path::Path;
use tick::LedgerTick;

/// Samples per second for the rates of the last second.
const SAMPLES_PER_SECOND: Scalar = 128.0;

/// A ledger of the energy, momentum and angular momentum of all movable bodies, tick by tick. It has one line per cause
/// of change, and it always closes: `change = pushes + laws + damping + limits + anchors + interventions + residual`.
///
/// The ledger measures the change and computes every line but the last. The *residual* is the rest: what the method
/// created, or lost if negative. The lines of a tick of h seconds are computed as follows:
///
/// - Pushes: a push F is constant over the tick. Its impulse is F h and its work is `F (x1 - x0)`. The three Eulers
///   change velocity and position one after the other, so that their work is, in each step, the impulse times the mean
///   of the velocities before and after the kick, and their torque that at the place of the kick.
/// - Laws: the work of a law [with a potential](crate::Law::has_potential) is the change of its potential, which is
///   part of the energy and has no line. The work of all other laws is the integral of their power, the impulse of all laws
///   the integral of their force, and their angular impulse that of their torque. All are integrated by Simpson's rule
///   along the cubic through position and velocity at both ends of the tick (Hermite 1878), split where a law jumps.
///   They are of order 4, like the best methods, in the length of the *tick*: substeps do not make them more accurate.
/// - Damping and limits: the kernels record the velocities before and after them in every substep. Exact damping in
///   explicit and semi-implicit Euler follows the exponential between the velocities of a step; in all other methods it
///   is integrated like a law.
/// - Cords: their lines are split where one tightens or slackens on that cubic, which does not bend there: with damping they
///   are of order 1 to 2.
/// - Anchors: the force of springs and mutual gravity on immovable bodies, integrated like a law.
/// - Interventions: the change between the end of a tick and the start of the next.
///
/// The velocities of position Verlet are half a step late, and so is its kinetic energy. Sums are in stable-id order. A
/// tick takes time in proportion to the number of bodies and springs, and of pairs under mutual gravity.
#[derive(Resource, Clone, Debug)]
pub struct Ledger {
    opened_at: Scalar,
    now: Scalar,
    at_opening: Conserved,
    closing: Conserved,
    peak_kinetic: Scalar,
    last: LedgerTotals,
    since_opening: LedgerTotals,
    recent: VecDeque<(Scalar, LedgerTotals)>,
}

/// Energy, momentum and angular momentum of all movable bodies at one time.
#[derive(Clone, Debug, Default, PartialEq)]
struct Conserved {
    energies: Energies,
    momentum: Vector,
    angular_momentum: Vector,
}

impl Conserved {
    /// At the start (0) or end (1) of a tick.
    fn at(
        end: usize,
        tick: &LedgerTick<'_>,
        bodies: &[BodyTick<'_>],
        groups: &[LedgerGroup<'_>],
    ) -> Self {
        let mut energies = Energies::default();
        tick.add_energies(bodies, end, &mut energies);
        groups.iter().for_each(|group| group.add_energies(tick, bodies, end, &mut energies));
        let (mut momentum, mut angular_momentum) = (Vector::ZERO, Vector::ZERO);
        for body in bodies.iter().filter(|body| body.is_movable()) {
            let PhasePoint { position, velocity } = body.ends[end];
            let of_body = velocity / body.inverse_mass;
            momentum += of_body;
            angular_momentum += position.cross(of_body);
        }
        Self { energies, momentum, angular_momentum }
    }
}

/// The tick that is being simulated.
#[derive(Resource)]
struct OpenTick {
    /// The clock before it.
    clock: StepClock,
    opening: Opening,
}

impl OpenTick {
    /// Begins a tick, which the stepper then simulates.
    fn begin(stepper: &mut Stepper, world: &mut World) -> Self {
        stepper.make_ready(world);
        if world.contains_resource::<Emissions>() {
            // Births and deaths of the tick come before its start here. The tick itself then emits nothing.
            world.run_system_cached(emit_particles).expect("its parameters are always valid");
        }
        world.resource_mut::<TickRecords>().0 = Some(EntityHashMap::default());
        Self { clock: *world.resource::<StepClock>(), opening: Opening::of(world) }
    }
}

impl Ledger {
    /// Opens a ledger of `world`, which compares later energy, momentum and angular momentum with the present ones.
    ///
    /// # Panics
    /// If no stepper was made for `world`.
    #[must_use]
    pub fn open(world: &World) -> Self {
        let coming = coming_couplings(world);
        let mut bodies = bodies::bodies(world, Method::default(), &Opening::default());
        let groups = groups::ledger_groups(couplings(world, coming.as_deref()), &mut bodies);
        let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
        let tick = LedgerTick::of(world, Method::default(), clock, 0.0);
        let opening = Conserved::at(1, &tick, &bodies, &groups);
        let now = clock.seconds();
        Self {
            opened_at: now,
            now,
            peak_kinetic: opening.energies.kinetic,
            at_opening: opening.clone(),
            closing: opening,
            last: LedgerTotals::default(),
            since_opening: LedgerTotals::default(),
            recent: VecDeque::from([(now, LedgerTotals::default())]),
        }
    }

    /// Simulates one tick, bit for bit as [`Stepper::tick`] does, and adds it to the ledger. A stepper that is installed in a
    /// schedule has a ledger by [`Ledger::install`].
    ///
    /// # Panics
    /// As [`Stepper::tick`].
    pub fn tick(&mut self, stepper: &mut Stepper, world: &mut World) {
        let open = OpenTick::begin(stepper, world);
        stepper.tick(world);
        self.close_tick(world, stepper.method(), &open);
    }

    /// Adds the tick that has just ended.
    fn close_tick(&mut self, world: &mut World, method: Method, open: &OpenTick) {
        let records = world.resource_mut::<TickRecords>().0.take().unwrap_or_default();
        let (world, OpenTick { clock, opening }) = (&*world, open);
        let clock = *clock;
        // The springs of a body that was quarantined in this tick are gone, and did not act in it either.
        let coming = coming_couplings(world);
        let TimeStep(tick) = *world.resource::<TimeStep>();
        let mut bodies = bodies::bodies(world, method, opening);
        let groups = groups::ledger_groups(couplings(world, coming.as_deref()), &mut bodies);
        let ledger_tick = LedgerTick::of(world, method, clock, tick);
        let [start, end] = [0, 1].map(|end| Conserved::at(end, &ledger_tick, &bodies, &groups));
        let mut totals = LedgerTotals::default();
        let mut paths = Vec::with_capacity(bodies.len());
        for body in &bodies {
            let record = records.get(&body.entity).copied().unwrap_or_default();
            paths.push(match body.is_movable() && !body.quarantined {
                true => ledger_tick.add_body(body, &record, &mut totals),
                false => Path::new(body.ends, tick).following(
                    world.get::<PrescribedMotion>(body.entity).filter(|_| !body.quarantined),
                ),
            });
        }
        groups.iter().for_each(|group| group.add_tick(&ledger_tick, &bodies, &paths, &mut totals));
        let change = end.energies.total() - start.energies.total();
        totals.energy.residual = change - totals.energy.accounted_for();
        totals.energy.interventions = start.energies.total() - self.closing.energies.total();
        totals.momentum.residual = end.momentum - start.momentum - totals.momentum.accounted_for();
        totals.momentum.interventions = start.momentum - self.closing.momentum;
        let change = end.angular_momentum - start.angular_momentum;
        totals.angular_momentum.residual = change - totals.angular_momentum.accounted_for();
        totals.angular_momentum.interventions =
            start.angular_momentum - self.closing.angular_momentum;
        self.now = clock.after(tick).seconds();
        self.peak_kinetic = self.peak_kinetic.max(end.energies.kinetic);
        self.closing = end;
        self.since_opening.add(&totals);
        self.last = totals;
        self.sample();
    }

    /// Stores the samples for the rates of the last second: one second and one sample.
    fn sample(&mut self) {
        let due =
            |(time, _): &(Scalar, LedgerTotals)| (self.now - time) * SAMPLES_PER_SECOND >= 1.0;
        if self.recent.back().is_none_or(due) {
            self.recent.push_back((self.now, self.since_opening.clone()));
        }
        while self.recent.get(1).is_some_and(|(time, _)| self.now - time >= 1.0) {
            self.recent.pop_front();
        }
    }

    /// Totals of the last tick.
    #[must_use]
    pub const fn last_tick(&self) -> &LedgerTotals {
        &self.last
    }

    /// Totals since the ledger was opened.
    #[must_use]
    pub const fn since_opening(&self) -> &LedgerTotals {
        &self.since_opening
    }

    /// Mean rates, W, N and N m, over the last simulated second, or since the ledger was opened if that is less.
    #[must_use]
    pub fn last_second(&self) -> LedgerTotals {
        let earlier = self.recent.front().filter(|(time, _)| self.now > *time);
        earlier.map_or_else(LedgerTotals::default, |(time, totals)| {
            self.since_opening.rate_since(totals, self.now - time)
        })
    }

    /// Simulated time since the ledger was opened, s.
    #[must_use]
    pub fn seconds(&self) -> Scalar {
        self.now - self.opened_at
    }

    /// Energy now, by kind, J.
    #[must_use]
    pub const fn energies(&self) -> &Energies {
        &self.closing.energies
    }

    /// Energy when the ledger was opened, by kind, J.
    #[must_use]
    pub const fn energies_at_opening(&self) -> &Energies {
        &self.at_opening.energies
    }

    /// Momentum now, kg m/s.
    #[must_use]
    pub const fn momentum(&self) -> Vector {
        self.closing.momentum
    }

    /// Momentum when the ledger was opened, kg m/s.
    #[must_use]
    pub const fn momentum_at_opening(&self) -> Vector {
        self.at_opening.momentum
    }

    /// Angular momentum about the origin now, kg m²/s.
    #[must_use]
    pub const fn angular_momentum(&self) -> Vector {
        self.closing.angular_momentum
    }

    /// Angular momentum about the origin when the ledger was opened, kg m²/s.
    #[must_use]
    pub const fn angular_momentum_at_opening(&self) -> Vector {
        self.at_opening.angular_momentum
    }

    /// Largest kinetic energy since the ledger was opened, J.
    #[must_use]
    pub const fn peak_kinetic(&self) -> Scalar {
        self.peak_kinetic
    }

    /// Mean rate of the residual of energy since the ledger was opened, W; 0 before the first tick.
    #[must_use]
    pub fn mean_residual_rate(&self) -> Scalar {
        let seconds = self.seconds();
        if seconds > 0.0 { self.since_opening.energy.residual / seconds } else { 0.0 }
    }

    /// Magnitude of the residual of energy since the ledger was opened, relative to the larger of two scales: the
    /// magnitude of the energy at the opening and the largest kinetic energy since. NaN if both are 0 and the residual
    /// is too.
    #[must_use]
    pub fn relative_residual(&self) -> Scalar {
        let scale = self.at_opening.energies.total().abs().max(self.peak_kinetic);
        self.since_opening.energy.residual.abs() / scale
    }
}
