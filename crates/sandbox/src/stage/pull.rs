//! A body pulled by the pointer: a damped spring from where it was taken to where the pointer is.
//!
//! The force is a push of every tick, so it is recorded, repeated and kept in the ledger as any push is.

use bevy_ecs::entity::Entity;
use glam::DVec3;
use motion::{PhysicsBody, SoftBody};

use crate::stage::Stage;
use crate::stage::soft::mass;
use crate::stage::things::Picked;

/// Angular frequency of the spring, 1/s: what is pulled follows within half a second.
const FREQUENCY: f64 = 8.0;

/// Largest part of a radian that the spring turns a light point in one tick, for every method to stay stable.
const PER_TICK: f64 = 0.4;

/// Most force, in weights of what is pulled on Earth.
const WEIGHTS: f64 = 30.0;

/// The acceleration of a weight, m/s².
const EARTH: f64 = 9.8;

/// What the pointer holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pull {
    /// The body, or a point of a soft body.
    pub body: Entity,
    /// Mass of all that comes with it, kg.
    pub mass: f64,
    /// From the body's middle to where it was taken, m.
    pub offset: DVec3,
    /// How far in front of the camera it was taken, m.
    pub depth: f64,
    /// Where the pointer wants the place at which it was taken, m.
    pub toward: DVec3,
    /// The force of the last tick, N, and whether there would be more without a limit.
    pub newtons: f64,
    pub limited: bool,
}

impl Pull {
    /// A pull of the body that a push at `hit` acts on, if forces move it. It was taken at `place`, m, so `depth` m in front of
    /// the camera.
    pub fn of(stage: &Stage, hit: &Picked, place: DVec3, depth: f64) -> Option<Self> {
        let (body, world) = (hit.pushed?, &stage.sim.world);
        let state = world.get::<PhysicsBody>(body).filter(|state| state.inverse_mass > 0.0)?;
        let soft = world.get::<SoftBody>(hit.entity).map(|soft| mass(world, soft));
        let (mass, offset) = (soft.unwrap_or(state.mass()), place - stage.drawn_position(body)?);
        Some(Self { body, mass, offset, depth, toward: place, newtons: 0.0, limited: false })
    }

    /// The force on the body at `position`, m, in a tick of `step` seconds, N.
    pub fn force(&mut self, position: DVec3, body: &PhysicsBody, step: f64) -> DVec3 {
        let mass = body.mass();
        // Critically damped for all that comes with it; no stiffer than a light point stands.
        let stiffness = (self.mass * FREQUENCY.powi(2)).min(mass * (PER_TICK / step).powi(2));
        let damping = 2.0 * (stiffness * mass).sqrt();
        let force = (self.toward - (position + self.offset)) * stiffness - body.velocity * damping;
        let newtons = force.clamp_length_max(WEIGHTS * self.mass * EARTH);
        (self.newtons, self.limited) = (newtons.length(), newtons != force);
        newtons
    }
}
