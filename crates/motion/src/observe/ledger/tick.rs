//! A tick in the ledger: energies of single bodies, and the lines of pushes, laws, damping and limits.

use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use super::bodies::{BodyTick, PhasePoint};
use super::lines::{Energies, LedgerTotals};
use super::path::{Path, QuadratureNode, cuts, nodes};
use crate::kernels::record::{Kicks, TickRecord, VelocityChange};
use crate::laws::tick_times::TickTimes;
use crate::laws::{EvaluationTime, Law};
use crate::methods::table::Method;
use crate::state::clock::StepClock;
use crate::tick::environment::Environment;
use crate::units::{Scalar, Vector};

/// The environment and the world's method in a tick.
pub(super) struct LedgerTick<'w> {
    pub environment: Environment<'w>,
    /// Method of the bodies without their own.
    method: Method,
}

impl<'w> LedgerTick<'w> {
    /// The tick of `tick` seconds in `world` that began at the time of `clock`.
    pub fn of(world: &'w World, method: Method, clock: StepClock, tick: Scalar) -> Self {
        Self { environment: Environment::of(world, clock, tick), method }
    }

    /// The laws that act on a body.
    fn laws<'a>(&'a self, body: &'a BodyTick<'_>) -> impl Iterator<Item = &'a dyn Law> {
        self.environment.on_body(&body.options, body.in_sheet)
    }

    /// Adds the energies of the bodies at the start (0) or end (1) of the tick.
    pub fn add_energies(&self, bodies: &[BodyTick<'_>], end: usize, energies: &mut Energies) {
        for body in bodies.iter().filter(|body| body.is_movable()) {
            let state = body.ends[end];
            energies.kinetic += 0.5 * body.mass() * state.velocity.dot(state.velocity);
            for law in self.laws(body).filter(|law| law.has_potential()) {
                energies.add_potential(law.name(), law.potential_energy(body.state(state)));
            }
        }
    }

    /// Damping rate of a body, 1/s, where damping is a law: the exact model in methods that do not damp inside a step.
    fn damping_rate(&self, body: &BodyTick<'_>) -> Scalar {
        let damps_inside = body.method.unwrap_or(self.method).traits().damps_inside;
        let damping =
            self.environment.damping.filter(|damping| damping.is_exact() && !damps_inside);
        damping.map_or(0.0, |damping| body.options.damping_rate.unwrap_or(damping.rate))
    }

    /// Adds the recorded tick of a body that forces move to `totals`; returns its path.
    pub fn add_body(
        &self,
        body: &BodyTick<'_>,
        record: &TickRecord,
        totals: &mut LedgerTotals,
    ) -> Path {
        let times = self.environment.times;
        let times = body.born.map_or(times, |time| times.since(time));
        let TickTimes { tick, .. } = times;
        let [start, end] = body.ends;
        let TickRecord { damping, limits, kicks, between, .. } = record;
        let of_body = |change: &VelocityChange| {
            let angular = start.position.cross(change.velocity) + change.angular;
            (change.energy * body.mass(), change.velocity * body.mass(), angular * body.mass())
        };
        let (work, impulse, angular) = of_body(damping);
        totals.energy.damping += work;
        totals.momentum.damping += impulse;
        totals.angular_momentum.damping += angular;
        let (work, impulse, angular) = of_body(limits);
        totals.energy.limits += work;
        totals.momentum.limits += impulse;
        totals.angular_momentum.limits += angular;
        let [from, to] = between.unwrap_or([start.velocity, end.velocity]);
        let rate = self.damping_rate(body);
        let ends = [PhasePoint { velocity: from, ..start }, PhasePoint { velocity: to, ..end }];
        let mut path = Path::new(ends, tick);
        let cuts = cuts(&times, self.laws(body).flat_map(|law| law.discontinuities()));
        self.bend(&mut path, body, times.start, &cuts);
        let nodes = nodes(&times, &cuts);
        let states: SmallVec<[(QuadratureNode, PhasePoint); 3]> =
            nodes.iter().map(|node| (*node, path.at(node.after))).collect();
        if rate != 0.0 {
            for (node, PhasePoint { position, velocity }) in &states {
                let impulse = *velocity * (-rate * body.mass() * node.weight);
                totals.energy.damping += impulse.dot(*velocity);
                totals.momentum.damping += impulse;
                totals.angular_momentum.damping += position.cross(impulse);
            }
        }
        let push = body.along_open_axes(body.push);
        if push != Vector::ZERO {
            let lever = |(node, state): &(QuadratureNode, PhasePoint)| {
                (state.position - start.position) * node.weight
            };
            let (path, lever) = match kicks {
                Some(Kicks { path, lever, .. }) => (*path, *lever),
                None => (end.position - start.position, states.iter().map(lever).sum()),
            };
            totals.energy.pushes += push.dot(path);
            totals.momentum.pushes += push * tick;
            totals.angular_momentum.pushes += (start.position * tick + lever).cross(push);
        }
        for law in self.laws(body) {
            let (mut work, mut impulse, mut angular) = (0.0, Vector::ZERO, Vector::ZERO);
            for (node, state) in &states {
                let a = body.along_open_axes(law.acceleration(node.at, body.state(*state)));
                let weighted = a * (body.mass() * node.weight);
                work += weighted.dot(state.velocity);
                impulse += weighted;
                angular += state.position.cross(weighted);
            }
            totals.add_impulse(law.name(), impulse, angular);
            if !law.has_potential() {
                totals.energy.add_law(law.name(), work);
            }
        }
        path
    }

    /// Adds the jumps of laws to the path.
    fn bend(&self, path: &mut Path, body: &BodyTick<'_>, start: Scalar, cuts: &[Scalar]) {
        for cuts in cuts.windows(3) {
            let &[before, now, next] = cuts else { continue };
            let (time, state) = (start + now, body.state(path.at(now)));
            let [past, future] = [before, next]
                .map(|other| EvaluationTime { time, within_step: start + 0.5 * (other + now) });
            let jumping = self.laws(body).filter(|law| !law.discontinuities().is_empty());
            let jump = jumping
                .map(|law| law.acceleration(future, state) - law.acceleration(past, state))
                .sum();
            path.bend(now, body.along_open_axes(jump));
        }
    }
}
