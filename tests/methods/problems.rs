//! Problems of which the solution is known.

use glam::DVec3;
use motion::{BodyState, Drag, Gravity, Law, Well, Wells};

use super::laws::{self, Spring};
use super::{SKEW, Stepper};
use crate::rigs::Bare;
use crate::rigs::{Formula, engine, pull};

/// A unit vector across [`SKEW`].
pub const ACROSS: DVec3 = DVec3::new(0.64, 0.0, -0.48);

/// Position and velocity.
pub type State = (DVec3, DVec3);

/// One body from t = 0 to `span`, s.
pub struct Problem {
    pub name: &'static str,
    pub span: f64,
    pub inverse_mass: f64,
    pub laws: Box<dyn Fn(Bare) -> Bare>,
    pub exact: Box<dyn Fn(f64) -> State>,
    /// Whether a law depends on the velocity.
    pub velocity_laws: bool,
    /// The degree of the acceleration where it is a polynomial of time: methods of a high enough order have
    /// no error then.
    pub degree: Option<u32>,
    /// Parts of the span at whose ends the solution is known.
    pub samples: u32,
}

impl Problem {
    pub fn new(
        name: &'static str,
        span: f64,
        laws: impl Fn(Bare) -> Bare + 'static,
        exact: impl Fn(f64) -> State + 'static,
    ) -> Self {
        Self {
            name,
            span,
            inverse_mass: 0.5,
            laws: Box::new(laws),
            exact: Box::new(exact),
            velocity_laws: false,
            degree: None,
            samples: 8,
        }
    }

    fn with_velocity_laws(self) -> Self {
        Self { velocity_laws: true, ..self }
    }

    fn of_degree(self, degree: u32) -> Self {
        Self { degree: Some(degree), ..self }
    }

    /// The body at its start, with a tick of `step` seconds.
    pub fn bare(&self, stepper: &Stepper, step: f64) -> Bare {
        let mut bare = (self.laws)(stepper.bare(step));
        let (x, v) = (self.exact)(0.0);
        bare.add(x.to_array(), v.to_array(), self.inverse_mass);
        bare
    }
}

fn parabola(x: DVec3, v: DVec3, a: DVec3) -> impl Fn(f64) -> State {
    move |t| (x + (v + a * (t / 2.0)) * t, v + a * t)
}

/// S1.
pub fn free_fall() -> Problem {
    let (x, v) = (DVec3::new(1.0, 20.0, -3.0), DVec3::new(2.0, 1.0, 0.5));
    Problem::new(
        "free fall",
        2.0,
        |bare| bare.with_law(Gravity::EARTH),
        parabola(x, v, Gravity::EARTH.acceleration),
    )
    .of_degree(0)
}

/// S2: gravity and two engines, the second across.
pub fn two_engines() -> Problem {
    let (main, side) = (DVec3::new(0.0, 24.0, 0.0), DVec3::new(3.0, 0.0, -1.5));
    let a = Gravity::EARTH.acceleration + (main + side) * 0.5;
    Problem::new(
        "two engines",
        2.0,
        move |bare| bare.with_law(Gravity::EARTH).with_law(engine([main])).with_law(engine([side])),
        parabola(DVec3::new(-4.0, 0.0, 1.0), DVec3::new(3.0, 1.0, 7.0), a),
    )
    .of_degree(0)
}

/// S3.
pub fn linear_drag() -> Problem {
    let (g, c, v0) = (DVec3::new(0.5, -9.8, 0.0), 0.4, DVec3::new(3.0, 8.0, -2.0));
    let terminal = g / c;
    Problem::new(
        "linear drag",
        4.0,
        move |bare| bare.with_law(pull(g)).with_law(Drag::new(c, 0.0)),
        move |t| {
            let gone = -(-c * t).exp_m1();
            (terminal * t + (v0 - terminal) * (gone / c), v0 - (v0 - terminal) * gone)
        },
    )
    .with_velocity_laws()
}

