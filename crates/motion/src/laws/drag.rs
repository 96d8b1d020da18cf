//! Linear and quadratic drag.

use bevy_ecs::prelude::*;

use super::{Affine, BodyState, Jacobians, Law, Moment};
use crate::real::{Real, RealMatrix, RealVector};
use crate::units::Scalar;

/// Drag of a fluid at rest: `a = -c v - k |v| v`. The linear part is Stokes' law of slow motion, the quadratic
/// part Newton's of fast motion, both with the mass already divided out.
///
/// The terminal speed under an acceleration a is the root of `c v + k v² = a`: a / c, or sqrt(a / k).
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct Drag {
    /// Rate c of the linear part, 1/s, at least 0.
    pub linear: Scalar,
    /// Factor k of the quadratic part, 1/m, at least 0.
    pub quadratic: Scalar,
}

impl<T: Real> Law<T> for Drag {
    fn name(&self) -> &'static str {
        "drag"
    }

    fn acceleration(&self, _: Moment<T>, body: BodyState<T>) -> T::Vector {
        let v = body.velocity;
        let speed = v.dot(v).sqrt();
        -(v * (T::of(self.linear) + T::of(self.quadratic) * speed))
    }

    fn jacobians(&self, _: Moment<T>, body: BodyState<T>) -> Jacobians<T> {
        let v = body.velocity;
        let speed = v.dot(v).sqrt();
        let (c, k) = (T::of(self.linear), T::of(self.quadratic));
        // The limit of v v^T / |v| at rest is 0.
        let along = if speed > T::ZERO { T::Matrix::outer(v, v) * (k / speed) } else { T::Matrix::ZERO };
        let velocity = T::Matrix::ZERO - T::Matrix::IDENTITY * (c + k * speed) - along;
        Jacobians { velocity, ..Jacobians::zero() }
    }

    fn depends_on_velocity(&self) -> bool {
        true
    }

    fn affine(&self) -> Option<Affine<T>> {
        (self.quadratic == 0.0).then(|| Affine { constant: T::Vector::ZERO, rate: T::of(self.linear) })
    }
}
