//! One oscillator, `x'' = -x - 2 zeta x'`, run by the real methods.

use crate::rigs::Bare;
use glam::DMat3;
use motion::units::Vector;
use motion::{BodyState, Damping, EvaluationTime, Jacobians, Law, Method};

use super::limit::{Criterion, Limit, largest_stable};
use super::theory::{Damped, oscillator_limit, radius};
use crate::rigs::{Matrix, by_columns, product};

/// An oscillator of frequency 1 and its method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillator {
    /// Its method.
    pub method: Method,
    /// How it is damped.
    pub damped: Damped,
}

/// `a = -k x - rate v`.
#[derive(Debug)]
struct Spring {
    k: f64,
    rate: f64,
}

impl Law for Spring {
    fn name(&self) -> &'static str {
        "spring"
    }

    fn acceleration(&self, _: EvaluationTime, body: BodyState) -> Vector {
        body.position * -self.k + body.velocity * -self.rate
    }

    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians { position: DMat3::IDENTITY * -self.k, velocity: DMat3::IDENTITY * -self.rate }
    }

    fn depends_on_velocity(&self) -> bool {
        self.rate != 0.0
    }
}

/// A run that exceeds this multiple of its start has failed.
const MOST: f64 = 1e3;

/// Ticks of a run: a step 0.1 % above the limit has failed by then.
const TICKS: u32 = 6_000;
/// Ticks of a run of a method of order 2 without a limit, whose growth is slowest at weak damping.
const TICKS_OF_ORDER_2: u32 = 40_000;

impl Oscillator {
    /// The oscillator with stiffness `k`, with ticks of `h` seconds.
    fn bare(&self, k: f64, h: f64) -> Bare {
        let rate = 2.0 * self.damped.ratio * k.sqrt();
        match self.damped.model {
            None => Bare::new(self.method, h).with_law(Spring { k, rate }),
            Some(model) => Bare::new(self.method, h)
                .with_law(Spring { k, rate: 0.0 })
                .with_damping(Damping { model, rate }),
        }
    }

    /// One tick of `h` seconds of an oscillator of stiffness `k`, as rows and columns of (w x, v). For position
    /// Verlet it is the second tick.
    pub fn tick(&self, k: f64, h: f64) -> Matrix {
        let w = k.sqrt();
        let run = |[x, v]: [f64; 2], ticks: u32| {
            let mut bare = self.bare(k, h);
            bare.add([x / w, 0.0, 0.0], [v, 0.0, 0.0], 1.0);
            (0..ticks).for_each(|_| bare.tick());
            [bare.positions[0][0] * w, bare.bodies[0][0]]
        };
        let after = |ticks| by_columns([run([1.0, 0.0], ticks), run([0.0, 1.0], ticks)]);
        if self.method != Method::PositionVerlet {
            return after(1);
        }
        // The first tick of position Verlet is a Taylor step: this is the map from its end to the next state.
        let [[a, b], [c, d]] = after(1);
        let scale = a * d - b * c;
        product(after(2), [[d / scale, -b / scale], [-c / scale, a / scale]])
    }

    /// Whether a run of ticks of `h` seconds stays bounded.
    fn stays(&self, h: f64) -> bool {
        let mut bare = self.bare(1.0, h);
        bare.add([1.0, 0.0, 0.0], [0.3, 0.0, 0.0], 1.0);
        let claims = self.method.claims();
        let slow = claims.stability_limit == 0.0 && claims.position_order == 2;
        (0..if slow { TICKS_OF_ORDER_2 } else { TICKS }).all(|_| {
            bare.tick();
            let (x, v) = (bare.positions[0][0], bare.bodies[0][0]);
            !bare.has_failed() && x.hypot(v) <= MOST
        })
    }

    /// Its largest stable step.
    pub fn limit(&self) -> Limit {
        // Runge-Kutta 2 at w h = 0.01 grows by 1.25e-9 per tick.
        let by_radius = |h: f64| radius(self.tick(1.0, h)) <= 1.0 + 1e-11;
        let (criterion, measured) = if self.method == Method::ExplicitEuler || !by_radius(0.01) {
            (Criterion::SpectralRadius, largest_stable(0.01, 1.02, by_radius))
        } else {
            (Criterion::Amplitude, largest_stable(0.1, 1.3, |h| self.stays(h)))
        };
        let damping = match (self.damped.ratio, self.damped.model) {
            (0.0, _) => String::new(),
            (ratio, None) => format!(", drag, zeta {ratio}"),
            (ratio, Some(model)) => format!(", {} damping, zeta {ratio}", model.name()),
        };
        Limit {
            system: format!("oscillator{damping}"),
            method: self.method.name(),
            criterion,
            measured,
            theory: oscillator_limit(self.method, self.damped),
        }
    }
}