/// S4, straight down from rest.
pub fn quadratic_drag() -> Problem {
    let (g, k) = (9.8_f64, 0.05_f64);
    let (terminal, tau) = ((g / k).sqrt(), 1.0 / (g * k).sqrt());
    Problem::new(
        "quadratic drag",
        2.0,
        move |bare| bare.with_law(pull(SKEW * -g)).with_law(Drag::new(0.0, k)),
        move |t| {
            (
                SKEW * (-terminal * tau * (t / tau).cosh().ln()),
                SKEW * (-terminal * (t / tau).tanh()),
            )
        },
    )
    .with_velocity_laws()
}

/// S4, a shot: 16 digits at its end by extrapolation.
pub fn shot() -> Problem {
    let end = (
        DVec3::new(20.229_729_081_510_68, 6.112_905_094_101_609, 0.0),
        DVec3::new(5.965_352_761_269_156, -6.843_052_130_821_089, 0.0),
    );
    let problem = Problem::new(
        "shot with quadratic drag",
        2.0,
        |bare| bare.with_law(pull(DVec3::Y * -9.81)).with_law(Drag::new(0.0, 0.05)),
        move |t| if t == 0.0 { (DVec3::ZERO, DVec3::new(20.0, 20.0, 0.0)) } else { end },
    );
    Problem { samples: 1, ..problem.with_velocity_laws() }
}

/// S5: an ellipse, w = 2.
pub fn oscillator() -> Problem {
    let (w, x, v) = (2.0_f64, SKEW, ACROSS * 0.5);
    Problem::new(
        "oscillator",
        4.0,
        move |bare| bare.with_law(Spring(2.0 * w * w)),
        move |t| {
            let (sin, cos) = (w * t).sin_cos();
            (x * cos + v * (sin / w), v * cos - x * (w * sin))
        },
    )
}

/// S6, `damping` relative to the critical one.
pub fn damped(name: &'static str, damping: f64) -> Problem {
    let (w, x, v) = (2.0_f64, SKEW, ACROSS * 0.5 - SKEW * 0.3);
    let exact = move |t: f64| {
        // x = e^(-s t) (x0 C + (v0 + s x0) S) with C, S the cosine and sine of what is left of w.
        let s = damping * w;
        let left = w * w - s * s;
        let (cos, sin, turn) = if left > 0.0 {
            let r = left.sqrt();
            ((r * t).cos(), (r * t).sin() / r, -left)
        } else if left < 0.0 {
            let r = (-left).sqrt();
            ((r * t).cosh(), (r * t).sinh() / r, -left)
        } else {
            (1.0, t, 0.0)
        };
        let (decay, b) = ((-s * t).exp(), v + x * s);
        let at = x * cos + b * sin;
        (at * decay, (x * (turn * sin) + b * cos - at * s) * decay)
    };
    Problem::new(name, 2.0, move |bare| bare.with_law(laws::damped(w, damping)), exact)
        .with_velocity_laws()
}

fn of_engine(name: &'static str, newtons: &[f64]) -> Problem {
    let force: Vec<DVec3> = newtons.iter().map(|c| SKEW * (2.0 * c)).collect();
    let accelerations = newtons.to_vec();
    let degree = u32::try_from(newtons.len() - 1).unwrap();
    Problem::new(
        name,
        1.0,
        move |bare| bare.with_law(engine(&force[..])),
        move |t| {
            let sum = |term: &dyn Fn(f64) -> f64| {
                accelerations.iter().enumerate().map(|(k, a)| a * term(k as f64)).sum::<f64>()
            };
            let v = sum(&|k| t.powf(k + 1.0) / (k + 1.0));
            (SKEW * sum(&|k| t.powf(k + 2.0) / ((k + 1.0) * (k + 2.0))), SKEW * v)
        },
    )
    .of_degree(degree)
}

