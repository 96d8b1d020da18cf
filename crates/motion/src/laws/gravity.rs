//! Uniform gravity.

use bevy_ecs::prelude::*;

use super::{Affine, BodyState, EvaluationTime, Jacobians, Law};
use crate::units::Vector;

/// Uniform gravity: the same acceleration for every movable body, whatever its mass (Galilei). Present only if the
/// scene declares it.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Resource))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Gravity {
    /// Acceleration of free fall, m/s².
    pub acceleration: Vector,
    /// Whether gravity acts. The acceleration keeps its value while it does not.
    pub on: bool,
}

#[cfg(feature = "serde")]
crate::names::written_as_tuple!(Gravity { acceleration, on });

impl Gravity {
    /// Gravity near the ground, as in the tutorial: 9.8 m/s² downward.
    pub const EARTH: Self = Self { acceleration: Vector::new(0.0, -9.8, 0.0), on: true };

    /// Gravity of that acceleration, m/s², which acts.
    #[must_use]
    pub const fn new(acceleration: Vector) -> Self {
        Self { acceleration, on: true }
    }

    /// The acceleration, m/s², or `None` while gravity is off.
    #[must_use]
    pub fn active_acceleration(&self) -> Option<Vector> {
        self.on.then_some(self.acceleration)
    }
}

impl Law for Gravity {
    fn name(&self) -> &'static str {
        "gravity"
    }

    fn text(&self) -> String {
        let Self { acceleration: g, on } = self;
        format!("gravity ({}, {}, {}) m/s², {}", g.x, g.y, g.z, if *on { "on" } else { "off" })
    }

    fn acceleration(&self, _: EvaluationTime, _: BodyState) -> Vector {
        self.active_acceleration().unwrap_or(Vector::ZERO)
    }

    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians::zero()
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }

    fn affine(&self) -> Option<Affine> {
        let constant = self.active_acceleration().unwrap_or(Vector::ZERO);
        Some(Affine { constant, rate: 0.0 })
    }

    fn has_potential(&self) -> bool {
        true
    }

    /// `-m g x`: zero at the origin.
    fn potential_energy(&self, body: BodyState) -> f64 {
        let g = self.active_acceleration().unwrap_or(Vector::ZERO);
        -(g.dot(body.position) / body.inverse_mass)
    }
}
