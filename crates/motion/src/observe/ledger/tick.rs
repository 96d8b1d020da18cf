//! What laws, pushes and damping do to one body in a tick.

use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use super::bodies::{Body, State};
use super::lines::{Energies, LedgerTotals};
use super::path::{Node, Path, cuts, nodes};
use crate::kernels::record::TickRecord;
use crate::laws::course::Course;
use crate::laws::{EvaluationTime, Law};
use crate::methods::table::Method;
use crate::methods::{Integrator, with_method};
use crate::state::clock::StepClock;
use crate::tick::environment::Environment;
use crate::units::{Scalar, Vector};

/// What acts on every body in a tick.
pub(super) struct Around<'w> {
    pub environment: Environment<'w>,
    /// Of bodies that have none of their own.
    method: Method,
}

impl<'w> Around<'w> {
    /// What acts in `world` in the tick of `tick` seconds that began at the time of `clock`.
    pub fn of(world: &'w World, method: Method, clock: StepClock, tick: Scalar) -> Self {
        Self { environment: Environment::of(world, clock, tick), method }
    }

    /// The laws of a body.
    fn laws<'a>(&'a self, body: &'a Body<'_>) -> impl Iterator<Item = &'a dyn Law<Scalar>> {
        self.environment.on_body(body.gravity_off, body.in_sheet, body.laws)
    }

    /// Adds the energies of the bodies at an end of the tick: 0 is its start, 1 its end.
    pub fn add_energies(&self, bodies: &[Body<'_>], end: usize, energies: &mut Energies) {
        for body in bodies.iter().filter(|body| body.is_movable()) {
            let state = body.ends[end];
            energies.kinetic += 0.5 * body.mass() * state.velocity.dot(state.velocity);
            for law in self.laws(body).filter(|law| law.has_potential()) {
                energies.add_potential(law.name(), law.potential_energy(body.state(state)));
            }
        }
    }

    /// Rate of the linear drag that damping is for a body, 1/s: the exact model, where it is no part of a kick.
    fn damping_rate(&self, body: &Body<'_>) -> Scalar {
        let inside = with_method!(self.method_of(body), M => M::DAMPS_INSIDE);
        let damping = self.environment.damping.filter(|damping| damping.is_exact() && !inside);
        damping.map_or(0.0, |damping| body.rate.unwrap_or(damping.rate))
    }

    fn course_of(&self, body: &Body<'_>) -> Course {
        let course = self.environment.course;
        body.born.map_or(course, |time| course.since(time))
    }

    fn method_of(&self, body: &Body<'_>) -> Method {
        body.method.unwrap_or(self.method)
    }

    /// Adds what a recorded tick did to a body that forces move; returns its path.
    pub fn add_tick(&self, body: &Body<'_>, record: &TickRecord, totals: &mut LedgerTotals) -> Path {
        let course = self.course_of(body);
        let Course { tick, .. } = course;
        let [start, end] = body.ends;
        let TickRecord { damping, limits, kicked, between } = record;
        totals.energy.damping += damping.energy * body.mass();
        totals.momentum.damping += damping.velocity * body.mass();
        totals.energy.limits += limits.energy * body.mass();
        totals.momentum.limits += limits.velocity * body.mass();
        let push = body.open(body.push);
        totals.energy.pushes += push.dot(kicked.unwrap_or(end.position - start.position));
        totals.momentum.pushes += push * tick;
        let [from, to] = between.unwrap_or([start.velocity, end.velocity]);
        let rate = self.damping_rate(body);
        let ends = [State { velocity: from, ..start }, State { velocity: to, ..end }];
        let mut path = Path::new(ends, tick);
        let cuts = cuts(&course, self.laws(body).flat_map(|law| law.discontinuities()));
        self.bend(&mut path, body, course.start, &cuts);
        let nodes = nodes(&course, &cuts);
        let states: SmallVec<[(Node, State); 3]> =
            nodes.iter().map(|node| (*node, path.at(node.after))).collect();
        if rate != 0.0 {
            for (node, State { velocity, .. }) in &states {
                let impulse = *velocity * (-rate * body.mass() * node.weight);
                totals.energy.damping += impulse.dot(*velocity);
                totals.momentum.damping += impulse;
            }
        }
        for law in self.laws(body) {
            let (mut work, mut impulse) = (0.0, Vector::ZERO);
            for (node, state) in &states {
                let a = body.open(law.acceleration(node.at, body.state(*state)));
                let part = a * (body.mass() * node.weight);
                work += part.dot(state.velocity);
                impulse += part;
            }
            if !law.has_potential() {
                totals.energy.add_law(law.name(), work);
            }
            totals.momentum.add_law(law.name(), impulse);
        }
        path
    }

    /// Lets the way bend where laws jump.
    fn bend(&self, path: &mut Path, body: &Body<'_>, start: Scalar, cuts: &[Scalar]) {
        for parts in cuts.windows(3) {
            let &[before, now, next] = parts else { continue };
            let (time, state) = (start + now, body.state(path.at(now)));
            let [past, future] =
                [before, next].map(|other| EvaluationTime { time, within_step: start + 0.5 * (other + now) });
            let lawful = self.laws(body).filter(|law| !law.discontinuities().is_empty());
            let jump =
                lawful.map(|law| law.acceleration(future, state) - law.acceleration(past, state)).sum();
            path.bend(now, body.open(jump));
        }
    }
}
