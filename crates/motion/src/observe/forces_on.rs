//! The forces on a body, cause by cause.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

use crate::groups::{Coupling, Row, couplings_now};
use crate::kernels::record::vector;
use crate::laws::course::Course;
use crate::laws::damping::DampingRate;
use crate::laws::own::OwnLaws;
use crate::laws::{BodyState, Law};
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{AxisLocks, Force, GravityOff, PhysicsBody, Quarantined, Transform};
use crate::state::emitter::Dormant;
use crate::state::forces::{Push, PushQueue};
use crate::state::substeps::OwnSubsteps;
use crate::tick::environment::Environment;
use crate::units::{Scalar, Vector};

/// What exerts a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceCause {
    /// Applied forces, which are constant over a tick: pushes, held keys, systems of your own.
    Push,
    /// The law of that [name](Law::name), mutual gravity and damping among them. Drag on a point of a sheet is that
    /// on its triangles, in the wind where there is any.
    Law(&'static str),
    /// The spring to that body.
    Spring(Entity),
}

impl ForceCause {
    /// The word for it in summaries: `push`, `springs`, or the law's name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Push => "push",
            Self::Law(name) => name,
            Self::Spring(_) => "springs",
        }
    }
}

/// The forces on `body` at its present state, N: what the next step evaluates at its start, and nothing beside it.
/// Their sum is the mass times the acceleration.
///
/// Damping is in it as `-m c v` under every model: `tutorial` and `clamped` multiply velocities, which comes to that
/// in a short step. Speed limits are not in it: they cut velocities off and are no forces. Along a locked axis no
/// force acts. Under position Verlet laws see the velocity of half a step before, here as there. A body that is
/// immovable, quarantined, not born or scenery has no forces.
#[must_use]
pub fn forces_on(world: &mut World, body: Entity) -> Vec<(ForceCause, Vector)> {
    let pushes: Vec<_> = world.get_resource::<PushQueue>().into_iter().flat_map(PushQueue::pending).collect();
    let mut forces = Vec::new();
    each_force(world, &pushes, &[body], |_, cause, newtons| forces.push((cause, newtons)));
    forces
}

/// Calls `each` with the forces of [`forces_on`] for every one of `bodies`, given by its place among them, under these
/// `pushes` instead of those that wait for the next tick. Springs are gone through once, however many bodies there are.
pub fn each_force(
    world: &mut World,
    pushes: &[Push],
    bodies: &[Entity],
    mut each: impl FnMut(usize, ForceCause, Vector),
) {
    let couplings = couplings_now(world);
    let world = &*world;
    let mut places = EntityHashMap::with_capacity(bodies.len());
    let mut in_sheets = vec![false; bodies.len()];
    places.extend(bodies.iter().enumerate().map(|(place, body)| (*body, place)));
    for (coupling, members) in couplings.iter(world) {
        for row in &coupling.in_sheets {
            if let Some(place) = places.get(&members[*row as usize]) {
                in_sheets[*place] = true;
            }
        }
    }
    let forces = BodyForces::of(world, pushes);
    for (place, body) in bodies.iter().enumerate() {
        forces.on_body(*body, in_sheets[place], |cause, newtons| each(place, cause, newtons));
    }
    for (coupling, members) in couplings.iter(world) {
        let place = |body: &Entity| places.get(body).copied();
        let asked: Vec<_> = members[..coupling.movable].iter().map(place).collect();
        if asked.iter().any(Option::is_some) {
            let group = GroupRows::of(world, coupling, members, asked);
            forces.between(&group, |row, cause, newtons| {
                if let Some(place) = group.asked.get(row).copied().flatten() {
                    each(place, cause, open(world.get::<AxisLocks>(members[row]), newtons));
                }
            });
        }
    }
}

/// Without what acts along locked axes.
fn open(locks: Option<&AxisLocks>, newtons: Vector) -> Vector {
    locks.map_or(newtons, |locks| locks.open(newtons))
}

/// The bodies of a world and what acts on them.
struct BodyForces<'w> {
    world: &'w World,
    environment: Environment<'w>,
    pushes: EntityHashMap<Vector>,
}

impl<'w> BodyForces<'w> {
    fn of(world: &'w World, pushed: &[Push]) -> Self {
        let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
        let tick = world.get_resource::<TimeStep>().map_or(1.0, |step| step.0);
        let mut pushes = EntityHashMap::<Vector>::default();
        pushed.iter().for_each(|push| *pushes.entry(push.body).or_default() += push.newtons);
        Self { world, environment: Environment::of(world, clock, tick), pushes }
    }

