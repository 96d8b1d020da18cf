//! Gravity between bodies.

use bevy_ecs::prelude::*;

use crate::state::coupling::structure_changed;
use crate::units::Scalar;

/// Every two bodies attract each other: `F = G m1 m2 r / (r² + s²)^(3/2)` (Newton; softened after Plummer 1911).
///
/// Two bodies at one place do not pull each other. An immovable body attracts if it has a [`SourceMass`]; particles
/// of an [`Emitter`](crate::Emitter) neither pull nor are pulled.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct MutualGravity {
    /// G, m³/(kg s²); negative repels.
    pub constant: Scalar,
    /// s, m, at least 0: keeps the pull finite in close encounters.
    pub softening: Scalar,
}

/// Mass of an immovable body as a source of [`MutualGravity`], kg, above 0.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[component(immutable, on_insert = structure_changed, on_discard = structure_changed)]
pub struct SourceMass(pub Scalar);
