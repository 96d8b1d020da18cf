//! The forces on a body by cause, and its potential energy by law.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

use crate::groups::{Coupling, Row, coming_couplings, couplings, row_of, states_of};
use crate::kernels::record::vector;
use crate::laws::damping::Damping;
use crate::laws::tick_times::TickTimes;
use crate::laws::{BodyState, Law};
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{AxisLocks, Force, PhysicsBody, Quarantined, Transform};
use crate::state::emitter::Dormant;
use crate::state::forces::{Push, PushQueue, sum_by_body};
use crate::tick::columns::options_of;
use crate::tick::environment::Environment;
use crate::units::{Scalar, Vector};

/// The cause of a force on a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum ForceCause {
    /// Applied forces, which are constant over a tick: pushes, held keys, your own systems.
    Push,
    /// The law with that [name](Law::name); mutual gravity and damping are among them. Drag on a point of a sheet is
    /// its share of the drag on triangles, with wind.
    Law(&'static str),
    /// The spring to that body.
    Spring(Entity),
}

impl ForceCause {
    /// Name in summaries: `push`, `springs`, or the name of the law.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Push => "push",
            Self::Law(name) => name,
            Self::Spring(_) => "springs",
        }
    }
}

/// Computes the forces on `body` in its current state by cause, N, as the next step evaluates them at its start. Their
/// sum is mass times acceleration.
///
/// Damping is `-m c v` under every model, which is the limit of `tutorial` and `clamped` for short steps. Speed limits
/// are not forces and are left out. No force acts along a locked axis. Under position Verlet laws are evaluated at the
/// velocity of half a step before, as in a step. The result is empty if the body is immovable, quarantined, not born, or has
/// no physics.
#[must_use]
pub fn forces_on(world: &World, body: Entity) -> Vec<(ForceCause, Vector)> {
    let pushes: Vec<_> =
        world.get_resource::<PushQueue>().into_iter().flat_map(PushQueue::pending).collect();
    let mut forces = Vec::new();
    each_force(world, &pushes, &[body], |_, cause, newtons| forces.push((cause, newtons)));
    forces
}

/// Computes the forces of [`forces_on`] for many bodies in one pass over the springs, and calls `each` with the index
/// of the body in `bodies`, the cause and the force, N. Uses `pushes` instead of the pushes that wait for the next tick.
pub fn each_force(
    world: &World,
    pushes: &[Push],
    bodies: &[Entity],
    mut each: impl FnMut(usize, ForceCause, Vector),
) {
    let coming = coming_couplings(world);
    let mut indices = EntityHashMap::with_capacity(bodies.len());
    let mut in_sheets = vec![false; bodies.len()];
    indices.extend(bodies.iter().enumerate().map(|(index, body)| (*body, index)));
    for (coupling, members) in couplings(world, coming.as_deref()) {
        for row in &coupling.in_sheets {
            if let Some(index) = indices.get(&members[*row as usize]) {
                in_sheets[*index] = true;
            }
        }
    }
    let forces = BodyForces::of(world, pushes);
    for (index, body) in bodies.iter().enumerate() {
        forces.on_body(*body, in_sheets[index], |cause, newtons| each(index, cause, newtons));
    }
    for (coupling, members) in couplings(world, coming.as_deref()) {
        let index = |body: &Entity| indices.get(body).copied();
        let wanted: Vec<_> = members[..coupling.movable].iter().map(index).collect();
        if wanted.iter().any(Option::is_some) {
            let group = ObservedGroup::of(world, coupling, members, wanted);
            forces.between(&group, |row, cause, newtons| {
                if let Some(index) = group.wanted.get(row).copied().flatten() {
                    each(index, cause, open(world.get(members[row]).copied(), newtons));
                }
            });
        }
    }
}

/// The names of the laws of this crate by which bodies have potential energy.
pub const LAWS_WITH_POTENTIAL: &[&str] = &["gravity", "wells", "springs", "mutual_gravity"];

/// Calls `each` with the index of every body in `bodies` that has potential energy by a law, the name of the law and the
/// energy, J, in the current state. The energy of a spring or of mutual gravity is split evenly between its two bodies,
/// immovable ones included: the sum over all bodies is [`Totals::potential_energy`](crate::Totals::potential_energy).
pub fn each_potential_energy(
    world: &World,
    bodies: &[Entity],
    mut each: impl FnMut(usize, &'static str, Scalar),
) {
    let coming = coming_couplings(world);
    let mut indices = EntityHashMap::with_capacity(bodies.len());
    indices.extend(bodies.iter().enumerate().map(|(index, body)| (*body, index)));
    let environment = BodyForces::of(world, &[]).environment;
    for (index, body) in bodies.iter().enumerate() {
        if let (Some(state), Ok(entity)) = (movable(world, *body), world.get_entity(*body)) {
            let options = options_of(entity);
            for law in environment.on_body(&options, false).filter(|law| law.has_potential()) {
                each(index, law.name(), law.potential_energy(state));
            }
        }
    }
    for (coupling, members) in couplings(world, coming.as_deref()) {
        let wanted: Vec<_> = members.iter().map(|body| indices.get(body).copied()).collect();
        let group = ObservedGroup::of(world, coupling, members, wanted);
        let mut halves = |law, ([a, b], energy): ([usize; 2], Scalar)| {
            for index in [a, b].into_iter().filter_map(|row| group.wanted[row]) {
                each(index, law, energy / 2.0);
            }
        };
        coupling.elastic_energies(&group.x).for_each(|shared| halves("springs", shared));
        if let Some(law) = environment.attraction.filter(|_| coupling.attracts) {
            let shared = coupling.attraction_energies(law, &group.x, &group.w);
            shared.for_each(|shared| halves("mutual_gravity", shared));
        }
    }
}

/// Returns a force without its components along locked axes.
fn open(locks: Option<AxisLocks>, newtons: Vector) -> Vector {
    locks.map_or(newtons, |locks| locks.along_open_axes(newtons))
}

/// The environment of a world's bodies and the pushes on them.
struct BodyForces<'w> {
    world: &'w World,
    environment: Environment<'w>,
    pushes: EntityHashMap<Vector>,
}

