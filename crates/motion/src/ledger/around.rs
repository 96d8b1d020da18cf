//! What laws, pushes and damping do to one body in a tick.

use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use super::books::{Books, Energies};
use super::damped::{Damper, Taken};
use super::path::{Node, Path, cuts, nodes};
use super::rows::{Body, State};
use crate::clock::StepClock;
use crate::course::Course;
use crate::effects::Damping;
use crate::laws::{Declared, Gravity, Law, Moment, MutualGravity};
use crate::method::Method;
use crate::own::{OwnLaws, Substeps};
use crate::units::{Scalar, Vector};

/// What acts on every body in a tick.
pub(super) struct Around<'w> {
    pub course: Course,
    pub attraction: Option<&'w MutualGravity>,
    pub declared: Declared<'w>,
    gravity: Option<&'w Gravity>,
    damping: Option<Damping>,
    /// Of bodies that have none of their own.
    method: Method,
}

impl<'w> Around<'w> {
    /// What acts in `world` in the tick of `tick` seconds that began at the time of `clock`.
    pub fn of(world: &'w World, method: Method, clock: StepClock, tick: Scalar) -> Self {
        let (start, end) = (clock.scene_seconds(), clock.after(tick).scene_seconds());
        Self {
            course: Course { start, end, tick, substeps: Substeps::parts(world.get_resource()) },
            attraction: world.get_resource(),
            declared: Declared::of(world),
            gravity: world.get_resource::<Gravity>().filter(|gravity| gravity.on),
            damping: world.get_resource().copied(),
            method,
        }
    }

    /// The laws of a body.
    fn laws<'a>(&'a self, body: &'a Body<'_>) -> impl Iterator<Item = &'a dyn Law<Scalar>> {
        let gravity = self.gravity.filter(|_| !body.gravity_off).map(|gravity| gravity as &dyn Law<Scalar>);
        let drag = self.declared.drag.filter(|_| !body.in_sheet);
        let own = body.laws.into_iter().flat_map(OwnLaws::laws).map(|law| &**law);
        gravity.into_iter().chain(Declared { drag, ..self.declared }.all()).chain(own)
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

    fn course_of(&self, body: &Body<'_>) -> Course {
        Course { substeps: body.substeps.unwrap_or(self.course.substeps).max(1), ..self.course }
    }

    /// Acceleration of a body by everything but damping at the start of the tick, m/s²; `coupled` is the force of
    /// springs, sheets and mutual gravity, N.
    fn acceleration(&self, body: &Body<'_>, coupled: Vector) -> Vector {
        let time = self.course.start;
        let substep: Scalar = self.course_of(body).substep();
        let at = Moment { time, inside: time + 0.5 * substep };
        let state = body.state(body.ends[0]);
        let laws: Vector = self.laws(body).map(|law| law.acceleration(at, state)).sum();
        body.open(laws + (coupled + body.push) * body.inverse_mass)
    }

    /// Books the tick of a body that forces move; gives its way. `coupled` is asked for the force that the bodies it
    /// is coupled to exert on it at the start, N, where that matters.
    pub fn book(&self, body: &Body<'_>, coupled: impl FnOnce() -> Vector, books: &mut Books) -> Path {
        let Course { tick, .. } = self.course;
        let acceleration = body.limit.map_or(Vector::ZERO, |_| self.acceleration(body, coupled()));
        let damping =
            self.damping.map(|damping| Damping { rate: body.rate.unwrap_or(damping.rate), ..damping });
        let method = body.method.unwrap_or(self.method);
        let damper = Damper { body, method, damping, tick, acceleration };
        let breaks = self.laws(body).flat_map(|law| law.breaks());
        let taken = damper.taken(self.course_of(body).pieces(breaks).iter());
        let [start, end] = body.ends;
        let Taken { damping, limits, between: [from, to], rate } = taken;
        books.energy.damping += damping.energy;
        books.momentum.damping += damping.momentum;
        books.energy.limits += limits.energy;
        books.momentum.limits += limits.momentum;
        books.energy.pushes += body.push.dot(end.position - start.position);
        books.momentum.pushes += body.open(body.push) * tick;
        let ends = [State { velocity: from, ..start }, State { velocity: to, ..end }];
        let mut path = Path::new(ends, tick);
        let cuts = cuts(&self.course, self.laws(body).flat_map(|law| law.breaks()));
        self.bend(&mut path, body, &cuts);
        let nodes = nodes(&self.course, &cuts);
        let states: SmallVec<[(Node, State); 3]> =
            nodes.iter().map(|node| (*node, path.at(node.after))).collect();
        if rate != 0.0 {
            for (node, State { velocity, .. }) in &states {
                let impulse = *velocity * (-rate * body.mass() * node.weight);
                books.energy.damping += impulse.dot(*velocity);
                books.momentum.damping += impulse;
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
                books.energy.add_law(law.name(), work);
            }
            books.momentum.add_law(law.name(), impulse);
        }
        path
    }

    /// Lets the way bend where laws jump.
    fn bend(&self, path: &mut Path, body: &Body<'_>, cuts: &[Scalar]) {
        let start = self.course.start;
        for parts in cuts.windows(3) {
            let &[before, now, next] = parts else { continue };
            let (time, state) = (start + now, body.state(path.at(now)));
            let [past, future] =
                [before, next].map(|other| Moment { time, inside: start + 0.5 * (other + now) });
            let lawful = self.laws(body).filter(|law| !law.breaks().is_empty());
            let jump =
                lawful.map(|law| law.acceleration(future, state) - law.acceleration(past, state)).sum();
            path.bend(now, body.open(jump));
        }
    }
}
