//! Laws of the test problems.

use glam::DVec3;
use motion::real::{Real, RealMatrix as _};
use motion::{BodyState, EvaluationTime, Jacobians, Law};

/// A spring to the origin, `a = -k x / m`: bodies of different masses swing at different frequencies.
#[derive(Debug)]
pub struct Spring(pub f64);

impl<T: Real> Law<T> for Spring {
    fn name(&self) -> &'static str {
        "spring"
    }
    fn acceleration(&self, _: EvaluationTime<T>, body: BodyState<T>) -> T::Vector {
        body.position * (T::of(-self.0) * body.inverse_mass)
    }
    fn jacobians(&self, _: EvaluationTime<T>, body: BodyState<T>) -> Jacobians<T> {
        let stiffness = T::of(-self.0) * body.inverse_mass;
        Jacobians { position: T::Matrix::IDENTITY * stiffness, ..Jacobians::zero() }
    }
    fn depends_on_velocity(&self) -> bool {
        false
    }
}

/// `a = -w² x - 2 damping w v`.
#[derive(Debug)]
pub struct Damped {
    pub w: f64,
    pub damping: f64,
}

impl Law<f64> for Damped {
    fn name(&self) -> &'static str {
        "damped"
    }
    fn acceleration(&self, _: EvaluationTime<f64>, body: BodyState<f64>) -> DVec3 {
        body.position * (-self.w * self.w) - body.velocity * (2.0 * self.damping * self.w)
    }
    fn jacobians(&self, _: EvaluationTime<f64>, _: BodyState<f64>) -> Jacobians<f64> {
        Jacobians {
            position: glam::DMat3::IDENTITY * (-self.w * self.w),
            velocity: glam::DMat3::IDENTITY * (-2.0 * self.damping * self.w),
        }
    }
    fn depends_on_velocity(&self) -> bool {
        true
    }
}

/// The hardening spring of Duffing, `a = -x - 2 |x|² x`.
#[derive(Debug)]
pub struct Duffing;

impl Law<f64> for Duffing {
    fn name(&self) -> &'static str {
        "duffing"
    }
    fn acceleration(&self, _: EvaluationTime<f64>, body: BodyState<f64>) -> DVec3 {
        let x = body.position;
        -(x * (1.0 + 2.0 * x.length_squared()))
    }
    fn jacobians(&self, _: EvaluationTime<f64>, body: BodyState<f64>) -> Jacobians<f64> {
        let x = body.position;
        let diagonal = glam::DMat3::IDENTITY * (1.0 + 2.0 * x.length_squared());
        Jacobians {
            position: -(diagonal + <glam::DMat3 as motion::real::RealMatrix<f64>>::outer(x, x) * 4.0),
            ..Jacobians::zero()
        }
    }
    fn depends_on_velocity(&self) -> bool {
        false
    }
}
