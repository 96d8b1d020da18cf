//! Drag of single bodies.

use super::{BodyState, Drag, EvaluationTime, Jacobians, Law};
use crate::units::{Scalar, Vector, at_least_0};

/// Drag of one body in a fluid at rest: `F = -b v - q |v| v`. It slows the lighter of two bodies of the same shape more. It
/// adds to the [`Drag`] of all bodies, which is per mass, and is counted and switched with it.
///
/// A body of drag coefficient C_d and cross-section A has `q = ρ C_d A / 2` in a fluid of density ρ (Rayleigh 1876); the
/// terminal speed of a fall is then `sqrt(m g / q)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyDrag {
    linear: Scalar,
    quadratic: Scalar,
}

impl BodyDrag {
    /// Density of air at sea level and 15 °C, kg/m³ (ISO 2533:1975).
    pub const AIR_KG_M3: Scalar = 1.225;

    /// Makes drag of the coefficients b, kg/s, and q, kg/m, both at least 0.
    ///
    /// # Panics
    /// If one of them is below 0 or not finite.
    #[must_use]
    pub fn new(linear: Scalar, quadratic: Scalar) -> Self {
        at_least_0(linear, "the linear coefficient of drag", "kg/s");
        at_least_0(quadratic, "the quadratic coefficient of drag", "kg/m");
        Self { linear, quadratic }
    }

    /// The coefficient q, kg/m, of a drag area `C_d A`, m², in air.
    #[must_use]
    pub const fn of_area(area: Scalar) -> Scalar {
        0.5 * Self::AIR_KG_M3 * area
    }

    /// The drag per mass of a body of that inverse mass, 1/kg.
    fn per_mass(self, inverse_mass: Scalar) -> Drag {
        Drag::new(self.linear * inverse_mass, self.quadratic * inverse_mass)
    }
}

impl Law for BodyDrag {
    fn name(&self) -> &'static str {
        "drag"
    }

    fn text(&self) -> String {
        format!("drag {} kg/s, {} kg/m", self.linear, self.quadratic)
    }

    fn acceleration(&self, at: EvaluationTime, body: BodyState) -> Vector {
        self.per_mass(body.inverse_mass).acceleration(at, body)
    }

    fn jacobians(&self, at: EvaluationTime, body: BodyState) -> Jacobians {
        self.per_mass(body.inverse_mass).jacobians(at, body)
    }

    fn depends_on_velocity(&self) -> bool {
        true
    }
}
