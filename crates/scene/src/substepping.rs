//! How ticks are divided into substeps.

use std::cmp::Ordering;
use std::fmt;
use std::str::FromStr;

use bevy_ecs::prelude::*;
use motion::{
    AutoSubsteps, Dormant, OwnSubsteps, Particle, PhysicsBody, PrescribedMotion, Substeps,
};
use serde::{Deserialize, Serialize};

/// How a tick is divided into substeps. In files `4` or `auto(error_m: 1e-3, least: 2, most: 4096)`, where the last two may
/// be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(untagged, expecting = "a whole number or auto(error_m: 1e-3) is expected here")]
pub enum Substepping {
    /// A number, 1 to [`Substeps::MOST`].
    Fixed(u32),
    /// Chosen in every tick.
    Chosen(Choice),
}

/// A way to choose the substeps of every tick. Smaller errors come first.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Choice {
    /// By the error of a tick: see [`AutoSubsteps`].
    Auto {
        /// Largest error of a position in a tick, m, above 0.
        error_m: f64,
        /// Fewest substeps, a power of two from 2 on.
        #[serde(default = "least")]
        least: u32,
        /// Most substeps, a power of two.
        #[serde(default = "most")]
        most: u32,
    },
}

const fn least() -> u32 {
    AutoSubsteps::new(1.0).least
}

const fn most() -> u32 {
    AutoSubsteps::new(1.0).most
}

impl Choice {
    /// Errors above 0 have the order of their bits.
    const fn key(&self) -> (u64, u32, u32) {
        let Self::Auto { error_m, least, most } = self;
        (error_m.to_bits(), *least, *most)
    }
}

impl PartialEq for Choice {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Choice {}

impl PartialOrd for Choice {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Choice {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}

impl Substepping {
    /// Chosen for an error of at most `error_m` in every tick, m.
    #[must_use]
    pub const fn auto(error_m: f64) -> Self {
        Self::Chosen(Choice::Auto { error_m, least: least(), most: most() })
    }

    /// With at most `most` substeps where they are chosen, rounded up to a power of two from 2 to [`Substeps::MOST`] on.
    #[must_use]
    pub fn up_to(mut self, number: u32) -> Self {
        if let Self::Chosen(Choice::Auto { most, .. }) = &mut self {
            *most = number.clamp(2, Substeps::MOST / 2).next_power_of_two();
        }
        self
    }

    /// The division of the ticks of every body in `world` that has no substeps of its own.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let common = world.try_query_filtered::<&AutoSubsteps, Without<OwnSubsteps>>();
        match common.and_then(|mut common| common.iter(world).next().copied()) {
            Some(choice) => choice.into(),
            None => Self::Fixed(
                world.get_resource::<Substeps>().map_or(1, |substeps| substeps.0.max(1)),
            ),
        }
    }

    /// A division that resolves more: `by` times as many substeps, or chosen for an error smaller by the fourth power of that.
    #[must_use]
    pub fn finer(self, by: u32) -> Self {
        match self {
            Self::Fixed(number) => Self::Fixed(number.saturating_mul(by)),
            Self::Chosen(Choice::Auto { error_m, .. }) => {
                let by = f64::from(by);
                Self::auto(error_m / (by * by * by * by))
            }
        }
    }

    /// The number of substeps, unless it is chosen.
    #[must_use]
    pub fn fixed(self) -> Option<u32> {
        match self {
            Self::Fixed(number) => Some(number),
            Self::Chosen(_) => None,
        }
    }

    /// The number of substeps; the least if it is chosen.
    #[must_use]
    pub const fn least(self) -> u32 {
        match self {
            Self::Fixed(number) => number,
            Self::Chosen(Choice::Auto { least, .. }) => least,
        }
    }

    /// The component of bodies whose substeps are chosen.
    #[must_use]
    pub fn choice(self) -> Option<AutoSubsteps> {
        let Self::Chosen(Choice::Auto { error_m, least, most }) = self else { return None };
        let mut choice = AutoSubsteps::new(error_m);
        (choice.least, choice.most, choice.last) = (least, most, least);
        Some(choice)
    }

