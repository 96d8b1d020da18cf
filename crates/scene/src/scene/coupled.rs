//! Springs, soft bodies and emitters as the program uses them, and the keys that declare a scene's effects.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use motion::effects::Effect;
use motion::{Elastic, Link};
use pick::Blades;
use swarm::Swarm;

/// A spring between two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringSpec {
    /// Stable ids of the bodies that it joins: two different ones, neither of them scenery, not both immovable.
    pub ends: [u32; 2],
    /// Its stiffness, damping and rest length.
    pub elastic: Elastic,
    /// Linear red, green and blue, each 0 to 1.
    pub color: [f32; 3],
}

/// A soft body: points, which are bodies of the scene, and springs between them.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftBodySpec {
    /// The beginning of its points' names.
    pub name: String,
    /// Whether its surface is a sheet, against which air flows.
    pub sheet: bool,
    /// Stable ids of its points, at least 2.
    pub points: Range<u32>,
    /// Its springs; ends are numbers of points, counted from the first. Springs are sorted by the point at which they
    /// begin.
    pub links: Arc<[Link]>,
    /// Its surface, by numbers of points: of a chain, none; of a cloth, both its sides once; of a lattice, each
    /// triangle counterclockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The blades as which its points are drawn, if so.
    pub blades: Option<Blades>,
    /// Linear red, green and blue, each 0 to 1.
    pub color: [f32; 3],
}

/// A source of particles with a fixed pool, whose bodies are bodies of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct EmitterSpec {
    /// The beginning of its particles' names.
    pub name: String,
    /// Particles per second, above 0.
    pub rate: f64,
    /// Life of a particle, s, above 0.
    pub life: f64,
    /// Stable id of the body on which it rides, if it does.
    pub rides_on: Option<u32>,
    /// Position of births, m; relative to the body on which it rides, if it does.
    pub position: DVec3,
    /// Stable ids of the pool.
    pub pool: Range<u32>,
    /// The velocity that each body of the pool is born with, m/s.
    pub launches: Vec<DVec3>,
    /// The particles, if they are on a graphics device; the pool is empty then, and the anchor is set when they are spawned.
    pub on_device: Option<Swarm>,
    /// Reciprocal of the mass of a particle, 1/kg.
    pub inverse_mass: f64,
    /// Radius with which a particle is drawn, m, above 0.
    pub radius: f32,
    /// Linear red, green and blue, each 0 to 1.
    pub color: [f32; 3],
}

impl EmitterSpec {
    /// Bytes of a particle on a graphics device: its velocity at birth here, what the device has, and the copies that are read
    /// back for a summary.
    pub(crate) const PARTICLE_ON_DEVICE: u64 = 12 + Swarm::PARTICLE_BYTES + 2 * 32;

    /// Most bytes of states that a device keeps for going back.
    pub(crate) const KEPT_ON_DEVICE: u64 = Swarm::KEPT_BYTES;

    /// Number of particles on a graphics device for which there is room.
    #[must_use]
    pub fn particles_on_device(&self) -> usize {
        self.on_device.as_ref().map_or(0, |particles| particles.launches.len())
    }
}

/// The place at which a scene declares an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Declaration {
    /// The effect.
    pub effect: Effect,
    /// The first key that declares it, as in `gravity` or `bodies[3].max_speed_m_s`.
    pub path: String,
    /// Its line in the scene's text, from 1.
    pub line: Option<usize>,
}