/// S7: `a = 10 + 15 t`.
pub fn linear_thrust() -> Problem {
    of_engine("linear thrust", &[10.0, 15.0])
}

/// S8: a quadratic through the same two samples.
pub fn quadratic_thrust() -> Problem {
    of_engine("quadratic thrust", &[10.0, 12.5, 2.5])
}

/// S8: `a = 10 2.5^t`.
pub fn exponential_thrust() -> Problem {
    let rate = 2.5_f64.ln();
    Problem::new(
        "exponential thrust",
        1.0,
        |bare| {
            bare.with_law(Formula::new("of time", |at, _| SKEW * (10.0 * 2.5_f64.powf(at.time))))
        },
        move |t| {
            let grown = (rate * t).exp_m1() / rate;
            (SKEW * (10.0 * (grown - t) / rate), SKEW * (10.0 * grown))
        },
    )
}

/// The eccentric anomaly of Kepler's equation, by Newton's method.
fn eccentric_anomaly(e: f64, mean: f64) -> f64 {
    let mut anomaly = mean + e * mean.sin();
    for _ in 0..50 {
        anomaly -= (anomaly - e * anomaly.sin() - mean) / (1.0 - e * anomaly.cos());
    }
    anomaly
}

/// The state on a Kepler orbit of unit axis and unit strength, from the perihelion on.
pub fn kepler_state(e: f64, t: f64) -> State {
    let anomaly = eccentric_anomaly(e, t);
    let (sin, cos) = anomaly.sin_cos();
    let (across, rate) = ((1.0 - e * e).sqrt(), 1.0 / (1.0 - e * cos));
    (
        SKEW * (cos - e) + ACROSS_UNIT * (across * sin),
        (ACROSS_UNIT * (across * cos) - SKEW * sin) * rate,
    )
}

/// [`ACROSS`] with length 1.
const ACROSS_UNIT: DVec3 = DVec3::new(0.8, 0.0, -0.6);

/// S10.
pub fn kepler(name: &'static str, e: f64) -> Problem {
    Problem::new(name, 4.0, |bare| bare.with_law(sun()), move |t| kepler_state(e, t))
}

/// A well of unit strength at the origin.
pub fn sun() -> Wells {
    Wells(vec![Well { position: DVec3::ZERO, strength: 1.0, softening: 0.0 }])
}

/// sn, cn, dn of parameter m, by the arithmetic-geometric mean (Abramowitz, Stegun 16.4).
fn jacobi_elliptic(u: f64, m: f64) -> [f64; 3] {
    let (mut a, mut b, mut ratios) = (1.0_f64, (1.0 - m).sqrt(), vec![]);
    let mut c = m.sqrt();
    while c > f64::EPSILON {
        let (mean, root) = ((a + b) / 2.0, (a * b).sqrt());
        c = (a - b) / 2.0;
        (a, b) = (mean, root);
        ratios.push(c / a);
    }
    let mut phase = 2.0_f64.powi(i32::try_from(ratios.len()).unwrap()) * a * u;
    for ratio in ratios.iter().rev() {
        phase = (phase + (ratio * phase.sin()).asin()) / 2.0;
    }
    let (sn, cn) = phase.sin_cos();
    [sn, cn, (1.0 - m * sn * sn).sqrt()]
}

/// `x = cn(sqrt(3) t, m = 1/3)`, which is 1 and at rest at t = 0.
fn duffing_state(t: f64) -> State {
    let rate = 3.0_f64.sqrt();
    let [sn, cn, dn] = jacobi_elliptic(rate * t, 1.0 / 3.0);
    (SKEW * cn, SKEW * (-rate * sn * dn))
}

/// S11, not from rest: there the half step that semi-implicit Euler's velocity is late makes up for the half
/// step that it starts early, and it looks like order 2.
pub fn duffing() -> Problem {
    Problem::new("Duffing", 3.0, |bare| bare.with_law(laws::duffing()), |t| duffing_state(t + 0.4))
}