    /// What acts on one body, others aside.
    fn on_body(&self, body: Entity, in_sheet: bool, mut each: impl FnMut(ForceCause, Vector)) {
        let Some(state) = moving(self.world, body) else { return };
        let Ok(thing) = self.world.get_entity(body) else { return };
        let (mass, locks) = (1.0 / state.inverse_mass, thing.get::<AxisLocks>());
        let applied = thing.get::<Force>().map_or(Vector::ZERO, Force::newtons);
        let queued = self.pushes.get(&body).copied();
        if queued.is_some() || applied != Vector::ZERO {
            each(ForceCause::Push, open(locks, applied + queued.unwrap_or_default()));
        }
        let Environment { course, damping, .. } = self.environment;
        let gravity_off = thing.contains::<GravityOff>();
        let laws = || self.environment.on_body(gravity_off, in_sheet, thing.get::<OwnLaws>());
        let substeps = thing.get::<OwnSubsteps>().map_or(course.substeps, |own| own.0.max(1));
        let course = Course { substeps, ..course };
        // A law that jumps in the coming step is seen from that side of the jump on which the step begins.
        let first = course.pieces(&mut laws().flat_map(Law::discontinuities)).iter::<Scalar>().next();
        let Some(at) = first.map(|piece| piece.moment(0.0)) else { return };
        for law in laws() {
            each(ForceCause::Law(law.name()), open(locks, law.acceleration(at, state) * mass));
        }
        if let Some(damping) = damping {
            let rate = thing.get::<DampingRate>().map_or(damping.rate, DampingRate::rate);
            each(ForceCause::Law("damping"), open(locks, state.velocity * (-rate * mass)));
        }
    }

    /// What acts between the rows of a group, on those that are asked for.
    fn between(&self, group: &GroupRows<'_>, mut each: impl FnMut(usize, ForceCause, Vector)) {
        let GroupRows { coupling, members, asked, x, v, w } = group;
        let is_asked = |row: usize| asked.get(row).is_some_and(Option::is_some);
        for spring in coupling.springs.iter() {
            let [a, b] = spring.ends.map(|end| end as usize);
            if is_asked(a) || is_asked(b) {
                let pull = vector(&spring.force([x[a], x[b]], [v[a], v[b]]));
                each(a, ForceCause::Spring(members[b]), pull);
                each(b, ForceCause::Spring(members[a]), -pull);
            }
        }
        if let Some(drag) = self.environment.laws.drag.filter(|_| !coupling.sheets.is_empty()) {
            let mut forces = vec![[0.0; 4]; x.len()];
            coupling.blow(drag, self.environment.course.start, x, v, &mut forces);
            for row in coupling.in_sheets.iter().map(|row| *row as usize) {
                each(row, ForceCause::Law(Law::<Scalar>::name(drag)), vector(&forces[row]));
            }
        }
        if let Some(law) = self.environment.attraction.filter(|_| coupling.attracts) {
            for row in (0..coupling.movable).filter(|row| is_asked(*row)) {
                let pull = |other: usize| {
                    let masses = [row, other].map(|row| coupling.mass(row, w));
                    coupling.attraction(law, masses, [row, other].map(|row| vector(&x[row])))
                };
                let others = (0..coupling.rows).filter(|other| *other != row);
                each(row, ForceCause::Law("mutual_gravity"), others.filter_map(pull).sum());
            }
        }
    }
}

/// The state of a body that forces move.
fn moving(world: &World, body: Entity) -> Option<BodyState<Scalar>> {
    let thing = world.get_entity(body).ok()?;
    let PhysicsBody { velocity, inverse_mass } = *thing.get()?;
    let free = !thing.contains::<Quarantined>() && !thing.contains::<Dormant>();
    let position = thing.get::<Transform>()?.position;
    (free && inverse_mass > 0.0).then_some(BodyState { position, velocity, inverse_mass })
}

/// A group by rows.
struct GroupRows<'a> {
    coupling: &'a Coupling<Scalar>,
    members: &'a [Entity],
    /// Places of the movable rows among the bodies that are asked for.
    asked: Vec<Option<usize>>,
    x: Vec<Row<Scalar>>,
    v: Vec<Row<Scalar>>,
    w: Vec<Scalar>,
}

impl<'a> GroupRows<'a> {
    fn of(
        world: &World,
        coupling: &'a Coupling<Scalar>,
        members: &'a [Entity],
        asked: Vec<Option<usize>>,
    ) -> Self {
        let (mut x, mut v, mut w) = (Vec::new(), Vec::new(), Vec::new());
        for body in members {
            let row = |v: Vector| [v.x, v.y, v.z, 0.0];
            let state = world.get::<PhysicsBody>(*body).copied().unwrap_or(PhysicsBody::IMMOVABLE);
            x.push(row(world.get::<Transform>(*body).copied().unwrap_or_default().position));
            v.push(row(state.velocity));
            w.push(state.inverse_mass);
        }
        Self { coupling, members, asked, x, v, w }
    }
}
