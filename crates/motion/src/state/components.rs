//! What a body is made of: three components that every body has, and those that only a body which asks for
//! an effect carries.

use bevy_ecs::prelude::*;
use bytemuck::{Pod, Zeroable};

use crate::units::{Rotation, Scalar, Vector};

/// Where a thing is.
///
/// Slim on purpose: orientation is a component of its own, so that a step moves no byte that it does not use.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Transform {
    /// Centre of the body in world space, m.
    pub position: Vector,
}

impl Transform {
    /// A transform at `position`, m.
    #[must_use]
    pub const fn at(position: Vector) -> Self {
        Self { position }
    }
}

/// What makes a thing move: its velocity and the reciprocal of its mass (Newton's second law as `a = F w`).
///
/// Inverse mass is what the step multiplies by; 0 stands for an infinite mass, which no force, law or NaN
/// moves. Only values above 0 count as movable.
///
/// Aligned to its size, so that no row lies across two cache lines.
#[derive(Component, Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
#[require(Transform, Force)]
pub struct PhysicsBody {
    /// Linear velocity, m/s.
    pub velocity: Vector,
    /// Reciprocal of the mass, 1/kg; 0 is immovable.
    pub inverse_mass: Scalar,
}

impl PhysicsBody {
    /// A body at rest with an infinite mass.
    pub const IMMOVABLE: Self = Self { velocity: Vector::ZERO, inverse_mass: 0.0 };

    /// A body at rest of mass `mass`, kg. A mass that is not above 0 and finite, or whose reciprocal is not
    /// finite, makes it immovable.
    #[must_use]
    pub fn with_mass(mass: Scalar) -> Self {
        let inverse_mass = 1.0 / mass;
        let movable = mass > 0.0 && inverse_mass.is_finite();
        Self { velocity: Vector::ZERO, inverse_mass: if movable { inverse_mass } else { 0.0 } }
    }

    /// The same body moving at `velocity`, m/s.
    #[must_use]
    pub const fn moving_at(self, velocity: Vector) -> Self {
        Self { velocity, ..self }
    }

    /// Mass, kg; infinite for an immovable body.
    #[must_use]
    pub fn mass(&self) -> Scalar {
        if self.inverse_mass > 0.0 { 1.0 / self.inverse_mass } else { Scalar::INFINITY }
    }

    /// Momentum `m v`, kg m/s; zero for an immovable body, whose momentum is not defined.
    #[must_use]
    pub fn momentum(&self) -> Vector {
        if self.inverse_mass > 0.0 { self.velocity / self.inverse_mass } else { Vector::ZERO }
    }

    /// Kinetic energy `m v² / 2`, J; zero for an immovable body.
    #[must_use]
    pub fn kinetic_energy(&self) -> Scalar {
        0.5 * self.momentum().dot(self.velocity)
    }
}

/// Sum of the forces applied to a body in the running tick, N; zero between ticks.
///
/// The only writer is [`Forces`](crate::Forces), which keeps the list of pushed bodies, so that applying and
/// clearing touch only those.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Force(pub(crate) Vector);

impl Force {
    /// Sum of the forces applied so far, N.
    #[must_use]
    pub const fn newtons(&self) -> Vector {
        self.0
    }
}

/// How a thing is turned. Drawn and picked; the motion is linear, so no step reads or writes it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Orientation(pub Rotation);

/// The body's number in the order of the scene file; what sums, hashes and files are ordered by.
///
/// Entity ids are recycled and table rows are swapped on removal, so neither can serve.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StableId(pub u32);

/// Largest speed of the body, m/s: after damping and before the move a faster velocity is scaled down,
/// direction kept (PhysX, `DyBodyCoreIntegrator.h`). Present only on bodies that ask for it.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimit(pub Scalar);

/// World axes along which the body cannot move: their velocity is set to zero just before the move, after the speed
/// limit (PhysX, `DyBodyCoreIntegrator.h`). Present only on bodies that ask for it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AxisLocks {
    /// No motion along x.
    pub x: bool,
    /// No motion along y.
    pub y: bool,
    /// No motion along z.
    pub z: bool,
}

impl AxisLocks {
    /// A force or an acceleration without its parts along locked axes.
    pub(crate) fn open(self, v: Vector) -> Vector {
        let open = |part, locked| if locked { 0.0 } else { part };
        Vector::new(open(v.x, self.x), open(v.y, self.y), open(v.z, self.z))
    }
}

/// Gravity, and gravity alone, passes this body by. Present only on bodies that ask for it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GravityOff;

/// A body that would have turned non-finite or left the [`Range`](crate::Range): frozen for good at its last finite
/// state, ignored by every system. [`Quarantine`](crate::Quarantine) says when and why.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quarantined;
