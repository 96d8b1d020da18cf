//! Method state: the data that position Verlet, velocity Verlet and Yoshida 4 keep per body from tick to tick.

use bevy_ecs::prelude::*;

use crate::units::Scalar;

/// Method state of position Verlet: the length of the last step, s. 0 means a start, which takes the Taylor value; a
/// negative length means that velocities were reversed since. Only bodies of that method have it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(transparent)]
pub struct LastStep(pub Scalar);

/// Cached acceleration of velocity Verlet and Yoshida 4: the last acceleration by called laws, which is also the first
/// of the next step. Only bodies of these methods have it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, bytemuck::TransparentWrapper)]
#[repr(transparent)]
pub struct LastAcceleration(pub(crate) CachedAcceleration);

/// Acceleration by the called laws at the end of a step. The next step uses it if it begins in the same state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CachedAcceleration {
    /// Position and inverse mass of the evaluation.
    pub at: [f64; 4],
    /// Time of the evaluation, s.
    pub time: f64,
    /// Version of the world's laws and of the body's own.
    pub laws: (u64, u64),
    /// Acceleration by the called laws, m/s².
    pub acceleration: [f64; 3],
}

impl Default for CachedAcceleration {
    fn default() -> Self {
        // No evaluation happens at an infinite time.
        Self { at: [0.0; 4], time: f64::INFINITY, laws: (0, 0), acceleration: [0.0; 3] }
    }
}
