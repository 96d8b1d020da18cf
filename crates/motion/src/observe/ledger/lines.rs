//! The lines of the books.

use std::fmt::Debug;
use std::ops::{AddAssign, Div, Sub};

use crate::units::{Scalar, Vector};

/// What is summed up: a number or a vector.
pub trait Amount:
    Copy + Default + PartialEq + Debug + AddAssign + Sub<Output = Self> + Div<Scalar, Output = Self>
{
}

impl Amount for Scalar {}
impl Amount for Vector {}

/// What was added to a sum over all bodies, by what added it; negative is taken away.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LedgerLines<T> {
    /// By applied forces: pushes, held keys.
    pub pushes: T,
    /// By laws, each under its [name](crate::Law::name), in the order in which they were first met. Of an energy
    /// only by those that have no potential.
    pub laws: Vec<(&'static str, T)>,
    /// By damping.
    pub damping: T,
    /// By speed limits and axis locks.
    pub limits: T,
    /// By immovable bodies at the other end of springs and of mutual gravity. They add energy only while they move.
    pub anchors: T,
    /// By whatever happened between two ticks, and by what comes and goes: requests, births and deaths of particles,
    /// bodies removed or quarantined, effects switched.
    pub interventions: T,
    /// By nothing that acts: what the method invented, or lost where it is negative.
    pub residual: T,
}

impl<T: Amount> LedgerLines<T> {
    /// The sum of all lines: how much the whole changed.
    #[must_use]
    pub fn change(&self) -> T {
        let mut sum = self.accounted_for();
        sum += self.residual;
        sum
    }

    /// What is accounted for: all but the residual.
    pub(super) fn accounted_for(&self) -> T {
        let mut sum = self.pushes;
        self.laws.iter().for_each(|(_, amount)| sum += *amount);
        for amount in [self.damping, self.limits, self.anchors, self.interventions] {
            sum += amount;
        }
        sum
    }

    /// What the law of that name added; zero if there is none.
    #[must_use]
    pub fn law(&self, name: &str) -> T {
        self.laws.iter().find(|(law, _)| *law == name).map_or_else(T::default, |(_, amount)| *amount)
    }

    pub(super) fn add_law(&mut self, name: &'static str, amount: T) {
        match self.laws.iter_mut().find(|(law, _)| *law == name) {
            Some((_, sum)) => *sum += amount,
            None => self.laws.push((name, amount)),
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.pushes += other.pushes;
        other.laws.iter().for_each(|(name, amount)| self.add_law(name, *amount));
        self.damping += other.damping;
        self.limits += other.limits;
        self.anchors += other.anchors;
        self.interventions += other.interventions;
        self.residual += other.residual;
    }

    /// What was added since `earlier`, a second.
    fn rate_since(&self, earlier: &Self, seconds: Scalar) -> Self {
        let rate = |now: T, then: T| (now - then) / seconds;
        Self {
            pushes: rate(self.pushes, earlier.pushes),
            laws: self.laws.iter().map(|(name, now)| (*name, rate(*now, earlier.law(name)))).collect(),
            damping: rate(self.damping, earlier.damping),
            limits: rate(self.limits, earlier.limits),
            anchors: rate(self.anchors, earlier.anchors),
            interventions: rate(self.interventions, earlier.interventions),
            residual: rate(self.residual, earlier.residual),
        }
    }
}

/// The books of energy and momentum over some time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LedgerTotals {
    /// Work, J: what was added to the sum of kinetic and potential energy.
    pub energy: LedgerLines<Scalar>,
    /// Impulse, N s: what was added to the momentum.
    pub momentum: LedgerLines<Vector>,
}

impl LedgerTotals {
    pub(super) fn add(&mut self, other: &Self) {
        self.energy.add(&other.energy);
        self.momentum.add(&other.momentum);
    }

    /// W and N: what was added since `earlier`, a second.
    pub(super) fn rate_since(&self, earlier: &Self, seconds: Scalar) -> Self {
        Self {
            energy: self.energy.rate_since(&earlier.energy, seconds),
            momentum: self.momentum.rate_since(&earlier.momentum, seconds),
        }
    }
}

/// Energy of all movable bodies by kind, J. Its sum is that of [`Totals`](crate::Totals).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energies {
    /// Sum of `m v² / 2`.
    pub kinetic: Scalar,
    /// Potential energy by law: `gravity`, `wells`, `springs`, `mutual_gravity` and one's own, each only where it acts.
    pub potential: Vec<(&'static str, Scalar)>,
}

impl Energies {
    /// Kinetic and potential energy, J.
    #[must_use]
    pub fn total(&self) -> Scalar {
        self.kinetic + self.potential.iter().map(|(_, energy)| energy).sum::<Scalar>()
    }

    pub(super) fn add_potential(&mut self, law: &'static str, energy: Scalar) {
        match self.potential.iter_mut().find(|(name, _)| *name == law) {
            Some((_, sum)) => *sum += energy,
            None => self.potential.push((law, energy)),
        }
    }
}
