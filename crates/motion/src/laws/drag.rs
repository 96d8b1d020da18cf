//! Linear and quadratic drag.

use bevy_ecs::prelude::*;
use glam::DMat3;

use super::{
    Affine, Axes, BodyBlock, BodyState, DeviceForm, EvaluationTime, Jacobians, Law, Wind, WorldLaw,
};
use crate::units::{Scalar, Vector, at_least_0, outer};

/// Drag of a fluid: `a = -c u - k |u| u`, where u is the velocity relative to the fluid. The fluid is at rest unless
/// there is wind. The linear term is Stokes' law for slow motion, the quadratic term Newton's for fast motion; both are
/// divided by the mass.
///
/// The terminal speed under an acceleration a is the root of `c v + k v² = a`: a / c, or sqrt(a / k).
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Resource))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
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

    /// The same in a fluid that moves.
    #[must_use]
    pub const fn in_wind(self, wind: Wind) -> Self {
        Self { wind: Some(wind), ..self }
    }

    /// `c + k |u|`, 1/s, at the velocity `u` relative to the fluid, m/s.
    #[inline(always)]
    pub(crate) fn rate(&self, u: Vector) -> f64 {
        self.linear + self.quadratic * u.dot(u).sqrt()
    }

    /// The acceleration at the velocity `u` relative to the fluid, m/s².
    #[inline(always)]
    fn resistance(&self, u: Vector) -> Vector {
        -(u * self.rate(u))
    }

    /// Velocity relative to the fluid, m/s.
    pub(crate) fn against(&self, time: f64, body: BodyState) -> Vector {
        match &self.wind {
            Some(wind) => body.velocity - wind.at(time, body.position),
            None => body.velocity,
        }
    }
}

impl WorldLaw for Drag {
    fn check(&self) {
        at_least_0(self.linear, "the linear rate of drag", "1/s");
        at_least_0(self.quadratic, "the quadratic coefficient of drag", "1/m");
        if let Some(Wind { gust, gust_hz, .. }) = self.wind {
            at_least_0(gust, "the strength of gusts", "m/s");
            at_least_0(gust_hz, "the frequency of gusts", "Hz");
        }
    }

    fn is_finite(&self) -> bool {
        let wind = self.wind.unwrap_or_default();
        let numbers = [self.linear, self.quadratic, wind.gust, wind.gust_hz];
        wind.velocity.is_finite() && numbers.iter().all(|number| number.is_finite())
    }
}

impl Law for Drag {
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

    fn acceleration(&self, at: EvaluationTime, body: BodyState) -> Vector {
        self.resistance(self.against(at.time, body))
    }

    fn accelerate(&self, at: EvaluationTime, bodies: &BodyBlock<'_>, sum: &mut Axes) {
        match &self.wind {
            Some(wind) => {
                let air = wind.air(at.time);
                bodies.add_each(
                    sum,
                    #[inline(always)]
                    |body| self.resistance(body.velocity - air.at(body.position)),
                );
            }
            None => bodies.add_each(
                sum,
                #[inline(always)]
                |body| self.resistance(body.velocity),
            ),
        }
    }

    fn jacobians(&self, at: EvaluationTime, body: BodyState) -> Jacobians {
        let u = self.against(at.time, body);
        let speed = u.dot(u).sqrt();
        // The limit of u u^T / |u| at rest is 0.
        let along = self.quadratic / if speed > 0.0 { speed } else { 1.0 };
        let velocity = DMat3::ZERO - DMat3::IDENTITY * self.rate(u) - outer(u, u) * along;
        let position = match &self.wind {
            Some(wind) if !wind.is_steady() => {
                let (change, along) = wind.air(at.time).gradient(body.position);
                outer(velocity * -change, along)
            }
            _ => DMat3::ZERO,
        };
        Jacobians { position, velocity }
    }

    fn depends_on_velocity(&self) -> bool {
        true
    }

    fn affine(&self) -> Option<Affine> {
        let steady = self.wind.is_none_or(|wind| wind.is_steady());
        let wind = self.wind.map_or(Vector::ZERO, |wind| wind.velocity);
        let constant = wind * self.linear;
        (self.quadratic == 0.0 && steady).then_some(Affine { constant, rate: self.linear })
    }

    fn device_form(&self) -> Option<DeviceForm<'_>> {
        Some(self.affine().map_or(DeviceForm::Drag(self), DeviceForm::Affine))
    }
}
