//! Orbits about a point: how near they come, and up to which w h a method keeps them.
//!
//! A circular orbit is not a spring. A method that conserves angular momentum has circles of its own. The matrix of one step
//! about such a circle, in the frame that rotates with the body, gives the rate at which the method leaves it. Every method,
//! also one below that limit, changes a circle in the long run: it lasts if it stays within half and twice its radius.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Mutex;

use glam::{DMat3, DVec3};

use super::Fate;
use super::flight::{Point, Subject};
use super::matrix::Matrix;
use super::modes::Stepping;
use crate::laws::{BodyState, Law, Well, Wells};
use crate::methods::table::Method;

/// Turns after which a circle counts as lasting.
pub const LASTING_TURNS: f64 = 100.0;

/// Largest change of the radius of an orbit that lasts, as a factor; for several bodies also of their energy.
pub(super) const KEEPS_WITHIN: f64 = 2.0;

/// Below this w h no step counts as short enough.
const SMALLEST: f64 = 5e-3;

/// Up to this w h every method that keeps circles at all does so.
const SHORT: f64 = 0.1;

/// Softening over radius below which a well is a point.
const LEAST_SOFTNESS: f64 = 0.01;

/// No method keeps circles above this w h.
const LARGEST: f64 = 4.0;

/// Growth per step about a circle that counts as such: a circle has a defective double eigenvalue 1, which rounding and
/// differences move.
const GROWS: f64 = 1e-3;

/// The values of w h of a circle of radius r about a well up to which a method keeps it, w² = mu / (r² + s²)^(3/2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CircleLimits {
    /// The value from which on the circle grows in every step; `None` for a method that has no circles.
    pub grows: Option<f64>,
    /// The value up to which a circle lasts for [`LASTING_TURNS`]; 0 if no circle does.
    pub lasts: f64,
}

impl CircleLimits {
    /// The limits of `method` where the softening s is `softness` times the radius.
    pub fn of(method: Method, softness: f64) -> Self {
        static KNOWN: Mutex<BTreeMap<(Method, u32), CircleLimits>> = Mutex::new(BTreeMap::new());
        // Cached in steps of 5 % of softness: finding limits takes as long as thousands of ticks.
        let number = if softness > LEAST_SOFTNESS {
            (libm::log(softness / LEAST_SOFTNESS) * 20.0).ceil()
        } else {
            0.0
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small count"
        )]
        let number = number.min(1e4) as u32;
        if let Ok(known) = KNOWN.lock()
            && let Some(limits) = known.get(&(method, number))
        {
            return *limits;
        }
        let softness =
            if number == 0 { 0.0 } else { LEAST_SOFTNESS * libm::exp(f64::from(number) / 20.0) };
        let limits =
            Self { grows: grows_from(method, softness), lasts: lasts_to(method, softness) };
        if let Ok(mut known) = KNOWN.lock() {
            known.insert((method, number), limits);
        }
        limits
    }
}

impl CircleLimits {
    /// The fate of a circle by these limits alone. It holds if the method keeps no circle at any step: the limits then tell
    /// nothing.
    pub fn fate(self, value: f64) -> Fate {
        match self.grows {
            Some(grows) if value >= grows => Fate::Grows,
            _ if self.lasts > 0.0 && value > self.lasts => Fate::Drifts(LASTING_TURNS),
            _ => Fate::Holds,
        }
    }
}

/// A well in which a circle of radius 1 takes 2 pi seconds.
fn unit_well(softness: f64) -> Wells {
    let squared = 1.0 + softness * softness;
    let strength = squared * squared.sqrt();
    Wells(vec![Well { position: DVec3::ZERO, strength, softening: softness }])
}

fn on_circle<'a>(laws: &'a [&'a dyn Law], velocity: DVec3) -> Subject<'a> {
    let start = BodyState { position: DVec3::X, velocity, inverse_mass: 1.0 };
    Subject { laws, damping: None, locks: None, speed_limit: None, start, time: 0.0 }
}

fn steps_of(method: Method, h: f64) -> Stepping {
    Stepping { method, tick: h, substeps: 1, may_be_implicit: true }
}

/// The w h from which on circles grow: the smallest at which the matrix of a step has an eigenvalue above 1.
fn grows_from(method: Method, softness: f64) -> Option<f64> {
    if !method.claims().symplectic {
        return None;
    }
    let wells = unit_well(softness);
    let laws = [&wells as &dyn Law];
    let grows = |h: f64| {
        growth_about_circle(&laws, steps_of(method, h)).is_none_or(|growth| growth > 1.0 + GROWS)
    };
    Some(first(&grows, 0.05, 1.02))
}

/// The w h up to which a circle that begins as the true one lasts.
fn lasts_to(method: Method, softness: f64) -> f64 {
    let wells = unit_well(softness);
    let laws = [&wells as &dyn Law];
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of steps"
    )]
    let leaves = |h: f64| {
        let ticks = (LASTING_TURNS * TAU / h).ceil() as u32;
        leaves(&on_circle(&laws, DVec3::Y), DVec3::ZERO, [1.0; 2], steps_of(method, h), ticks)
            .is_some()
    };
    // Small factors, because resonances are narrow. A point is searched once, a softened well for each softness.
    let by = if softness == 0.0 { 1.005 } else { 1.02 };
    if leaves(SMALLEST) { 0.0 } else { first(&leaves, SHORT, by) }
}

