//! The number of substeps of a tick.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::state::coupling::structure_changed;

/// Substeps per tick of every body without [`OwnSubsteps`], from 1 to [`Substeps::MOST`].
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Resource))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Substeps(pub u32);

impl Substeps {
    /// Largest number of substeps per tick: a typing error must not stop a program for minutes.
    pub const MOST: u32 = 100_000;

    /// # Panics
    /// If `count` is 0 or above [`Substeps::MOST`].
    pub fn check(count: u32) {
        let most = Self::MOST;
        assert!(
            (1..=most).contains(&count),
            "a tick cannot be divided into {count} substeps; give from 1 to {most}"
        );
    }

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

/// Substeps per tick of this body, from 1 to [`Substeps::MOST`]; inserting another number panics. Present only on bodies with
/// their own number.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_insert = own_substeps_inserted, on_discard = structure_changed)]
pub struct OwnSubsteps(pub u32);

fn own_substeps_inserted(world: DeferredWorld, context: HookContext) {
    if let Some(OwnSubsteps(count)) = world.get(context.entity) {
        Substeps::check(*count);
    }
    structure_changed(world, context);
}
