//! The number of substeps of a tick.

use bevy_ecs::prelude::*;

use crate::state::coupling::structure_changed;

/// Substeps per tick of every body without [`OwnSubsteps`], at least 1.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Substeps(pub u32);

impl Substeps {
    /// Largest number of substeps per tick: a typing error must not stop a program for minutes.
    pub const MOST: u32 = 100_000;

    /// Number of substeps per tick; 1 without the resource.
    pub(crate) fn count(substeps: Option<&Self>) -> u32 {
        substeps.map_or(1, |substeps| substeps.0.max(1))
    }
}

impl Default for Substeps {
    fn default() -> Self {
        Self(1)
    }
}

/// Substeps per tick of this body, at least 1. Present only on bodies with their own number.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(on_insert = structure_changed, on_discard = structure_changed)]
pub struct OwnSubsteps(pub u32);
