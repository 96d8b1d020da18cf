//! The plain data of swarms: particles that a device steps and draws from its own buffers.

use std::sync::Arc;

/// Particles that live on the device. The ticks since the birth of the oldest living particle determine their
/// positions, which the device computes.
#[derive(Clone, Debug)]
pub struct Swarm {
    /// State of a particle, and its method.
    pub stepping: SwarmStepping,
    /// Velocity at birth of the particle in each slot, m/s: particle number k is in slot `k % n` of n. Swarms are told from each
    /// other by this list.
    pub launches: Arc<[[f32; 3]]>,
    /// The ticks, the newest last.
    pub ticks: Vec<SwarmTick>,
    /// Whether states are kept for going back; otherwise going back starts at the birth of the oldest particle.
    pub goes_back: bool,
    /// How the particles look.
    pub look: SwarmLook,
}

/// The state that is stored of a particle, and the method that steps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwarmStepping {
    /// Position Verlet: present and last position.
    PositionVerlet,
    /// Semi-implicit Euler: position and velocity.
    SemiImplicitEuler,
    /// Velocity Verlet: position and velocity.
    VelocityVerlet,
}

impl SwarmStepping {
    /// Bytes that a step reads and writes per particle: two rows are read, and position Verlet writes one of them.
    #[must_use]
    pub const fn bytes_per_step(self) -> u64 {
        match self {
            Self::PositionVerlet => 3 * 16,
            Self::SemiImplicitEuler | Self::VelocityVerlet => 4 * 16,
        }
    }
}

/// One tick of a swarm. Times are in seconds from its start, positions in meters relative to the swarm's anchor.
#[derive(Clone, Debug, PartialEq)]
pub struct SwarmTick {
    /// Identifies the state after the tick.
    pub key: u64,
    /// Length, above 0.
    pub step: f32,
    /// Number of substeps, at least 1.
    pub substeps: u32,
    /// Numbers of the first particle that is due in the tick and of the first one after it that is not. Each takes
    /// over its slot.
    pub births: [u64; 2],
    /// Whether the due particles are born; otherwise their slots are free.
    pub born: bool,
    /// Time at which the first of them is born.
    pub first_birth: f32,
    /// Time between two births.
    pub between: f32,
    /// Position of births at the start of the tick.
    pub source: [f32; 3],
    /// Velocity of that position, m/s.
    pub carried: [f32; 3],
    /// Particles below this number are dead.
    pub dead: u64,
    /// Whether the laws differ from those of the tick before.
    pub other_laws: bool,
    /// Whether velocities are reversed before the tick.
    pub reversed: bool,
    /// Phase of gusts at the anchor and the start of the tick, rad.
    pub phase: f32,
    /// The laws of the tick.
    pub laws: SwarmLaws,
}

/// The laws of a swarm: `a = constant - rate v`, plus drag and wells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SwarmLaws {
    /// Constant acceleration, m/s².
    pub constant: [f32; 3],
    /// Rate of linear drag, 1/s.
    pub rate: f32,
    /// Drag `-(c + k |u|) u`, where u is the velocity relative to the air, m/s: c, 1/s, and k, 1/m.
    pub drag: Option<[f32; 2]>,
    /// Velocity of the air, m/s: its mean, and its change in gusts, `across sin p + up sin(2p) / 2`.
    pub air: [[f32; 3]; 3],
    /// Wave vector of gusts, rad/m.
    pub wave: [f32; 3],
    /// Change of their phase, rad/s.
    pub turns: f32,
    /// Wells, each with its position, m, strength, m³/s², and softening, m; at most [`SwarmLaws::WELLS`].
    pub wells: Arc<[[f32; 5]]>,
    /// How damping multiplies velocities, and its rate, 1/s.
    pub damping: Option<(SwarmDamping, f32)>,
}

impl SwarmLaws {
    /// Most wells.
    pub const WELLS: usize = 64;
}

/// How damping multiplies velocities in q = rate times seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwarmDamping {
    /// By `1 - q` after the move.
    Tutorial = 1,
    /// By `max(0, 1 - q)` before the move.
    Clamped = 2,
    /// By `1 / (1 + q)` before the move.
    Implicit = 3,
}

/// How a swarm looks: as sprites.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwarmLook {
    /// The swarm's anchor, relative to the camera, m.
    pub anchor: [f32; 3],
    /// Radius of each particle, m; never drawn smaller than a pixel.
    pub radius_m: f32,
    /// Red, green, blue as displayed and alpha, 0 to 1.
    pub color: [f32; 4],
    /// Part of the last tick between the time of the picture and the end of the tick, 0 to 1.
    pub back: f32,
    /// A particle is drawn along its path over this time, s.
    pub exposure_s: f32,
    /// Life of a particle, s.
    pub life_s: f32,
    /// Last part of its life in which a particle fades away.
    pub fades_in: f32,
}
