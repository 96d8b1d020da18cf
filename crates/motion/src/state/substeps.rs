//! Into how many substeps a tick is divided.

use bevy_ecs::prelude::*;

use crate::state::coupling::structure_changed;

/// Parts into which a tick is divided for every body without [`OwnSubsteps`], at least 1.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Substeps(pub u32);

impl Substeps {
    /// Most parts that a tick may have: a slip of the finger must not stop a program for minutes.
    pub const MOST: u32 = 100_000;

    /// How many parts a tick has, 1 where nothing is said.
    pub(crate) fn parts(substeps: Option<&Self>) -> u32 {
        substeps.map_or(1, |substeps| substeps.0.max(1))
    }
}

impl Default for Substeps {
    fn default() -> Self {
        Self(1)
    }
}

/// Parts into which a tick is divided for this body, at least 1. Present only on bodies that ask for it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(on_insert = structure_changed, on_discard = structure_changed)]
pub struct OwnSubsteps(pub u32);
