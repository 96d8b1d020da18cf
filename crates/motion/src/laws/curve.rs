//! Curves: vectors that are functions of time.

use super::EvaluationTime;
use crate::units::{Scalar, Vector};

/// A vector as a function of time: the force of a [`Thrust`](crate::Thrust), N, or the displacement of a
/// [`PrescribedMotion`](crate::PrescribedMotion), m.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum Curve {
    /// A polynomial with the coefficients of 1, t, t², ... in N, N/s, N/s², ... or m, m/s, m/s², ...
    Polynomial(Vec<Vector>),
    /// A sine: `amplitude sin(w t + phase)`.
    Sine {
        /// Largest value, N or m.
        amplitude: Vector,
        /// w, rad/s.
        angular_frequency: Scalar,
        /// Phase at t = 0, rad.
        phase: Scalar,
    },
    /// A table of strictly ascending times, s, and values, N or m: linear between them, constant before the first and after
    /// the last.
    Table(Vec<(Scalar, Vector)>),
}

/// A point of a table.
type Point = (Scalar, Vector);

/// The points of a table before and after the time `at.within_step`, even if `at.time` is not between them.
fn around(points: &[Point], at: EvaluationTime) -> [Option<&Point>; 2] {
    let next = points.partition_point(|(time, _)| *time <= at.within_step);
    [next.checked_sub(1).and_then(|last| points.get(last)), points.get(next)]
}

impl Curve {
    /// Number of coefficients of a polynomial, or points of a table.
    #[must_use]
    pub fn points(&self) -> usize {
        match self {
            Self::Polynomial(coefficients) => coefficients.len(),
            Self::Sine { .. } => 0,
            Self::Table(points) => points.len(),
        }
    }

    /// The value, N or m.
    pub(super) fn value(&self, at: EvaluationTime) -> Vector {
        match self {
            Self::Polynomial(coefficients) => coefficients
                .iter()
                .rev()
                .fold(Vector::ZERO, |sum, coefficient| sum * at.time + *coefficient),
            Self::Sine { amplitude, angular_frequency, phase } => {
                *amplitude * libm::sin(angular_frequency * at.time + phase)
            }
            Self::Table(points) => match around(points, at) {
                [Some((t0, f0)), Some((t1, f1))] => {
                    let part = (at.time - t0) / (t1 - t0);
                    *f0 + (*f1 - *f0) * part
                }
                [Some((_, value)), None] | [None, Some((_, value))] => *value,
                [None, None] => Vector::ZERO,
            },
        }
    }

    /// The derivative by time, N/s or m/s.
    pub(super) fn rate(&self, at: EvaluationTime) -> Vector {
        match self {
            Self::Polynomial(coefficients) => {
                let powers = coefficients.iter().enumerate().skip(1).rev();
                powers.fold(Vector::ZERO, |sum, (power, of)| sum * at.time + *of * power as Scalar)
            }
            Self::Sine { amplitude, angular_frequency, phase } => {
                let w = *angular_frequency;
                *amplitude * (w * libm::cos(w * at.time + phase))
            }
            Self::Table(points) => match around(points, at) {
                [Some((t0, f0)), Some((t1, f1))] => (*f1 - *f0) / (t1 - t0),
                _ => Vector::ZERO,
            },
        }
    }

    /// Times at which the curve bends if it is followed from `from`, s, until `until`, s; both may be infinite.
    pub(super) fn bends(&self, from: Scalar, until: Scalar) -> Vec<Scalar> {
        let mut bends = vec![from, until];
        if let Self::Table(points) = self {
            let times = points.iter().map(|(time, _)| *time);
            bends.extend(times.filter(|time| (from..until).contains(time)));
        }
        bends.retain(|time| time.is_finite());
        bends
    }
}

/// Sorts times, s, and removes those that are there twice.
pub(super) fn in_order(mut times: Vec<Scalar>) -> Vec<Scalar> {
    times.sort_by(Scalar::total_cmp);
    times.dedup();
    times
}
