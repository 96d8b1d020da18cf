//! Springs: between any two bodies, and the many of a soft body.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use crate::state::coupling::structure_changed;
use crate::units::Scalar;

/// How a spring pulls: `F = (k (L - L0) + c u) n` on its first end and the opposite on its second, with the unit
/// vector n and the distance L from the first end to the second and the rate u at which L grows.
///
/// Two ends at one place have no direction between them: the force is zero there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic<T> {
    /// Stiffness k, N/m, at least 0.
    pub stiffness: T,
    /// Damping c along the axis, N s/m, at least 0.
    pub damping: T,
    /// Length L0 at which it does not pull, m, at least 0.
    pub rest_length: T,
}

/// A spring between two bodies, an entity of its own. Replaced as a whole: insert another one to change it.
///
/// An end that is gone, is scenery or was quarantined makes it inert.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[component(immutable, on_insert = structure_changed, on_discard = structure_changed)]
pub struct Spring {
    /// The bodies that it joins.
    pub ends: [Entity; 2],
    /// How it pulls.
    pub elastic: Elastic<Scalar>,
}

/// A spring of a soft body: its ends are numbers of [`SoftBody::points`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// The points that it joins.
    pub ends: [u32; 2],
    /// How it pulls.
    pub elastic: Elastic<Scalar>,
}

/// A body of points and springs, an entity beside its points, which are bodies like all others. Replaced as a
/// whole: insert another one to change it.
#[derive(Component, Clone, Debug, Default, PartialEq)]
#[component(immutable, on_insert = structure_changed, on_discard = structure_changed)]
pub struct SoftBody {
    /// Its points; one that is gone or quarantined takes its springs and triangles with it.
    pub points: Vec<Entity>,
    /// Its springs, in the order in which their forces are summed up; shared with whoever described the body.
    pub springs: Arc<[Link]>,
    /// The triangles of its surface, by points: what is drawn and picked. Of a rope, none.
    pub triangles: Vec<[u32; 3]>,
    /// Whether its surface is a sheet that air flows against: [`Drag`](crate::Drag) then acts on each triangle
    /// along its normal instead of on each point.
    pub sheet: bool,
}
