//! Mutual gravity: every two bodies attract each other.

use bevy_ecs::prelude::*;

use crate::state::coupling::structure_changed;
use crate::units::{Scalar, at_least_0};

/// Gravity between every two bodies: `F = G m1 m2 r / (r² + s²)^(3/2)` (Newton; softened after Plummer 1911).
///
/// The force is zero between two bodies at the same position. An immovable body attracts if it has a [`SourceMass`].
/// Particles of an [`Emitter`](crate::Emitter) neither attract nor are attracted.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Resource))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct MutualGravity {
    /// G, m³/(kg s²); negative repels.
    pub constant: Scalar,
    /// s, m, at least 0: keeps the force finite in close encounters.
    pub softening: Scalar,
}

impl MutualGravity {
    /// Mutual gravity of that [`constant`](Self::constant), m³/(kg s²), and [`softening`](Self::softening), m.
    #[must_use]
    pub const fn new(constant: Scalar, softening: Scalar) -> Self {
        Self { constant, softening }
    }

    /// # Panics
    /// If its softening is below 0.
    pub(crate) fn check(&self) {
        at_least_0(self.softening, "the softening of mutual gravity", "m");
    }
}

/// Mass of an immovable body as a source of [`MutualGravity`], kg, above 0. It has no effect in a world without that
/// resource.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(immutable, on_insert = structure_changed, on_discard = structure_changed)]
pub struct SourceMass(pub Scalar);
