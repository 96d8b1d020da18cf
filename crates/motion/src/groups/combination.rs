//! Linear combinations of arrays, evaluated only where they are needed.

use std::ops::{Add, Mul, Sub};

use crate::real::Real;

/// The number of arrays in a step: position, velocity, velocity as an increment, applied acceleration, the cached
/// acceleration, and those that the step makes. Yoshida 4 under laws of the velocity makes six.
pub(crate) const SLOTS: usize = 15;
/// The positions at the start of the step.
pub(crate) const POSITION: usize = 0;
/// The velocities at the start of the step.
pub(crate) const VELOCITY: usize = 1;
/// The velocities at the start of the step as an increment: what a factor changes of them, where sums are
/// compensated.
pub(crate) const CHANGE: usize = 2;
/// The accelerations by applied forces.
pub(crate) const APPLIED: usize = 3;
/// The accelerations at the end of the previous step.
pub(crate) const CACHED: usize = 4;
/// The first array that a step makes.
pub(crate) const FIRST: usize = 5;

/// Positions, velocities or accelerations of all bodies of a group, as factors of arrays.
///
/// A method over this space computes the factors only; no array is read before a law needs a state or the step ends.
/// Each stage then costs one pass over the arrays, however many terms it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Combination<T> {
    pub factors: [T; SLOTS],
}

impl<T: Real> Combination<T> {
    /// The zero of the space.
    pub const ZERO: Self = Self { factors: [T::ZERO; SLOTS] };

    /// The array `slot` itself.
    pub fn of(slot: usize) -> Self {
        let mut unit = Self::ZERO;
        unit.factors[slot] = T::ONE;
        unit
    }

    /// The combination times a factor, given as the factor minus 1: the velocities at the start of the step stay a
    /// separate term.
    pub fn changed(self, change: T) -> Self {
        let mut more = self * change;
        more.factors[CHANGE] += more.factors[VELOCITY];
        more.factors[VELOCITY] = T::ZERO;
        self + more
    }

    /// The slot, if the combination is a single array.
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
        // An array with factor 0 keeps it, also under infinite factors.
        let finite = by.is_finite();
        for factor in &mut self.factors {
            *factor = if finite || *factor != T::ZERO { *factor * by } else { T::ZERO };
        }
        self
    }
}
