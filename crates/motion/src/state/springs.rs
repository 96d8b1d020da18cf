//! Springs between two bodies, and soft bodies of points and springs.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use crate::state::coupling::structure_changed;
use crate::units::at_least_0;

/// Stiffness, damping and rest length of a spring. The force on its first end is `F = (k (L - L0) + c u) n` and the
/// opposite on its second, with the unit vector n from the first end to the second, their distance L and its rate of
/// change u.
///
/// The force is zero while both ends are at the same position, because n is not defined there.
///
/// With [`pull_only`](Self::pull_only) it is a cord, which is slack, without any force, where the force would push or the
/// ends are nearer than L0. It tightens and slackens within a step: a group with cords ends a step there and takes the
/// rest as another one, so that every method keeps its order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Elastic {
    /// Stiffness k, N/m, at least 0.
    pub stiffness: f64,
    /// Damping c along the axis, N s/m, at least 0.
    pub damping: f64,
    /// Rest length L0, m, at least 0.
    pub rest_length: f64,
    /// Whether it pulls and never pushes: a cord, rope or bungee.
    pub pull_only: bool,
}

impl Elastic {
    /// A spring of that stiffness, N/m, and rest length, m, without damping.
    #[must_use]
    pub const fn new(stiffness: f64, rest_length: f64) -> Self {
        Self { stiffness, damping: 0.0, rest_length, pull_only: false }
    }

    /// The same with [`damping`](Self::damping), N s/m.
    #[must_use]
    pub const fn damped(self, damping: f64) -> Self {
        Self { damping, ..self }
    }

    /// The same as a cord, which [only pulls](Self::pull_only).
    #[must_use]
    pub const fn pulling_only(self) -> Self {
        Self { pull_only: true, ..self }
    }

    /// The bits of its numbers: springs with equal bits are interchangeable.
    pub(crate) fn bits(&self) -> ([u64; 3], bool) {
        ([self.stiffness, self.damping, self.rest_length].map(f64::to_bits), self.pull_only)
    }

    /// Force with which it pulls its ends together, N, at their distance `length`, m, that changes by `rate`, m/s.
    #[must_use]
    pub fn tension(&self, length: f64, rate: f64) -> f64 {
        let tension = self.stiffness * (length - self.rest_length) + self.damping * rate;
        let slack = self.pull_only && !(length > self.rest_length && tension > 0.0);
        if slack { 0.0 } else { tension }
    }

    /// Energy stored at a distance `length` of its ends, J: `k (L - L0)² / 2`, and 0 in a cord that is shorter than L0.
    #[must_use]
    pub fn energy(&self, length: f64) -> f64 {
        let stretch = length - self.rest_length;
        if self.pull_only && stretch < 0.0 { 0.0 } else { 0.5 * self.stiffness * stretch * stretch }
    }

    /// # Panics
    /// If a number is below 0.
    pub(crate) fn check(&self) {
        at_least_0(self.stiffness, "the stiffness of a spring", "N/m");
        at_least_0(self.damping, "the damping of a spring", "N s/m");
        at_least_0(self.rest_length, "the rest length of a spring", "m");
    }
}

/// A spring between two bodies, as a separate entity. The component is immutable: insert another one to change it.
///
/// The spring is inert if an end no longer exists, has no physics, is disabled or quarantined, or is a particle of an
/// [`Emitter`](crate::Emitter), which is logged. The first tick panics if a number is below 0.
///
/// ```
/// use bevy_ecs::prelude::*;
/// use motion::prelude::*;
///
/// let mut world = World::new();
/// let wall = world.spawn(PhysicsBody::IMMOVABLE).id();
/// let mass = world.spawn((motion::Transform::at(Vector::X * 1.5), PhysicsBody::with_mass(2.0))).id();
/// world.spawn(Spring { ends: [wall, mass], elastic: Elastic::new(8.0, 1.0) });
/// let turn = std::f64::consts::TAU * (2.0_f64 / 8.0).sqrt();
/// let mut stepper = Stepper::new(&mut world, Method::VelocityVerlet, TimeStep(turn / 100.0));
/// (0..100).for_each(|_| stepper.tick(&mut world));
/// // Half a meter longer than at rest, it is back there after a period of 2 π sqrt(m / k).
/// let position = world.get::<motion::Transform>(mass).unwrap().position;
/// assert!((position - Vector::X * 1.5).length() < 1e-3);
/// ```
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable, on_insert = structure_changed, on_discard = structure_changed)]
pub struct Spring {
    /// The bodies that the spring joins.
    pub ends: [Entity; 2],
    /// Its stiffness, damping and rest length.
    pub elastic: Elastic,
}

/// A spring of a soft body. Its ends are indices into [`SoftBody::points`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// The points that the spring joins.
    pub ends: [u32; 2],
    /// Its stiffness, damping and rest length.
    pub elastic: Elastic,
}

/// A body of points and springs. Its points are bodies like all others; the soft body is a separate entity. The
/// component is immutable: insert another one to change it.
#[derive(Component, Clone, Debug, Default, PartialEq)]
#[component(immutable, on_insert = structure_changed, on_discard = structure_changed)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct SoftBody {
    /// The points. Springs and triangles of a point that no longer exists or is quarantined are inert.
    pub points: Vec<Entity>,
    /// The springs, in the order in which their forces are summed. Shared with the description of the body.
    pub springs: Arc<[Link]>,
    /// The triangles of the surface, as indices into `points`, for drawing and picking. Empty for a rope.
    pub triangles: Vec<[u32; 3]>,
    /// Whether the surface is a sheet: [`Drag`](crate::Drag) then acts on each triangle along its normal instead of on
    /// each point.
    pub sheet: bool,
}

impl SoftBody {
    /// A body of these points and springs, without a surface. [`SoftForm`](crate::SoftForm) makes ropes, cloths and blocks.
    #[must_use]
    pub fn new(points: Vec<Entity>, springs: impl Into<Arc<[Link]>>) -> Self {
        Self { points, springs: springs.into(), ..Self::default() }
    }

    /// The same with a surface, which is a [`sheet`](Self::sheet) or not.
    #[must_use]
    pub fn with_surface(self, triangles: Vec<[u32; 3]>, sheet: bool) -> Self {
        Self { triangles, sheet, ..self }
    }
}