/// The smallest value for which `fails` holds, from `start` on, found in steps of a factor and halved.
fn first(fails: &dyn Fn(f64) -> bool, start: f64, by: f64) -> f64 {
    let mut low = start;
    while low < LARGEST && !fails(low * by) {
        low *= by;
    }
    let mut high = low * by;
    for _ in 0..12 {
        let middle = low.midpoint(high);
        if fails(middle) { high = middle } else { low = middle }
    }
    low
}

/// Growth per step of small deviations from the method's own circle of radius 1, after many steps, in the frame that rotates
/// with the body; `None` if the method has no such circle.
fn growth_about_circle(laws: &[&dyn Law], stepping: Stepping) -> Option<f64> {
    // A state of the plane: x, y and the velocity.
    type Plane = [f64; 4];
    let step = |[x, y, u, v]: Plane| -> Plane {
        let [p, q] = on_circle(laws, DVec3::Y)
            .step_within(stepping, [DVec3::new(x, y, 0.0), DVec3::new(u, v, 0.0)]);
        [p.x, p.y, q.x, q.y]
    };
    let turned_back = |[x, y, u, v]: Plane, angle: f64| -> Plane {
        let (sin, cos) = libm::sincos(angle);
        [cos * x + sin * y, cos * y - sin * x, cos * u + sin * v, cos * v - sin * u]
    };
    // Unknown: the velocity and the angle of a step. Newton's method on the four equations "a step is a turn", of which one
    // follows from the others by the conservation of angular momentum.
    let residual = |[u, v, angle]: [f64; 3]| -> Plane {
        let from = [1.0, 0.0, u, v];
        let to = turned_back(step(from), angle);
        std::array::from_fn(|i| to[i] - from[i])
    };
    let mut guess = [0.0, 1.0, stepping.tick];
    let mut off = residual(guess);
    for _ in 0..60 {
        const DELTA: f64 = 1e-6;
        let columns: [Plane; 3] = std::array::from_fn(|i| {
            let moved = |by: f64| {
                let mut to = guess;
                to[i] += by;
                residual(to)
            };
            let (more, less) = (moved(DELTA), moved(-DELTA));
            std::array::from_fn(|row| (more[row] - less[row]) / (2.0 * DELTA))
        });
        let dot = |a: &Plane, b: &Plane| (0..4).map(|i| a[i] * b[i]).sum::<f64>();
        let normal = DMat3::from_cols_array_2d(&columns.map(|a| columns.map(|b| dot(&a, &b))));
        let change = normal.inverse() * DVec3::from_array(columns.map(|a| dot(&a, &off)));
        if !change.is_finite() {
            return None;
        }
        (0..3).for_each(|i| guess[i] -= change[i]);
        off = residual(guess);
        if change.length() < 1e-12 {
            break;
        }
    }
    if !off.iter().all(|off| off.abs() < 1e-9) {
        return None;
    }
    let [u, v, angle] = guess;
    let mut matrix = Matrix::zero(4);
    for column in 0..4 {
        const DELTA: f64 = 1e-6;
        let moved = |by: f64| {
            let mut from = [1.0, 0.0, u, v];
            from[column] += by;
            turned_back(step(from), angle)
        };
        let (more, less) = (moved(DELTA), moved(-DELTA));
        (0..4).for_each(|row| matrix.set(row, column, (more[row] - less[row]) / (2.0 * DELTA)));
    }
    Some(matrix.radius())
}

/// The tick after which a motion is nearer to `center` than half the first distance or farther than twice the second, if it
/// comes to that within `ticks`.
pub(super) fn leaves(
    subject: &Subject<'_>,
    center: DVec3,
    [nearest, farthest]: [f64; 2],
    stepping: Stepping,
    ticks: u32,
) -> Option<u32> {
    let mut left = None;
    let mut seen = 0;
    let is_finite = subject.fly(stepping, ticks, &mut |tick, [x, _]: Point| {
        seen = tick;
        let r = x.distance(center);
        if r * KEEPS_WITHIN < nearest || r > KEEPS_WITHIN * farthest {
            left = Some(tick);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    });
    left.or((!is_finite).then_some(seen + 1))
}

/// The turning points of a motion in a well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Apsides {
    /// Shortest distance to come, m.
    pub nearest: f64,
    /// Longest distance, m; infinite for a motion that is not bound.
    pub farthest: f64,
}

