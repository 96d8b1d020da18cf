//! What methods keep of single bodies from tick to tick.

use bevy_ecs::prelude::*;

use crate::real::Real;
use crate::units::Scalar;

/// What position Verlet keeps of a body: the length of its last step, s. 0 is a start, with the Taylor value;
/// negative, velocities were turned round since. Only bodies of that method carry it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct LastStep(pub Scalar);

/// What velocity Verlet and Yoshida's composition keep of a body where laws are called: the last acceleration,
/// which is the next one's first. Only bodies of these methods carry it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, bytemuck::TransparentWrapper)]
#[repr(transparent)]
pub struct LastAcceleration(pub(crate) Known<Scalar>);

/// The called laws' acceleration at the end of a step, for the next one, if it begins just there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known<T> {
    /// Position and inverse mass that it was evaluated at.
    pub at: [T; 4],
    /// Time that it was evaluated at, s.
    pub time: T,
    /// Which laws were called.
    pub laws: (u64, u64),
    /// Acceleration by the called laws, m/s².
    pub called: [T; 4],
}

impl<T: Real> Default for Known<T> {
    fn default() -> Self {
        // A time that none is equal to.
        Self { at: [T::ZERO; 4], time: T::INFINITY, laws: (0, 0), called: [T::ZERO; 4] }
    }
}
