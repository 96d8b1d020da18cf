//! Sums of arrays that are only written down, and worked out where they are needed.

use std::ops::{Add, Mul, Sub};

use crate::real::Real;

/// Arrays that a step can reckon with: position, velocity, velocity once more, applied acceleration, an acceleration
/// kept from the step before, and those that the step makes. Yoshida's composition with laws of the velocity makes six.
pub(crate) const SLOTS: usize = 15;
/// The positions at the start of the step.
pub(crate) const POSITION: usize = 0;
/// The velocities at the start of the step.
pub(crate) const VELOCITY: usize = 1;
/// The velocities at the start of the step once more, as an increment: what a factor changes of them, where sums are
/// compensated.
pub(crate) const CHANGE: usize = 2;
/// The accelerations by applied forces.
pub(crate) const APPLIED: usize = 3;
/// The accelerations at the end of the step before.
pub(crate) const CACHED: usize = 4;
/// The first array that a step makes.
pub(crate) const FIRST: usize = 5;

/// Positions, velocities or accelerations of all bodies of a group, as factors of arrays.
///
/// A method is written once, over single numbers as over registers; over this it works out what it would do to
/// arrays, and no array is touched before a law asks for a state or the step is over. The stages of a method
/// then cost one pass each, whatever they are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Combination<T> {
    pub factors: [T; SLOTS],
}

impl<T: Real> Combination<T> {
    /// Nothing.
    pub const ZERO: Self = Self { factors: [T::ZERO; SLOTS] };

    /// That array itself.
    pub fn of(slot: usize) -> Self {
        let mut unit = Self::ZERO;
        unit.factors[slot] = T::ONE;
        unit
    }

    /// It times a factor, given as the factor minus 1: its velocities at the start of the step stay a summand of their
    /// own.
    pub fn changed(self, change: T) -> Self {
        let mut more = self * change;
        more.factors[CHANGE] += more.factors[VELOCITY];
        more.factors[VELOCITY] = T::ZERO;
        self + more
    }

    /// The array that it is, if it is one.
    pub fn slot(&self) -> Option<usize> {
        let slot = self.factors.iter().position(|factor| *factor != T::ZERO)?;
        (*self == Self::of(slot)).then_some(slot)
    }
}

impl<T: Real> Add for Combination<T> {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        for (factor, other) in self.factors.iter_mut().zip(other.factors) {
            *factor += other;
        }
        self
    }
}

impl<T: Real> Sub for Combination<T> {
    type Output = Self;

    fn sub(mut self, other: Self) -> Self {
        for (factor, other) in self.factors.iter_mut().zip(other.factors) {
            *factor = *factor - other;
        }
        self
    }
}

impl<T: Real> Mul<T> for Combination<T> {
    type Output = Self;

    fn mul(mut self, by: T) -> Self {
        // An array that is no part of it stays none, by whatever it is multiplied.
        let finite = by.is_finite();
        for factor in &mut self.factors {
            *factor = if finite || *factor != T::ZERO { *factor * by } else { T::ZERO };
        }
        self
    }
}
