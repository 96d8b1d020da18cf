//! Thrust: engines whose force follows a curve over time.

use super::{BodyState, EvaluationTime, Jacobians, Law};
use crate::units::{Scalar, Vector};

/// A force as a function of time, N.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum Curve {
    /// A polynomial with the coefficients of 1, t, t², ... in N, N/s, N/s², ...
    Polynomial(Vec<Vector>),
    /// A sine: `amplitude sin(w t + phase)`.
    Sine {
        /// Largest force, N.
        amplitude: Vector,
        /// w, rad/s.
        angular_frequency: Scalar,
        /// Phase at t = 0, rad.
        phase: Scalar,
    },
    /// A table of strictly ascending times, s, and forces, N: linear between them, constant before the first and after
    /// the last.
    Table(Vec<(Scalar, Vector)>),
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

    /// The force, N. A table takes the two points around `at.within_step`, even if `at.time` is not between them.
    fn newtons(&self, at: EvaluationTime) -> Vector {
        match self {
            Self::Polynomial(coefficients) => coefficients
                .iter()
                .rev()
                .fold(Vector::ZERO, |sum, coefficient| sum * at.time + *coefficient),
            Self::Sine { amplitude, angular_frequency, phase } => {
                *amplitude * libm::sin(angular_frequency * at.time + phase)
            }
            Self::Table(points) => {
                let next = points.partition_point(|(time, _)| *time <= at.within_step);
                match (next.checked_sub(1).and_then(|last| points.get(last)), points.get(next)) {
                    (Some((t0, f0)), Some((t1, f1))) => {
                        let part = (at.time - t0) / (t1 - t0);
                        *f0 + (*f1 - *f0) * part
                    }
                    (Some((_, force)), None) | (None, Some((_, force))) => *force,
                    (None, None) => Vector::ZERO,
                }
            }
        }
    }
}

/// An engine: a force that follows a curve while the engine is on. The acceleration is the force times the inverse
/// mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Thrust {
    curve: Curve,
    from: Scalar,
    until: Scalar,
    discontinuities: Vec<Scalar>,
}

impl Thrust {
    /// Makes an engine that follows `curve` from `from`, s, until `until`, s; both may be infinite. The curve is a
    /// function of the time since the start of the scene, not since `from`.
    #[must_use]
    pub fn new(curve: Curve, from: Scalar, until: Scalar) -> Self {
        let mut discontinuities = vec![from, until];
        if let Curve::Table(points) = &curve {
            discontinuities.extend(
                points.iter().map(|(time, _)| *time).filter(|time| (from..until).contains(time)),
            );
        }
        discontinuities.retain(|time| time.is_finite());
        discontinuities.sort_by(Scalar::total_cmp);
        discontinuities.dedup();
        Self { curve, from, until, discontinuities }
    }

    /// The force over time.
    #[must_use]
    pub const fn curve(&self) -> &Curve {
        &self.curve
    }
}

impl Law for Thrust {
    fn name(&self) -> &'static str {
        "thrusts"
    }

    fn acceleration(&self, at: EvaluationTime, body: BodyState) -> Vector {
        let on = at.within_step >= self.from && at.within_step < self.until;
        if on { self.curve.newtons(at) * body.inverse_mass } else { Vector::ZERO }
    }

    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians::zero()
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }

    fn discontinuities(&self) -> &[Scalar] {
        &self.discontinuities
    }
}
