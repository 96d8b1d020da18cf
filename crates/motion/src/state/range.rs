//! The range that states have to stay in.

use bevy_ecs::prelude::*;

use crate::real::Real;
use crate::units::Scalar;

/// The range that the bodies of a scene have to stay in. A body that would leave it is quarantined, as one that would
/// turn non-finite is. Present only if the scene declares it: every finite number is in range elsewhere.
///
/// Bounds are of each coordinate, not of a length. They are looked at when a tick is over; substeps and stages in between
/// may go beyond. [`integrate_acceleration`](crate::integrate_acceleration) and
/// [`integrate_velocity`](crate::integrate_velocity) each look for themselves: the schedule has both in one pass where a
/// range is stated.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Largest magnitude of a coordinate of a position, m, above 0.
    pub position: Scalar,
    /// Largest magnitude of a component of a velocity, m/s, above 0.
    pub speed: Scalar,
}

impl Range {
    /// Every finite number.
    pub const FINITE: Self = Self { position: Scalar::MAX, speed: Scalar::MAX };
}

impl Default for Range {
    fn default() -> Self {
        Self::FINITE
    }
}

/// What a state that is stored may be at most, component by component; each bound is finite, or NaN if it was stated so,
/// which nothing holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds<T> {
    /// Of positions, m.
    pub position: T,
    /// Of velocities, m/s.
    pub speed: T,
}

impl<T: Real> Bounds<T> {
    /// Every finite number.
    pub const FINITE: Self = Self { position: T::MAX, speed: T::MAX };

    /// Those of a range, if one is stated.
    pub fn of(range: Option<&Range>) -> Self {
        let bound = |bound: Scalar| if T::of(bound) > T::MAX { T::MAX } else { T::of(bound) };
        range
            .map_or(Self::FINITE, |range| Self { position: bound(range.position), speed: bound(range.speed) })
    }

    pub fn holds_position(&self, x: &[T]) -> bool {
        x.iter().all(|part| part.abs().is_at_most(self.position))
    }

    pub fn holds_velocity(&self, v: &[T]) -> bool {
        v.iter().all(|part| part.abs().is_at_most(self.speed))
    }

    /// What is wrong with the new state of a row, (velocity, inverse mass) in `row`; velocity first.
    pub fn breach(&self, x: &[T; 3], row: &[T; 4]) -> Option<Breach> {
        let finite = |parts: &[T]| parts.iter().all(|part| part.is_finite());
        if !self.holds_velocity(&row[..3]) || !row[3].is_finite() {
            Some(Breach { of: Part::Velocity, finite: finite(row) })
        } else if !self.holds_position(x) {
            Some(Breach { of: Part::Position, finite: finite(x) })
        } else {
            None
        }
    }
}

/// A part of the state of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Position,
    Velocity,
}

/// Why a new state was not stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Breach {
    /// What would have left its bounds.
    pub of: Part,
    /// Whether it would still have been a number.
    pub finite: bool,
}
