//! What methods keep of the rows of a table from tick to tick.

use crate::real::Real;
use crate::state::method_state::Known;

/// The column of what a method keeps.
pub(crate) enum MemoryRows<'a, T> {
    /// It keeps nothing.
    None,
    /// Length of the last step, s.
    LastStep(&'a mut [T]),
    /// The last acceleration.
    Known(&'a mut [Known<T>]),
}

impl<T: Real> MemoryRows<'_, T> {
    /// Length of the last step of the first row, s; 0 where none is kept.
    pub fn last_step(&self) -> T {
        match self {
            Self::LastStep(steps) => steps.first().copied().unwrap_or(T::ZERO),
            Self::None | Self::Known(_) => T::ZERO,
        }
    }

    /// The same rows, borrowed for a part of them.
    pub fn part(&mut self, rows: std::ops::Range<usize>) -> MemoryRows<'_, T> {
        match self {
            Self::None => MemoryRows::None,
            Self::LastStep(steps) => MemoryRows::LastStep(&mut steps[rows]),
            Self::Known(known) => MemoryRows::Known(&mut known[rows]),
        }
    }
    /// Splits the first `rows` off.
    pub fn split_at(self, rows: usize) -> (Self, Self) {
        match self {
            Self::None => (Self::None, Self::None),
            Self::LastStep(steps) => {
                let (first, others) = steps.split_at_mut(rows);
                (Self::LastStep(first), Self::LastStep(others))
            }
            Self::Known(known) => {
                let (first, others) = known.split_at_mut(rows);
                (Self::Known(first), Self::Known(others))
            }
        }
    }
}