    /// Divides the ticks of every body in `world` that has no substeps of its own. Particles of emitters do not choose: they have
    /// the least number.
    pub fn put(self, world: &mut World) {
        world.insert_resource(Substeps(self.least()));
        let mut common =
            world.query_filtered::<Entity, (With<AutoSubsteps>, Without<OwnSubsteps>)>();
        for body in common.iter(world).collect::<Vec<_>>() {
            world.entity_mut(body).remove::<AutoSubsteps>();
        }
        let Some(choice) = self.choice() else { return };
        type Common =
            (Without<OwnSubsteps>, Without<PrescribedMotion>, Without<Particle>, Without<Dormant>);
        let mut common = world.query_filtered::<(Entity, &PhysicsBody), Common>();
        let movable = common.iter(world).filter(|(_, body)| body.inverse_mass > 0.0);
        for body in movable.map(|(body, _)| body).collect::<Vec<_>>() {
            world.entity_mut(body).insert(choice);
        }
    }

    /// Says that the most substeps do not keep the error that they are chosen for, if that is so in `world`.
    #[must_use]
    pub fn excess(world: &World) -> Option<String> {
        let exceeded = world
            .try_query::<&AutoSubsteps>()?
            .iter(world)
            .map(|choice| choice.exceeded)
            .max()
            .filter(|exceeded| *exceeded > 0)?;
        Some(format!(
            "the error of {exceeded} ticks is larger than asked for; substeps: auto may take a larger `most`"
        ))
    }

    /// The nearest valid one: what a damaged file holds must not stop a program.
    #[must_use]
    pub fn clamped(self) -> Self {
        match self {
            Self::Fixed(number) => Self::Fixed(number.clamp(1, Substeps::MOST)),
            Self::Chosen(_) if self.fault().is_none() => self,
            Self::Chosen(_) => Self::Fixed(1),
        }
    }

    /// What is wrong with its numbers, if something is, and a cure.
    #[must_use]
    pub fn fault(self) -> Option<(String, String)> {
        let most = Substeps::MOST;
        match self {
            Self::Fixed(number) => (!(1..=most).contains(&number)).then(|| {
                let cure = format!("give a whole number from 1 to {most}");
                (format!("{number} is not a number of substeps"), cure)
            }),
            Self::Chosen(_) => self.choice().filter(|choice| !choice.is_valid()).map(|_| {
                let cure = format!(
                    "give an error_m above 0, and powers of two from 2 to {most} as least and most"
                );
                (format!("{self} cannot choose substeps"), cure)
            }),
        }
    }
}

impl Default for Substepping {
    fn default() -> Self {
        Self::Fixed(1)
    }
}

impl From<u32> for Substepping {
    fn from(number: u32) -> Self {
        Self::Fixed(number)
    }
}

impl From<AutoSubsteps> for Substepping {
    fn from(AutoSubsteps { error, least, most, .. }: AutoSubsteps) -> Self {
        Self::Chosen(Choice::Auto { error_m: error, least, most })
    }
}

/// As in files.
impl FromStr for Substepping {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found: Self = ron::from_str(text).map_err(|_| {
            format!("give a whole number from 1 to {}, or auto(error_m: 1e-3)", Substeps::MOST)
        })?;
        found.fault().map_or(Ok(found), |(_, cure)| Err(cure))
    }
}

/// As in files or, with `#`, for people.
impl fmt::Display for Substepping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Fixed(number) => number.fmt(f),
            Self::Chosen(Choice::Auto { error_m, .. }) if f.alternate() => {
                write!(f, "auto {error_m:?} m")
            }
            Self::Chosen(Choice::Auto { error_m, least, most }) => {
                write!(f, "auto(error_m: {error_m:?}")?;
                if (least, most) != (self::least(), self::most()) {
                    write!(f, ", least: {least}, most: {most}")?;
                }
                f.write_str(")")
            }
        }
    }
}
