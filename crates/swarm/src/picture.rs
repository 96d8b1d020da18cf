//! The plain data of swarms in a frame.

use bytemuck::{Pod, Zeroable};

use crate::log::SwarmTick;
use crate::swarm::Swarm;

/// A swarm in a frame. Its ticks determine the positions of its particles, which the device computes.
#[derive(Clone, Debug)]
pub struct DrawnSwarm {
    /// What the swarm is. Swarms are told from each other by the list of their velocities at birth.
    pub swarm: Swarm,
    /// The ticks of its log, the newest last.
    pub ticks: Vec<SwarmTick>,
    /// Whether states are kept for going back; otherwise going back starts at the birth of the oldest particle.
    pub goes_back: bool,
    /// How the particles look.
    pub look: SwarmLook,
}

/// How a swarm looks: as sprites.
/// Mirrors `Look` in crates/swarm/shaders/draw.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
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
