//! The pull of the pointer on a body: a damped spring from the grabbed point to the pointer.
//!
//! The force is a push in every tick, so it is recorded, repeated and entered into the ledger like any push.

use bevy_ecs::entity::Entity;
use glam::DVec3;
use motion::{PhysicsBody, SoftBody};

use crate::stage::Stage;
use crate::stage::soft::mass;
use crate::stage::things::Picked;

/// Angular frequency of the spring, 1/s: the pulled body follows within half a second.
const FREQUENCY: f64 = 8.0;

/// Maximum phase of the spring per tick for the pulled body alone, rad, so that every method stays stable.
const PER_TICK: f64 = 0.4;

/// Maximum force, in units of the pulled mass's weight on Earth.
const WEIGHTS: f64 = 30.0;

/// Gravitational acceleration on Earth, m/s².
const EARTH: f64 = 9.8;

/// A pull of the pointer on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pull {
    /// The body, or a point of a soft body.
    pub body: Entity,
    /// Mass of the body, or of all movable points of its soft body, kg.
    pub mass: f64,
    /// From the body's center to the grabbed point, m.
    pub offset: DVec3,
    /// Depth of the grabbed point in front of the camera, m.
    pub depth: f64,
    /// Target of the grabbed point, at the pointer, m.
    pub toward: DVec3,
    /// The force of the last tick, N.
    pub newtons: f64,
    /// Whether the maximum force limited it.
    pub limited: bool,
}

impl Pull {
    /// A pull of the body that a push at `hit` acts on, if forces move the body. The grabbed point is `place`, m, at `depth`, m,
    /// in front of the camera.
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
        // Stiffness for the whole mass, limited to the stable range of this body; critically damped for this body.
        let stiffness = (self.mass * FREQUENCY.powi(2)).min(mass * (PER_TICK / step).powi(2));
        let damping = 2.0 * (stiffness * mass).sqrt();
        let force = (self.toward - (position + self.offset)) * stiffness - body.velocity * damping;
        let newtons = force.clamp_length_max(WEIGHTS * self.mass * EARTH);
        (self.newtons, self.limited) = (newtons.length(), newtons != force);
        newtons
    }
}