/// A path that is chosen, and its first two derivatives.
fn path(t: f64) -> [DVec3; 3] {
    let (sin, cos, decay) = (t.sin(), t.cos(), (-t).exp());
    let (sin2, cos2) = (2.0 * t).sin_cos();
    [
        DVec3::new(sin, cos2, decay),
        DVec3::new(cos, -2.0 * sin2, -decay),
        DVec3::new(-sin, -4.0 * cos2, decay),
    ]
}

/// S16: every local law at once, and what drives a body along [`path`] against them, `x*'' - F(x*, x*')`.
pub fn manufactured(name: &'static str, drag: Option<Drag>) -> Problem {
    let laws = move |bare: Bare| {
        let wells = Wells(vec![
            Well { position: DVec3::new(0.5, -0.3, 2.0), strength: 1.5, softening: 0.2 },
            Well { position: DVec3::new(-2.0, 0.4, 0.0), strength: -0.7, softening: 0.0 },
        ]);
        let bare = bare.with_law(Gravity::EARTH).with_law(wells.clone());
        let bare = if let Some(drag) = drag { bare.with_law(drag) } else { bare };
        bare.with_law(Formula::new("manufactured", move |at, body| {
            let [position, velocity, acceleration] = path(at.time);
            let on_path = BodyState { position, velocity, inverse_mass: body.inverse_mass };
            let drag = drag.map_or(DVec3::ZERO, |drag| drag.acceleration(at, on_path));
            acceleration
                - drag
                - wells.acceleration(at, on_path)
                - Gravity::EARTH.acceleration(at, on_path)
        }))
    };
    let exact = |t| {
        let [x, v, _] = path(t);
        (x, v)
    };
    Problem { velocity_laws: drag.is_some(), ..Problem::new(name, 2.0, laws, exact) }
}

/// Every one of them.
pub fn all() -> Vec<Problem> {
    let drag = Drag::new(0.4, 0.05);
    vec![
        free_fall(),
        two_engines(),
        linear_drag(),
        quadratic_drag(),
        shot(),
        oscillator(),
        damped("damped, 0.2", 0.2),
        damped("damped, 1", 1.0),
        damped("damped, 3", 3.0),
        linear_thrust(),
        quadratic_thrust(),
        exponential_thrust(),
        kepler("Kepler, e = 0", 0.0),
        kepler("Kepler, e = 0.6", 0.6),
        duffing(),
        manufactured("manufactured", None),
        manufactured("manufactured with drag", Some(drag)),
    ]
}

#[test]
fn the_solutions_have_the_known_digits() {
    let (x, _) = duffing_state(3.0);
    assert!((x.dot(SKEW) + 0.004_570_930_199_922_41).abs() <= 1e-15);
    let (x, v) = (linear_thrust().exact)(1.0);
    assert!((x.dot(SKEW) - 7.5).abs() <= 1e-14 && (v.dot(SKEW) - 17.5).abs() <= 1e-14);
    let (_, v) = (quadratic_thrust().exact)(1.0);
    assert!((v.dot(SKEW) - 17.0833).abs() <= 1e-4);
    let (_, v) = (exponential_thrust().exact)(1.0);
    assert!((v.dot(SKEW) - 16.3704).abs() <= 1e-4);
}

/// A misprinted solution would show as a wrong order only where a method is good enough to tell.
#[test]
fn the_velocities_are_the_derivatives_of_the_positions() {
    for problem in all().into_iter().filter(|problem| problem.samples > 1) {
        let (t, d) = (0.37 * problem.span, 1e-5);
        let ((before, _), (after, _)) = ((problem.exact)(t - d), (problem.exact)(t + d));
        let (_, v) = (problem.exact)(t);
        assert!(
            ((after - before) / (2.0 * d) - v).length() <= 1e-8 * (1.0 + v.length()),
            "{}",
            problem.name
        );
    }
}
