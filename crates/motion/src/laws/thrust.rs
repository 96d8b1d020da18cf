//! Thrust: engines whose force follows a curve over time.

use super::curve::in_order;
use super::{BodyState, Curve, EvaluationTime, Jacobians, Law};
use crate::units::{Scalar, Vector};

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
        let discontinuities = in_order(curve.bends(from, until));
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
        if on { self.curve.value(at) * body.inverse_mass } else { Vector::ZERO }
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
