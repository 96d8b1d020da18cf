//! The lines of the ledger.

use std::fmt::Debug;
use std::ops::{AddAssign, Div, Sub};

use crate::units::{Scalar, Vector};

/// The type of a line: a number for energy, a vector for momentum and angular momentum.
pub trait Amount:
    Copy + Default + PartialEq + Debug + AddAssign + Sub<Output = Self> + Div<Scalar, Output = Self>
{
}

impl Amount for Scalar {}
impl Amount for Vector {}

/// The lines of a ledger for energy, momentum or angular momentum: the amount that each cause added, negative if it
/// took.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct LedgerLines<T> {
    /// Amount added by applied forces: pushes and held keys.
    pub pushes: T,
    /// Amounts added by laws, by [name](crate::Law::name), in the order in which the laws first acted. The energy lines
    /// have only laws without a potential.
    pub laws: Vec<(&'static str, T)>,
    /// Amount added by damping.
    pub damping: T,
    /// Amount added by speed limits and axis locks.
    pub limits: T,
    /// Amount added by immovable bodies at the other end of springs and mutual gravity. They add energy only while they
    /// move.
    pub anchors: T,
    /// Amount added by changes between two ticks: requests, births and deaths of particles, bodies removed or
    /// quarantined, effects switched.
    pub interventions: T,
    /// The rest of the change, which no cause explains: the amount that the method created, or lost if negative.
    pub residual: T,
}

impl<T: Amount> LedgerLines<T> {
    /// The sum of all lines, which is the change of the whole.
    #[must_use]
    pub fn change(&self) -> T {
        let mut sum = self.accounted_for();
        sum += self.residual;
        sum
    }

    /// The sum of all lines but the residual.
    pub(super) fn accounted_for(&self) -> T {
        let mut sum = self.pushes;
        self.laws.iter().for_each(|(_, amount)| sum += *amount);
        for amount in [self.damping, self.limits, self.anchors, self.interventions] {
            sum += amount;
        }
        sum
    }

    /// Amount added by the law with that name; zero if it has no line.
    #[must_use]
    pub fn law(&self, name: &str) -> T {
        self.laws
            .iter()
            .find(|(law, _)| *law == name)
            .map_or_else(T::default, |(_, amount)| *amount)
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

    /// Mean rates since `earlier`, `seconds` ago.
    fn rate_since(&self, earlier: &Self, seconds: Scalar) -> Self {
        let rate = |now: T, then: T| (now - then) / seconds;
        Self {
            pushes: rate(self.pushes, earlier.pushes),
            laws: self
                .laws
                .iter()
                .map(|(name, now)| (*name, rate(*now, earlier.law(name))))
                .collect(),
            damping: rate(self.damping, earlier.damping),
            limits: rate(self.limits, earlier.limits),
            anchors: rate(self.anchors, earlier.anchors),
            interventions: rate(self.interventions, earlier.interventions),
            residual: rate(self.residual, earlier.residual),
        }
    }
}

/// The lines of energy, momentum and angular momentum over a time: a tick, the last second, or since the ledger was
/// opened.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct LedgerTotals {
    /// Work, J: amounts added to the sum of kinetic and potential energy.
    pub energy: LedgerLines<Scalar>,
    /// Impulse, N s: amounts added to the momentum.
    pub momentum: LedgerLines<Vector>,
    /// Angular impulse about the origin, N m s: amounts added to the angular momentum.
    pub angular_momentum: LedgerLines<Vector>,
}

impl LedgerTotals {
    pub(super) fn add(&mut self, other: &Self) {
        self.energy.add(&other.energy);
        self.momentum.add(&other.momentum);
        self.angular_momentum.add(&other.angular_momentum);
    }

    /// Adds the impulse of a law, N s, and its angular impulse, N m s.
    pub(super) fn add_impulse(&mut self, law: &'static str, impulse: Vector, angular: Vector) {
        self.momentum.add_law(law, impulse);
        self.angular_momentum.add_law(law, angular);
    }

    /// Mean rates, W, N and N m, since `earlier`, `seconds` ago.
    pub(super) fn rate_since(&self, earlier: &Self, seconds: Scalar) -> Self {
        Self {
            energy: self.energy.rate_since(&earlier.energy, seconds),
            momentum: self.momentum.rate_since(&earlier.momentum, seconds),
            angular_momentum: self.angular_momentum.rate_since(&earlier.angular_momentum, seconds),
        }
    }
}

/// Energy of all movable bodies by kind, J. The sum equals that of [`Totals`](crate::Totals).
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Energies {
    /// Kinetic energy: sum of `m v² / 2`, J.
    pub kinetic: Scalar,
    /// Potential energy by law, J: `gravity`, `wells`, `springs`, `mutual_gravity` and your own, each only if it acts.
    pub potential: Vec<(&'static str, Scalar)>,
}

impl Energies {
    /// Sum of kinetic and potential energy, J.
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
