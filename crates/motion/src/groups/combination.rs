//! Linear combinations of arrays, evaluated only where they are needed.

use std::ops::{Add, Mul, Sub};

/// The number of arrays in a step: position, velocity, applied acceleration, cached acceleration, and up to ten that the
/// step computes. Yoshida 4 computes six under laws of the velocity.
pub(crate) const SLOTS: usize = 14;
/// The positions at the start of the step.
pub(crate) const POSITION: usize = 0;
/// The velocities at the start of the step.
pub(crate) const VELOCITY: usize = 1;
/// The accelerations by applied forces.
pub(crate) const APPLIED: usize = 2;
/// The accelerations at the end of the previous step.
pub(crate) const CACHED: usize = 3;
/// The first array that a step computes.
pub(crate) const FIRST: usize = 4;

/// Positions, velocities or accelerations of all bodies of a group, as a linear combination of arrays.
///
/// A method over this space computes the factors only; no array is read before a law needs a state or the step ends.
/// Each stage then costs one pass over the arrays, however many terms it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Combination {
    pub factors: [f64; SLOTS],
}

impl Combination {
    /// The zero of the space.
    pub const ZERO: Self = Self { factors: [0.0; SLOTS] };

    /// The array `slot` itself.
    pub fn of(slot: usize) -> Self {
        let mut unit = Self::ZERO;
        unit.factors[slot] = 1.0;
        unit
    }

    /// The slot, if the combination is a single array.
    pub fn slot(&self) -> Option<usize> {
        let slot = self.factors.iter().position(|factor| *factor != 0.0)?;
        (*self == Self::of(slot)).then_some(slot)
    }
}

impl Add for Combination {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        for (factor, other) in self.factors.iter_mut().zip(other.factors) {
            *factor += other;
        }
        self
    }
}

impl Sub for Combination {
    type Output = Self;

    fn sub(mut self, other: Self) -> Self {
        for (factor, other) in self.factors.iter_mut().zip(other.factors) {
            *factor -= other;
        }
        self
    }
}

impl Mul<f64> for Combination {
    type Output = Self;

    fn mul(mut self, by: f64) -> Self {
        // Factors that are 0 stay 0: 0 times an infinite factor would be NaN.
        let finite = by.is_finite();
        for factor in &mut self.factors {
            *factor = if finite || *factor != 0.0 { *factor * by } else { 0.0 };
        }
        self
    }
}
