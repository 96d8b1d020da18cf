//! The components of a body: three that every body has, and options that only some bodies have.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bytemuck::{Pod, Zeroable};

use crate::state::coupling::structure_changed;
use crate::state::method_state::LastStep;
use crate::units::{Rotation, Scalar, Vector, at_least_0};

/// Position of a thing in the world.
///
/// A tick marks it as changed for every body that it integrates, also for one that ends where it began, because comparing would cost
/// more than moving. So `Changed<Transform>` finds all bodies but those that are [`Static`](crate::Static), dormant or quarantined;
/// to find those that moved, compare with [`PreviousPosition`](crate::PreviousPosition), which says how.
///
/// Orientation is a separate component, so that a step moves no byte that it does not use.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[component(on_add = body_changed, on_remove = body_changed)]
#[repr(C)]
pub struct Transform {
    /// Center of the body in world space, m.
    pub position: Vector,
}

/// Restarts the method of a body whose [`PhysicsBody`] is replaced: the new velocity is that at the time of the position, not
/// that of half a step before.
fn body_discarded(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut last) = world.get_mut::<LastStep>(context.entity) {
        last.0 = 0.0;
    }
    structure_changed(world, context);
}

/// Has the groups compiled again when a body gains or loses a component that every body needs: without it, a body is in no
/// tick.
fn body_changed(world: DeferredWorld, context: HookContext) {
    if world.get_entity(context.entity).is_ok_and(|entity| entity.contains::<PhysicsBody>()) {
        structure_changed(world, context);
    }
}

impl Transform {
    /// Makes a transform at `position`, m.
    #[must_use]
    pub const fn at(position: Vector) -> Self {
        Self { position }
    }
}

/// Velocity and inverse mass w of a moving body (Newton's second law as `a = F w`).
///
/// The step multiplies by the inverse mass; 0 is an infinite mass, which no force, law or NaN moves. Only values
/// above 0 are movable.
///
/// `Changed<PhysicsBody>` does not detect that a tick changed a velocity: a tick writes every row of a table, so that it would
/// be true for every body in every tick. It detects writes by other code.
///
/// Aligned to its size, so that no row crosses a cache line.
#[derive(Component, Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "[Scalar; 4]", into = "[Scalar; 4]"))]
#[repr(C, align(32))]
#[require(Transform, Force)]
#[component(summary_tick, on_insert = structure_changed, on_discard = body_discarded)]
pub struct PhysicsBody {
    /// Linear velocity, m/s.
    pub velocity: Vector,
    /// Reciprocal of the mass, 1/kg; 0 is immovable.
    pub inverse_mass: Scalar,
}

impl From<[Scalar; 4]> for PhysicsBody {
    fn from(row: [Scalar; 4]) -> Self {
        bytemuck::cast(row)
    }
}

impl From<PhysicsBody> for [Scalar; 4] {
    fn from(body: PhysicsBody) -> Self {
        bytemuck::cast(body)
    }
}

impl PhysicsBody {
    /// A body at rest with infinite mass.
    pub const IMMOVABLE: Self = Self { velocity: Vector::ZERO, inverse_mass: 0.0 };

    /// Makes a body at rest of mass `mass`, kg. The body is immovable if the mass is not above 0 and finite, or if its
    /// reciprocal is not finite.
    #[must_use]
    pub fn with_mass(mass: Scalar) -> Self {
        let inverse_mass = 1.0 / mass;
        let movable = mass > 0.0 && inverse_mass.is_finite();
        Self { velocity: Vector::ZERO, inverse_mass: if movable { inverse_mass } else { 0.0 } }
    }

    /// Returns the same body moving at `velocity`, m/s.
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

/// Sum of the forces applied to a body in the current tick, N; zero between ticks.
///
/// Only [`Forces`](crate::Forces) writes it, and keeps the list of pushed bodies, so that applying and clearing touch
/// only those.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[component(on_add = body_changed, on_remove = body_changed)]
#[repr(C)]
pub struct Force(pub(crate) Vector);

impl Force {
    /// Sum of the forces applied so far, N.
    #[must_use]
    pub const fn newtons(&self) -> Vector {
        self.0
    }
}

/// Orientation of a thing, for drawing and picking. Motion is linear, so that no step reads or writes it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct Orientation(pub Rotation);

/// Number of a body in the order of the scene file. Sums, hashes and files are in this order.
///
/// Entity ids are recycled and table rows are swapped on removal, so that neither gives a stable order.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct StableId(pub u32);

/// Largest speed of a body, m/s. A faster velocity is scaled down; its direction stays the same (PhysX,
/// `DyBodyCoreIntegrator.h`). Present only on bodies with a limit.
///
/// The two explicit Eulers limit the velocity after damping and before the move; explicit Euler accelerates after the move, so
/// that what it stores may exceed the limit by the acceleration of one step. Every other method limits what it stores, before and
/// after a tick; within it a body may move faster by the acceleration of one tick.
///
/// At least 0; inserting one below panics. The component is immutable: insert another one to change it.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable, on_insert = speed_limit_inserted)]
pub struct SpeedLimit(pub Scalar);

fn speed_limit_inserted(world: DeferredWorld, context: HookContext) {
    if let Some(SpeedLimit(limit)) = world.get(context.entity) {
        at_least_0(*limit, "a speed limit", "m/s");
    }
}

/// World axes along which a body cannot move. The velocity along them is set to zero where the [speed is limited](SpeedLimit),
/// after that (PhysX, `DyBodyCoreIntegrator.h`). Present only on bodies with a locked axis.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct AxisLocks {
    /// No motion along x.
    pub x: bool,
    /// No motion along y.
    pub y: bool,
    /// No motion along z.
    pub z: bool,
}

impl AxisLocks {
    /// Returns a force or an acceleration without its components along locked axes.
    pub(crate) fn along_open_axes(self, v: Vector) -> Vector {
        let open = |part, locked| if locked { 0.0 } else { part };
        Vector::new(open(v.x, self.x), open(v.y, self.y), open(v.z, self.z))
    }
}

/// Marks a body on which uniform gravity does not act; every other force and law does.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct GravityOff;

/// Marks a quarantined body, which would have become non-finite or left the [`Range`](crate::Range). It stays in its
/// last valid state and every system skips it. [`Quarantine`](crate::Quarantine) says when and why, and
/// [releases](crate::Quarantine::release) it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct Quarantined;
