//! The forces on the bodies of a stage, by cause.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::snapshot::LastStep;
use motion::{Damping, DampingModel, ForceCause, Method, PhysicsBody, Push, SoftBody};

use crate::stage::Stage;

impl Stage {
    /// The forces on `body` at its present state, N, by cause; pushes are those of the last tick.
    pub fn forces_on(&self, body: Entity) -> Vec<(ForceCause, DVec3)> {
        let mut forces = Vec::new();
        let each = |_, cause, newtons| forces.push((cause, newtons));
        motion::each_force(&self.sim.world, &self.here.pushes(), &[body], each);
        forces
    }
}

/// The state of a body with the velocity at the time of its position, from the forces on it. Position Verlet stores the
/// velocity half a step earlier.
pub(crate) fn synchronized(
    world: &World,
    body: Entity,
    forces: &[(ForceCause, DVec3)],
) -> Option<PhysicsBody> {
    later(world, body, forces, half_step(world, body))
}

/// The state of a body with the mean velocity of its last and its coming step of `method`, of `step` seconds, without pushes.
/// Semi-implicit Euler, too, moves a body with velocities between two positions.
pub(crate) fn between_steps(
    world: &World,
    body: Entity,
    method: Method,
    step: f64,
) -> Option<PhysicsBody> {
    let is_mean = method == Method::SemiImplicitEuler;
    let half = if is_mean { step / 2.0 } else { half_step(world, body) };
    later(world, body, &motion::forces_on(world, body), half)
}

/// The state of a body with the velocity `seconds` later, from the forces on it.
fn later(
    world: &World,
    body: Entity,
    forces: &[(ForceCause, DVec3)],
    seconds: f64,
) -> Option<PhysicsBody> {
    let state = *world.get::<PhysicsBody>(body)?;
    let damping = damping_model(world);
    let laws = forces.iter().filter(|(cause, _)| is_of_laws(*cause, damping));
    let newtons: DVec3 = laws.map(|(_, newtons)| *newtons).sum();
    Some(state.moving_at(state.velocity + newtons * state.inverse_mass * seconds))
}

/// The state of a soft body with the velocity at the time of its positions. `together` is its movable points as one body.
pub(crate) fn synchronized_points(
    world: &World,
    pushes: &[Push],
    soft: Entity,
    together: PhysicsBody,
) -> PhysicsBody {
    let points = world.get::<SoftBody>(soft).map_or_else(Vec::new, |soft| soft.points.clone());
    let halves: Vec<_> = points.iter().map(|point| half_step(world, *point)).collect();
    let (damping, mut impulse) = (damping_model(world), DVec3::ZERO);
    if halves.iter().any(|half| *half != 0.0) {
        motion::each_force(world, pushes, &points, |place, cause, newtons| {
            if is_of_laws(cause, damping) {
                impulse += newtons * halves[place];
            }
        });
    }
    together.moving_at(together.velocity + impulse * together.inverse_mass)
}

fn half_step(world: &World, body: Entity) -> f64 {
    world.get::<LastStep>(body).map_or(0.0, |last| last.0 / 2.0)
}

fn damping_model(world: &World) -> Option<DampingModel> {
    world.get_resource::<Damping>().map(|damping| damping.model)
}

/// Adds to the sum called `name`, or starts that sum.
pub(crate) fn add_to<N: PartialEq>(sums: &mut Vec<(N, DVec3)>, name: N, newtons: DVec3) {
    match sums.iter_mut().find(|(known, _)| *known == name) {
        Some((_, sum)) => *sum += newtons,
        None => sums.push((name, newtons)),
    }
}

/// Whether a method evaluates `cause` as a law. The velocity already includes pushes, and damping that is not a law.
fn is_of_laws(cause: ForceCause, damping: Option<DampingModel>) -> bool {
    match cause {
        ForceCause::Push => false,
        ForceCause::Law("damping") => damping == Some(DampingModel::Exact),
        ForceCause::Law(_) | ForceCause::Spring(_) => true,
    }
}
