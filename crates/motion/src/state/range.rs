//! The range of valid positions and velocities.

use bevy_ecs::prelude::*;

use crate::units::Scalar;

/// The range in which the bodies of a scene have to stay. A body that would leave it is quarantined, like one that
/// would become non-finite. Without this resource every finite number is in range.
///
/// The bounds hold for each coordinate, not for the length of a vector. They are checked at the end of a tick; substeps
/// and stages may exceed them.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Resource))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Range {
    /// Largest magnitude of a coordinate of a position, m, above 0.
    pub position: Scalar,
    /// Largest magnitude of a component of a velocity, m/s, above 0.
    pub speed: Scalar,
}

impl Range {
    /// The range of positions, m, and velocities, m/s, up to these magnitudes.
    #[must_use]
    pub const fn new(position: Scalar, speed: Scalar) -> Self {
        Self { position, speed }
    }

    /// # Panics
    /// If a bound is not above 0.
    pub(crate) fn check(&self) {
        for (bound, of) in [(self.position, "m"), (self.speed, "m/s")] {
            // NaN passes: it quarantines every body.
            assert!(
                bound > 0.0 || bound.is_nan(),
                "no body is within a range of {bound} {of}; give bounds above 0"
            );
        }
    }

    /// The range of all finite numbers.
    pub const FINITE: Self = Self { position: Scalar::MAX, speed: Scalar::MAX };
}

impl Default for Range {
    fn default() -> Self {
        Self::FINITE
    }
}

/// Largest magnitude of each component of a stored state. Bounds are finite, or NaN if the range has NaN; no state is
/// within NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// Bound of positions, m.
    pub position: f64,
    /// Bound of velocities, m/s.
    pub speed: f64,
}

impl Bounds {
    /// The bounds of all finite numbers.
    pub const FINITE: Self = Self { position: f64::MAX, speed: f64::MAX };

    /// The bounds of a range; all finite numbers without one.
    pub fn of(range: Option<&Range>) -> Self {
        let bound = |bound: Scalar| if bound > f64::MAX { f64::MAX } else { bound };
        range.map_or(Self::FINITE, |range| Self {
            position: bound(range.position),
            speed: bound(range.speed),
        })
    }

    pub fn holds_position(&self, x: &[f64]) -> bool {
        x.iter().all(|part| part.abs() <= self.position)
    }

    pub fn holds_velocity(&self, v: &[f64]) -> bool {
        v.iter().all(|part| part.abs() <= self.speed)
    }

    /// Why the new state of a row cannot be stored; `None` if it can. Velocity is checked first. `row` is velocity and inverse
    /// mass.
    pub fn breach(&self, x: &[f64; 3], row: &[f64; 4]) -> Option<Breach> {
        let finite = |numbers: &[f64]| numbers.iter().all(|number| number.is_finite());
        if !self.holds_velocity(&row[..3]) || !row[3].is_finite() {
            Some(Breach { of: Quantity::Velocity, finite: finite(row) })
        } else if !self.holds_position(x) {
            Some(Breach { of: Quantity::Position, finite: finite(x) })
        } else {
            None
        }
    }
}

/// The quantity of a body's state that left its bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Position,
    Velocity,
}

/// Why a new state was not stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Breach {
    /// The quantity that would have left its bounds.
    pub of: Quantity,
    /// Whether the quantity was still finite.
    pub finite: bool,
}