impl<'w> BodyForces<'w> {
    fn of(world: &'w World, pushes: &[Push]) -> Self {
        let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
        let tick = world.get_resource::<TimeStep>().map_or(1.0, |step| step.0);
        let pushes = sum_by_body(pushes.iter().copied());
        Self { world, environment: Environment::of(world, clock, tick), pushes }
    }

    /// Forces on one body, except those between bodies.
    fn on_body(&self, body: Entity, in_sheet: bool, mut each: impl FnMut(ForceCause, Vector)) {
        let Some(state) = moving(self.world, body) else { return };
        let Ok(entity) = self.world.get_entity(body) else { return };
        let options = options_of(entity);
        let (mass, locks) = (1.0 / state.inverse_mass, options.locks);
        let applied = entity.get::<Force>().map_or(Vector::ZERO, Force::newtons);
        let queued = self.pushes.get(&body).copied();
        if queued.is_some() || applied != Vector::ZERO {
            each(ForceCause::Push, open(locks, applied + queued.unwrap_or_default()));
        }
        let Environment { times, damping, .. } = self.environment;
        let laws = || self.environment.on_body(&options, in_sheet);
        let substeps = options.substeps.unwrap_or(times.substeps);
        let times = TickTimes { substeps, ..times };
        // A law that jumps in the next step is evaluated on the side of the jump on which the step begins.
        let first = times.segments(&mut laws().flat_map(Law::discontinuities)).iter().next();
        let Some(at) = first.map(|segment| segment.evaluation_time(0.0)) else { return };
        for law in laws() {
            each(ForceCause::Law(law.name()), open(locks, law.acceleration(at, state) * mass));
        }
        if let Some(Damping { rate, .. }) = options.damping(damping) {
            each(ForceCause::Law("damping"), open(locks, state.velocity * (-rate * mass)));
        }
    }

    /// Forces between the rows of a group, on those that are wanted.
    fn between(&self, group: &ObservedGroup<'_>, mut each: impl FnMut(usize, ForceCause, Vector)) {
        let ObservedGroup { coupling, members, wanted, x, v, w } = group;
        let is_wanted = |row: usize| wanted.get(row).is_some_and(Option::is_some);
        for spring in coupling.springs.iter() {
            let [a, b] = spring.ends.map(|end| end as usize);
            if is_wanted(a) || is_wanted(b) {
                let pull = vector(&spring.force([x[a], x[b]], [v[a], v[b]]));
                each(a, ForceCause::Spring(members[b]), pull);
                each(b, ForceCause::Spring(members[a]), -pull);
            }
        }
        if let Some(drag) = self.environment.laws.drag.filter(|_| !coupling.sheets.is_empty()) {
            let mut forces = vec![[0.0; 4]; x.len()];
            coupling.blow(drag, self.environment.times.start, x, v, &mut forces);
            for row in coupling.in_sheets.iter().map(|row| *row as usize) {
                each(row, ForceCause::Law(Law::name(drag)), vector(&forces[row]));
            }
        }
        if let Some(law) = self.environment.attraction.filter(|_| coupling.attracts) {
            for row in (0..coupling.movable).filter(|row| is_wanted(*row)) {
                let pull = |other: usize| coupling.attraction_between(law, [row, other], x, w);
                let others = (0..coupling.rows).filter(|other| *other != row);
                each(row, ForceCause::Law("mutual_gravity"), others.filter_map(pull).sum());
            }
        }
    }
}

/// The state of a body, if forces move it.
fn moving(world: &World, body: Entity) -> Option<BodyState> {
    movable(world, body).filter(|_| world.get::<Quarantined>(body).is_none())
}

/// The state of a body that can move and is born.
fn movable(world: &World, body: Entity) -> Option<BodyState> {
    let entity = world.get_entity(body).ok()?;
    let PhysicsBody { velocity, inverse_mass } = *entity.get()?;
    let position = entity.get::<Transform>()?.position;
    let moves = inverse_mass > 0.0 && !entity.contains::<Dormant>();
    moves.then_some(BodyState { position, velocity, inverse_mass })
}

/// The states of a group's bodies, by row.
struct ObservedGroup<'a> {
    coupling: &'a Coupling,
    members: &'a [Entity],
    /// Index of each movable row among the bodies whose forces are wanted.
    wanted: Vec<Option<usize>>,
    x: Vec<Row>,
    v: Vec<Row>,
    w: Vec<Scalar>,
}

impl<'a> ObservedGroup<'a> {
    fn of(
        world: &World,
        coupling: &'a Coupling,
        members: &'a [Entity],
        wanted: Vec<Option<usize>>,
    ) -> Self {
        let states = states_of(world, members);
        let x = states.iter().map(|state| row_of(state.position)).collect();
        let v = states.iter().map(|state| row_of(state.velocity)).collect();
        let w = states.iter().map(|state| state.inverse_mass).collect();
        Self { coupling, members, wanted, x, v, w }
    }
}