impl Well {
    /// The turning points of a motion in this well alone, from energy and angular momentum.
    pub(super) fn apsides(&self, body: BodyState) -> Apsides {
        let (x, v) = (body.position - self.position, body.velocity);
        let r = x.length();
        let potential = |r: f64| -self.strength / (r * r + self.softening * self.softening).sqrt();
        let energy = 0.5 * v.length_squared() + potential(r);
        let momentum = x.cross(v).length_squared();
        // The square of the speed toward or away from the well.
        let radial = |r: f64| 2.0 * (energy - potential(r)) * r * r - momentum;
        let turn = |mut inside: f64, mut outside: f64| {
            for _ in 0..80 {
                let middle = inside.midpoint(outside);
                if radial(middle) >= 0.0 { inside = middle } else { outside = middle }
            }
            inside
        };
        let is_bound = energy < 0.0;
        let most = if is_bound { self.strength / -energy } else { f64::INFINITY };
        let leaves = !is_bound && x.dot(v) >= 0.0;
        if self.softening == 0.0 && is_bound && self.strength > 0.0 {
            // Kepler: a (1 - e) and a (1 + e), the first without cancellation.
            let a = 0.5 * most;
            let e = (1.0 - momentum / (self.strength * a)).max(0.0).sqrt();
            let nearest = (momentum / (self.strength * (1.0 + e))).min(r);
            return Apsides {
                nearest: if nearest < 1e-9 * r { 0.0 } else { nearest },
                farthest: (a * (1.0 + e)).max(r),
            };
        }
        let inner = if leaves { r } else { turn(r, 0.0).min(r) };
        Apsides {
            // A body without angular momentum, except for rounding, falls into the well.
            nearest: if inner < 1e-9 * r { 0.0 } else { inner },
            farthest: if is_bound { turn(r, most.max(r)).max(r) } else { f64::INFINITY },
        }
    }

    /// Time of a revolution between these turning points, s.
    pub(super) fn turn_s(&self, Apsides { nearest, farthest }: Apsides) -> f64 {
        let half = nearest.midpoint(farthest);
        let squared = half * half + self.softening * self.softening;
        TAU * (squared * squared.sqrt() / self.strength).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The limits by an independent program (Python, NumPy): the 4x4 matrix of a step about the discrete circle, and loops.
    #[test]
    fn circles_grow_and_last_up_to_known_limits() {
        for (method, grows, lasts) in [
            (Method::SemiImplicitEuler, Some(2.0_f64.sqrt()), 0.79),
            (Method::PositionVerlet, Some(2.0_f64.sqrt()), 1.07),
            (Method::VelocityVerlet, Some(2.0_f64.sqrt()), 1.07),
            (Method::Yoshida4, Some(1.26), 1.12),
            (Method::RungeKutta4, None, 0.36),
            (Method::RungeKutta2Heun, None, 0.22),
            (Method::ExplicitEuler, None, 0.0),
            (Method::ImplicitEuler, None, 0.0),
        ] {
            let limits = CircleLimits::of(method, 0.0);
            assert_eq!(limits.grows.is_some(), grows.is_some(), "{method:?} {limits:?}");
            let near = |found: f64, known: f64| (found - known).abs() <= 0.012;
            assert!(
                limits.grows.zip(grows).is_none_or(|(a, b)| near(a, b)),
                "{method:?} {limits:?}"
            );
            assert!(near(limits.lasts, lasts), "{method:?} {limits:?}");
        }
    }

    #[test]
    fn an_ellipse_turns_at_its_apsides() {
        let well = Well { position: DVec3::new(1.0, 2.0, 0.0), strength: 3.0, softening: 0.0 };
        let (a, e) = (2.0_f64, 0.6);
        let [near, far] = [a * (1.0 - e), a * (1.0 + e)];
        let speed = (3.0 * (2.0 / far - 1.0 / a)).sqrt();
        let at = |r: f64, v: DVec3| BodyState {
            position: well.position + DVec3::X * r,
            velocity: v,
            inverse_mass: 1.0,
        };
        let reach = well.apsides(at(far, DVec3::Y * speed));
        assert!(
            (reach.nearest / near - 1.0).abs() < 1e-9 && (reach.farthest / far - 1.0).abs() < 1e-9,
            "{reach:?}"
        );
        assert!((well.turn_s(reach) / (TAU * (a * a * a / 3.0).sqrt()) - 1.0).abs() < 1e-9);
        // Outbound and free: it comes no nearer.
        let free = well.apsides(at(near, DVec3::X * 10.0));
        assert_eq!((free.nearest, free.farthest), (near, f64::INFINITY));
    }
}
