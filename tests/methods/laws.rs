//! Laws of the test problems.

use glam::{DMat3, DVec3};
use motion::units::outer;
use motion::{BodyState, EvaluationTime, Jacobians, Law};

use crate::rigs::Formula;

/// A spring to the origin, `a = -k x / m`: bodies of different masses swing at different frequencies.
#[derive(Debug)]
pub struct Spring(pub f64);

impl Law for Spring {
    fn name(&self) -> &'static str {
        "spring"
    }
    fn acceleration(&self, _: EvaluationTime, body: BodyState) -> DVec3 {
        body.position * (-self.0 * body.inverse_mass)
    }
    fn jacobians(&self, _: EvaluationTime, body: BodyState) -> Jacobians {
        let stiffness = -self.0 * body.inverse_mass;
        Jacobians { position: DMat3::IDENTITY * stiffness, ..Jacobians::zero() }
    }
    fn depends_on_velocity(&self) -> bool {
        false
    }
}

/// `a = -w² x - 2 damping w v`.
pub fn damped(w: f64, damping: f64) -> Formula {
    let (of_position, of_velocity) = (-w * w, -2.0 * damping * w);
    let acceleration =
        move |_, body: BodyState| body.position * of_position + body.velocity * of_velocity;
    let jacobians = move |_: BodyState| Jacobians {
        position: DMat3::IDENTITY * of_position,
        velocity: DMat3::IDENTITY * of_velocity,
    };
    Formula::new("damped", acceleration).with_jacobians(jacobians).of_velocity(true)
}

/// The hardening spring of Duffing, `a = -x - 2 |x|² x`.
pub fn duffing() -> Formula {
    let stiffness = |x: DVec3| 1.0 + 2.0 * x.length_squared();
    let acceleration = move |_, body: BodyState| -(body.position * stiffness(body.position));
    let jacobians = move |body: BodyState| {
        let x = body.position;
        let position = -(DMat3::IDENTITY * stiffness(x) + outer(x, x) * 4.0);
        Jacobians { position, ..Jacobians::zero() }
    };
    Formula::new("duffing", acceleration).with_jacobians(jacobians)
}
