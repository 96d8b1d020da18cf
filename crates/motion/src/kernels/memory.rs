//! What methods keep of bodies from tick to tick.

use crate::real::Real;

/// The called laws' acceleration at the end of a step, for the next one, if it begins just there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known<T> {
    /// Position and inverse mass that it was evaluated at.
    pub at: [T; 4],
    /// Time that it was evaluated at, s.
    pub time: T,
    /// Which laws were called.
    pub laws: (u64, u64),
    /// Acceleration by the called laws, m/s².
    pub called: [T; 4],
}

impl<T: Real> Default for Known<T> {
    fn default() -> Self {
        // A time that none is equal to.
        Self { at: [T::ZERO; 4], time: T::INFINITY, laws: (0, 0), called: [T::ZERO; 4] }
    }
}

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
}
