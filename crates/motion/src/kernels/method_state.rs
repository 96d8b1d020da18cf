//! The method state of the rows of a batch.

use crate::state::method_state::CachedAcceleration;

/// The column of a method's state.
pub(crate) enum MethodStateRows<'a> {
    /// The method has no state.
    None,
    /// Length of the last step, s.
    LastStep(&'a mut [f64]),
    /// The cached acceleration.
    LastAcceleration(&'a mut [CachedAcceleration]),
}

impl MethodStateRows<'_> {
    /// Length of the last step of the first row, s; 0 without such a column.
    pub fn last_step(&self) -> f64 {
        match self {
            Self::LastStep(steps) => steps.first().copied().unwrap_or(0.0),
            Self::None | Self::LastAcceleration(_) => 0.0,
        }
    }

    /// Some of the rows.
    pub fn part(&mut self, rows: std::ops::Range<usize>) -> MethodStateRows<'_> {
        match self {
            Self::None => MethodStateRows::None,
            Self::LastStep(steps) => MethodStateRows::LastStep(&mut steps[rows]),
            Self::LastAcceleration(cached) => MethodStateRows::LastAcceleration(&mut cached[rows]),
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
            Self::LastAcceleration(cached) => {
                let (first, others) = cached.split_at_mut(rows);
                (Self::LastAcceleration(first), Self::LastAcceleration(others))
            }
        }
    }
}
