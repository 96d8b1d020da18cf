//! Laws of the test problems.

use glam::DVec3;
use motion::real::{Real, RealMatrix as _};
use motion::{BodyState, Drag, EvaluationTime, Gravity, Jacobians, Law, Well, Wells};

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

/// An acceleration of the time alone.
pub struct OfTime(pub fn(f64) -> DVec3);

impl std::fmt::Debug for OfTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("OfTime")
    }
}

impl Law<f64> for OfTime {
    fn name(&self) -> &'static str {
        "of time"
    }
    fn acceleration(&self, at: EvaluationTime<f64>, _: BodyState<f64>) -> DVec3 {
        (self.0)(at.time)
    }
    fn jacobians(&self, _: EvaluationTime<f64>, _: BodyState<f64>) -> Jacobians<f64> {
        Jacobians::zero()
    }
    fn depends_on_velocity(&self) -> bool {
        false
    }
}

/// What drives a body along [`Manufactured::path`] against the laws it holds: `x*'' - F(x*, x*')`.
#[derive(Debug)]
pub struct Manufactured {
    pub gravity: Gravity,
    pub wells: Wells,
    pub drag: Option<Drag>,
}

impl Manufactured {
    pub fn new(drag: Option<Drag>) -> Self {
        let wells = Wells(vec![
            Well { position: DVec3::new(0.5, -0.3, 2.0), strength: 1.5, softening: 0.2 },
            Well { position: DVec3::new(-2.0, 0.4, 0.0), strength: -0.7, softening: 0.0 },
        ]);
        Self { gravity: Gravity::EARTH, wells, drag }
    }

    /// The solution and its first two derivatives.
    pub fn path(t: f64) -> [DVec3; 3] {
        let (sin, cos, decay) = (t.sin(), t.cos(), (-t).exp());
        let (sin2, cos2) = (2.0 * t).sin_cos();
        [
            DVec3::new(sin, cos2, decay),
            DVec3::new(cos, -2.0 * sin2, -decay),
            DVec3::new(-sin, -4.0 * cos2, decay),
        ]
    }
}

impl Law<f64> for Manufactured {
    fn name(&self) -> &'static str {
        "manufactured"
    }
    fn acceleration(&self, at: EvaluationTime<f64>, body: BodyState<f64>) -> DVec3 {
        let [position, velocity, acceleration] = Self::path(at.time);
        let on_path = BodyState { position, velocity, inverse_mass: body.inverse_mass };
        let drag = self.drag.as_ref().map_or(DVec3::ZERO, |drag| drag.acceleration(at, on_path));
        acceleration - drag - self.wells.acceleration(at, on_path) - self.gravity.acceleration(at, on_path)
    }
    fn jacobians(&self, _: EvaluationTime<f64>, _: BodyState<f64>) -> Jacobians<f64> {
        Jacobians::zero()
    }
    fn depends_on_velocity(&self) -> bool {
        false
    }
}
