//! The number of substeps of a tick.

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::state::coupling::structure_changed;
use crate::units::Scalar;

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

/// Has a body, and its group, choose its substeps in every tick: the lowest power of two, within `least` and `most`, with which the
/// measured error of the tick is at most `error`. A group takes the setting of its member with the lowest id.
///
/// The error is that of positions, estimated from the states between steps. Simpson's rule on the velocities at the ends of two
/// consecutive steps gives the way of both, to the order 5 in their length; its difference from the way that the method went is
/// summed over the tick. That takes no evaluation. A tick that needs more substeps is integrated again. The number depends on
/// the path of the tick alone and not on the direction in which it is run through, so that a reversible method stays reversible
/// but for the choice of the number itself (Hut, Makino, McMillan 1995).
///
/// The velocities of position Verlet are half a step late: it counts as a method of order 1 here.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[component(on_insert = auto_substeps_inserted, on_discard = structure_changed)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct AutoSubsteps {
    /// Largest error of a position in a tick, m, above 0.
    pub error: Scalar,
    /// Fewest substeps, a power of two from 2 on: the error is measured between two of them.
    pub least: u32,
    /// Most substeps, a power of two.
    pub most: u32,
    /// Substeps of the last tick.
    pub last: u32,
    /// Ticks so far in which `most` did not suffice.
    pub exceeded: u32,
}

impl AutoSubsteps {
    /// Chooses among 2 to 4096 substeps for an error of at most `error`, m, in a tick.
    #[must_use]
    pub const fn new(error: Scalar) -> Self {
        Self { error, least: 2, most: 4096, last: 2, exceeded: 0 }
    }

    /// Whether every number is in its range.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let Self { error, least, most, last, .. } = *self;
        error > 0.0
            && error.is_finite()
            && [least, most, last].iter().all(|number| number.is_power_of_two())
            && 2 <= least
            && (least..=most).contains(&last)
            && most <= Substeps::MOST
    }

    /// The number of substeps for which a tick that had the error `found`, m, with `substeps` substeps of a method of the order
    /// `order` should be repeated or, if it is the same, kept.
    pub(crate) fn wanted(&self, substeps: u32, found: Scalar, order: u32) -> u32 {
        /// The part of the error that a prediction uses, so that it seldom fails.
        const PART: Scalar = 0.7;
        /// Largest factor of one prediction: a tick that is far from resolved says little.
        const MOST: u32 = 8;
        let (mut wanted, mut error) = (substeps, found);
        let factor = Scalar::from(1_u32 << order);
        while error > PART * self.error && wanted < substeps.saturating_mul(MOST) {
            (wanted, error) = (wanted * 2, error / factor);
        }
        while error * factor <= PART * self.error && wanted > 1 {
            (wanted, error) = (wanted / 2, error * factor);
        }
        wanted.clamp(self.least, self.most)
    }
}

fn auto_substeps_inserted(world: DeferredWorld, context: HookContext) {
    if let Some(auto) = world.get::<AutoSubsteps>(context.entity) {
        assert!(
            auto.is_valid(),
            "substeps cannot be chosen by {auto:?}: give a finite error above 0 and powers of two from 2 to {}",
            Substeps::MOST
        );
    }
    structure_changed(world, context);
}
