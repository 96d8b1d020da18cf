//! Effects: what a scene can declare, and switching each off and on.
//!
//! An effect that is off is gone: its resource or its components are taken out of the world, so that the schedule is
//! compiled without it and no column of it is walked. Their values wait in [`Off`](crate::snapshot::Off) and
//! [`OffResource`](crate::snapshot::OffResource).

mod values;

use std::fmt;

use bevy_ecs::prelude::*;

use crate::laws::damping::Damping;
use crate::laws::{self, with_world_laws};
use crate::state::components::{AxisLocks, SpeedLimit};
pub use values::column_bytes;
use values::{
    DAMPING_RATES, EMITTERS, GRAVITY, MUTUAL_GRAVITY, PartOfLaw, SPRINGS, Values, component, law,
    own_laws, resource,
};

macro_rules! effects {
    ($($law:ident: $Law:ident ($($part:ident: $Part:ident)?) $formula:literal;)*) => {
        /// An effect that a scene can declare. In a run in which it is off or not declared, no system, column or branch
        /// of it exists.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
        pub enum Effect {
            /// [`Gravity`](crate::Gravity).
            Gravity,
            /// [`Damping`], of the scene and of single bodies.
            Damping,
            $(
                #[doc = concat!("[`", stringify!($Law), "`](crate::", stringify!($Law), "), also own laws of that name.")]
                $Law,
                $(
                    #[doc = concat!("[`", stringify!($Part), "`](crate::", stringify!($Part), "), a part of ", stringify!($law), ".")]
                    $Part,
                )?
            )*
            /// [`MutualGravity`](crate::MutualGravity).
            MutualGravity,
            /// [`Thrust`](crate::Thrust) of single bodies.
            Thrusts,
            /// [`Spring`](crate::Spring) and [`SoftBody`](crate::SoftBody).
            Springs,
            /// [`SpeedLimit`] of single bodies.
            SpeedLimits,
            /// [`AxisLocks`] of single bodies.
            AxisLocks,
            /// [`Emitter`](crate::Emitter).
            Emitters,
        }

        /// Each effect with its name and its values, in the order of [`Effect`].
        static EFFECTS: &[(Effect, &str, &[Values])] = &[
            (Effect::Gravity, "gravity", &[GRAVITY]),
            (Effect::Damping, "damping", &[resource::<Damping>(), DAMPING_RATES]),
            $(
                (
                    Effect::$Law,
                    stringify!($law),
                    &[law::<laws::$Law>(), own_laws::<{ Effect::$Law as usize }>()],
                ),
                $((Effect::$Part, stringify!($part), &[laws::$Part::VALUES]),)?
            )*
            (Effect::MutualGravity, "mutual_gravity", &[MUTUAL_GRAVITY]),
            (Effect::Thrusts, "thrusts", &[own_laws::<{ Effect::Thrusts as usize }>()]),
            (Effect::Springs, "springs", &[SPRINGS]),
            (Effect::SpeedLimits, "speed_limits", &[component::<SpeedLimit>()]),
            (Effect::AxisLocks, "axis_locks", &[component::<AxisLocks>()]),
            (Effect::Emitters, "emitters", &[EMITTERS]),
        ];
    };
}

with_world_laws!(effects);

impl Effect {
    /// Every effect, in the order of the receipt.
    pub const ALL: [Self; EFFECTS.len()] = {
        let mut all = [Self::Gravity; EFFECTS.len()];
        let mut i = 0;
        while i < all.len() {
            all[i] = EFFECTS[i].0;
            i += 1;
        }
        all
    };

    /// The name of the effect in receipts, scripts, flags and panels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        EFFECTS[self as usize].1
    }

    /// The effect of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|effect| effect.name() == name)
    }

    const fn values(self) -> &'static [Values] {
        EFFECTS[self as usize].2
    }

    /// The number of bodies that the effect acts on in the coming step: 0 while it is off, all ends for springs.
    ///
    /// # Panics
    /// If no stepper was made for `world`.
    pub fn bodies(self, world: &World) -> usize {
        let on = self.values().iter().find(|values| (values.state)(world)[0]);
        on.map_or(0, |values| (values.bodies)(world))
    }

    /// The bytes of the effect's state in `world`, on or off: columns as they are allocated, resources, and the lists
    /// that they hold.
    pub fn bytes(self, world: &World) -> usize {
        self.values().iter().map(|values| (values.bytes)(world)).sum()
    }
}

#[cfg(feature = "serde")]
crate::names::written_by_name!(Effect);

impl fmt::Display for Effect {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// Whether an effect is on, off or not declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum EffectState {
    /// The effect acts.
    On,
    /// The effect was declared and switched off. Its values wait to be switched on.
    Off,
    /// The effect was never declared: it has no value that could be switched on.
    NotDeclared,
}

impl EffectState {
    /// The words for it in receipts and panels.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::On => "on",
            Self::Off => "off",
            Self::NotDeclared => "not declared",
        }
    }
}

/// The error of switching an effect that was never declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NeverDeclared(pub Effect);

impl fmt::Display for NeverDeclared {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "this scene never declared {}", self.0)
    }
}

impl std::error::Error for NeverDeclared {}

/// Whether `effect` is on in `world`.
pub fn state(world: &World, effect: Effect) -> EffectState {
    let state = effect.values().iter().fold([false; 2], |[any_on, any_off], values| {
        let [on, off] = (values.state)(world);
        [any_on || on, any_off || off]
    });
    match state {
        [true, _] => EffectState::On,
        [false, true] => EffectState::Off,
        [false, false] => EffectState::NotDeclared,
    }
}

/// Switches an effect off, or on again, between two ticks. [`Stepper::recompile`](crate::Stepper::recompile) has to
/// follow.
///
/// Off and on again restores every bit, with two exceptions. Position Verlet restarts for bodies whose laws change, and
/// for their groups. An emitter that was off for a tick does not emit the particles that were due in it; those that live
/// when it is switched off live on.
///
/// # Errors
/// If the effect was never declared.
pub fn switch(world: &mut World, effect: Effect, on: bool) -> Result<(), NeverDeclared> {
    let now = state(world, effect);
    let Some(declared) = effect.values().iter().find(|values| (values.state)(world) != [false; 2])
    else {
        return Err(NeverDeclared(effect));
    };
    if (now == EffectState::On) != on {
        (declared.restart)(world);
        effect.values().iter().for_each(|values| (values.switch)(world, on));
    }
    Ok(())
}
