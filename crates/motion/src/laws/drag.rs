//! Linear and quadratic drag.

use bevy_ecs::prelude::*;

use super::{Affine, Axes, BodyBlock, BodyState, EvaluationTime, Jacobians, Law, Wind, WorldLaw};
use crate::real::{Real, RealMatrix, RealVector};
use crate::units::{Scalar, Vector};

/// Drag of a fluid: `a = -c u - k |u| u`, where u is the velocity relative to the fluid. The fluid is at rest unless
/// there is wind. The linear term is Stokes' law for slow motion, the quadratic term Newton's for fast motion; both are
/// divided by the mass.
///
/// The terminal speed under an acceleration a is the root of `c v + k v² = a`: a / c, or sqrt(a / k).
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct Drag {
    /// Rate c of the linear term, 1/s, at least 0.
    pub linear: Scalar,
    /// Coefficient k of the quadratic term, 1/m, at least 0.
    pub quadratic: Scalar,
    /// Motion of the fluid, if it moves.
    pub wind: Option<Wind>,
}

impl Drag {
    /// Makes drag of a fluid at rest from [`Drag::linear`], 1/s, and [`Drag::quadratic`], 1/m.
    #[must_use]
    pub const fn new(linear: Scalar, quadratic: Scalar) -> Self {
        Self { linear, quadratic, wind: None }
    }

    /// `c + k |u|`, 1/s, at the velocity `u` relative to the fluid, m/s.
    #[inline(always)]
    pub(crate) fn rate<T: Real>(&self, u: T::Vector) -> T {
        T::of(self.linear) + T::of(self.quadratic) * u.dot(u).sqrt()
    }

    /// The acceleration at the velocity `u` relative to the fluid, m/s².
    #[inline(always)]
    fn resistance<T: Real>(&self, u: T::Vector) -> T::Vector {
        -(u * self.rate(u))
    }

    /// Velocity relative to the fluid, m/s.
    pub(crate) fn against<T: Real>(&self, time: T, body: BodyState<T>) -> T::Vector {
        match &self.wind {
            Some(wind) => body.velocity - wind.at(time, body.position),
            None => body.velocity,
        }
    }
}

impl WorldLaw for Drag {
    fn is_finite(&self) -> bool {
        let wind = self.wind.unwrap_or_default();
        let numbers = [self.linear, self.quadratic, wind.gust, wind.gust_hz];
        wind.velocity.is_finite() && numbers.iter().all(|number| number.is_finite())
    }
}

impl<T: Real> Law<T> for Drag {
    fn name(&self) -> &'static str {
        "drag"
    }

    fn text(&self) -> String {
        let mut text = format!("drag {} 1/s, {} 1/m", self.linear, self.quadratic);
        if let Some(wind @ Wind { velocity: v, gust, gust_hz }) = &self.wind {
            text += &format!("; wind ({}, {}, {}) m/s", v.x, v.y, v.z);
            if !wind.is_steady() {
                text += &format!(", gusts {gust} m/s at {gust_hz} Hz");
            }
        }
        text
    }

    fn acceleration(&self, at: EvaluationTime<T>, body: BodyState<T>) -> T::Vector {
        self.resistance::<T>(self.against(at.time, body))
    }

    fn accelerate(&self, at: EvaluationTime<T>, bodies: &BodyBlock<'_, T>, sum: &mut Axes<T>) {
        match &self.wind {
            Some(wind) => {
                let air = wind.air::<T>(at.time);
                bodies.add_each(
                    sum,
                    #[inline(always)]
                    |body| self.resistance::<T>(body.velocity - air.at(body.position)),
                );
            }
            None => bodies.add_each(
                sum,
                #[inline(always)]
                |body| self.resistance::<T>(body.velocity),
            ),
        }
    }

    fn jacobians(&self, at: EvaluationTime<T>, body: BodyState<T>) -> Jacobians<T> {
        let u = self.against(at.time, body);
        let speed = u.dot(u).sqrt();
        // The limit of u u^T / |u| at rest is 0.
        let along = T::of(self.quadratic) / if speed > T::ZERO { speed } else { T::ONE };
        let velocity = T::Matrix::ZERO - T::Matrix::IDENTITY * self.rate(u) - T::Matrix::outer(u, u) * along;
        let position = match &self.wind {
            Some(wind) if !wind.is_steady() => {
                let (change, along) = wind.air(at.time).gradient(body.position);
                T::Matrix::outer(velocity.times(-change), along)
            }
            _ => T::Matrix::ZERO,
        };
        Jacobians { position, velocity }
    }

    fn depends_on_velocity(&self) -> bool {
        true
    }

    fn affine(&self) -> Option<Affine<T>> {
        let steady = self.wind.is_none_or(|wind| wind.is_steady());
        let wind = self.wind.map_or(Vector::ZERO, |wind| wind.velocity);
        let constant = T::Vector::of(wind * self.linear);
        (self.quadratic == 0.0 && steady).then(|| Affine { constant, rate: T::of(self.linear) })
    }
}
