//! What damping, speed limits and axis locks take of a velocity: from the multipliers themselves.

use super::rows::{Body, State};
use crate::blocks::restrain;
use crate::course::Piece;
use crate::effects::{Damping, Decay, Factor};
use crate::method::Method;
use crate::real::Real;
use crate::units::{Scalar, Vector};

/// Energy, J, and momentum, N s, that a body was given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Given {
    pub energy: Scalar,
    pub momentum: Vector,
}

impl Given {
    fn add(&mut self, energy: Scalar, momentum: Vector) {
        self.energy += energy;
        self.momentum += momentum;
    }

    /// A velocity became another one.
    fn turn(&mut self, mass: Scalar, from: Vector, to: Vector) {
        let change = (to - from) * mass;
        self.add(change.dot(from + to) * 0.5, change);
    }

    /// Linear drag of `q` = c h over a step, along the exponential between both velocities that solves
    /// `v' = a - c v` with a constant a.
    fn decay(&mut self, mass: Scalar, q: Scalar, from: Vector, to: Vector) {
        let [mean, square] = exponential(q);
        let change = to - from;
        let velocity = from + change * mean;
        let squared = from.dot(from) + from.dot(change) * (2.0 * mean) + change.dot(change) * square;
        self.add(-mass * q * squared, velocity * (-mass * q));
    }
}

/// Below it, the closed forms of the integrals lose more to cancellation than the series leaves out.
const SMALL: Scalar = 0.1;

/// Integrals over s from 0 to 1 of f and f², `f = (1 - e^(-q s)) / (1 - e^-q)`: how an exponential goes from one
/// velocity to another.
fn exponential(q: Scalar) -> [Scalar; 2] {
    if q < SMALL {
        let square = q * q;
        let odd = 1.0 / 12.0 - square * (1.0 / 720.0 - square / 30_240.0);
        let even = 1.0 / 3.0 + square * (1.0 / 180.0 - square * (1.0 / 5_040.0 - square / 151_200.0));
        return [0.5 + q * odd, even + q * odd];
    }
    let whole = -Real::exp_m1(-q);
    let mean = 1.0 / whole - 1.0 / q;
    let of_square = (1.0 - 2.0 * whole / q - Real::exp_m1(-2.0 * q) / (2.0 * q)) / (whole * whole);
    [mean, of_square]
}

/// What a tick took of one body, and the velocities between which the laws had it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taken {
    pub damping: Given,
    pub limits: Given,
    /// Velocities after what stands before the tick and before what stands after it, m/s.
    pub between: [Vector; 2],
    /// Rate of linear drag that damping is in the tick, 1/s.
    pub rate: Scalar,
}

/// Where damping stands in a tick.
pub(super) struct Damper<'a> {
    pub body: &'a Body<'a>,
    pub method: Method,
    /// With the body's own rate.
    pub damping: Option<Damping>,
    /// Length of the tick, s.
    pub tick: Scalar,
    /// Acceleration by everything at the start of the tick, m/s²: what tells how fast a body would be without its
    /// limit.
    pub acceleration: Vector,
}

impl Damper<'_> {
    /// What it takes in a tick of these pieces.
    pub fn taken(&self, pieces: impl Iterator<Item = Piece<Scalar>> + Clone) -> Taken {
        match self.method {
            Method::ExplicitEuler | Method::SemiImplicitEuler => self.inside(pieces),
            _ => self.around(),
        }
    }

    fn nothing(&self) -> Taken {
        let between = self.body.ends.map(|end| end.velocity);
        Taken { damping: Given::default(), limits: Given::default(), between, rate: 0.0 }
    }

    fn asks(&self) -> bool {
        self.damping.is_some() || self.body.limit.is_some() || self.body.locks.is_some()
    }

    fn restrained(&self, v: Vector) -> Vector {
        let mut row = [v.x, v.y, v.z, 0.0];
        restrain(&mut row, self.body.limit, self.body.locks);
        Vector::new(row[0], row[1], row[2])
    }

    /// Whether a velocity is at the limit, up to rounding.
    fn is_limited(&self, v: Vector) -> bool {
        self.body.limit.is_some_and(|limit| v.length() >= limit * (1.0 - 1e-12))
    }

    /// The Eulers, whose steps have it inside.
    fn inside(&self, pieces: impl Iterator<Item = Piece<Scalar>> + Clone) -> Taken {
        let mut taken = self.nothing();
        if !self.asks() {
            return taken;
        }
        let [start, end] = self.body.ends.map(|end| end.velocity);
        let steps = pieces.clone().count();
        let bulge = self.bulge(steps);
        let (mut after, mut from) = (0.0, start);
        for (step, piece) in pieces.enumerate() {
            after += piece.length / self.tick;
            let to = if step + 1 == steps {
                end
            } else {
                start + (end - start) * after + bulge * (4.0 * after * (1.0 - after))
            };
            let none = Decay::none(piece.length);
            let decay = self.damping.map_or(none, |damping| damping.factors(piece.length));
            match self.method {
                Method::ExplicitEuler => self.moves_first(&mut taken, &decay, piece.length, [from, to]),
                _ => self.kicks_first(&mut taken, &decay, piece.length, [from, to]),
            }
            from = to;
        }
        taken
    }

    /// Velocities between two steps of a tick are not seen: they are those of the parabola through both ends that
    /// moves the body, a step at a time, to where it has come to. This is by how much it rises above the straight line
    /// in the middle.
    #[expect(clippy::cast_precision_loss, reason = "a number of steps")]
    fn bulge(&self, steps: usize) -> Vector {
        let [start, end] = self.body.ends;
        let n = steps as Scalar;
        let factors = self.damping.map(|damping| damping.factors(self.tick / n));
        // What a body moves by is the velocity at the start of a step after the one factor, or that at the end before
        // the other.
        let (ahead, factor) = match self.method {
            Method::ExplicitEuler => (
                n - 1.0,
                factors.and_then(|decay| decay.before_move).map_or(1.0, |factor| 1.0 / factor.whole),
            ),
            _ => (n + 1.0, factors.and_then(|decay| decay.after_move).map_or(1.0, |factor| factor.whole)),
        };
        if steps < 2 || factor.abs() > 1.0 / LEAST {
            return Vector::ZERO;
        }
        let moved = (end.position - start.position) * (factor * n / self.tick);
        let straight = start.velocity * n + (end.velocity - start.velocity) * (ahead / 2.0);
        (moved - straight) * (1.5 * n / (n * n - 1.0))
    }

    /// Rate of the exact model times the length of a step.
    fn q(&self, decay: &Decay<Scalar>, length: Scalar) -> Option<Scalar> {
        decay.keep.and(self.damping).map(|damping| damping.rate * length)
    }

    /// A step of explicit Euler: all multipliers stand before the kick.
    fn moves_first(&self, taken: &mut Taken, decay: &Decay<Scalar>, length: Scalar, [from, to]: [Vector; 2]) {
        let mass = self.body.mass();
        let damped = decay.before_move.map_or(from, |factor| from * factor.whole);
        let moving = self.restrained(damped);
        let kept = decay.after_move.map_or(moving, |factor| moving * factor.whole);
        taken.damping.turn(mass, from, damped);
        taken.limits.turn(mass, damped, moving);
        taken.damping.turn(mass, moving, kept);
        if let Some(q) = self.q(decay, length) {
            taken.damping.decay(mass, q, kept, to);
        }
    }

    /// A step of semi-implicit Euler: all multipliers stand after the kick, so that they are undone from the end.
    fn kicks_first(&self, taken: &mut Taken, decay: &Decay<Scalar>, length: Scalar, [from, to]: [Vector; 2]) {
        let mass = self.body.mass();
        let [start, end] = self.body.ends;
        let mean = (end.position - start.position) / self.tick;
        let moving = undone(to, decay.after_move).unwrap_or(mean);
        taken.damping.turn(mass, moving, to);
        let kicked = from * decay.keep.map_or(1.0, |factor| factor.whole) + self.acceleration * decay.gain;
        let would_be = kicked * decay.before_move.map_or(1.0, |factor| factor.whole);
        let damped = self.unrestrained(moving, would_be);
        taken.limits.turn(mass, damped, moving);
        // A factor of 0 leaves nothing to tell what the kick had added.
        let kicked = undone(damped, decay.before_move).unwrap_or(from);
        taken.damping.turn(mass, kicked, damped);
        if let Some(q) = self.q(decay, length) {
            taken.damping.decay(mass, q, from, kicked);
        }
    }

    /// The velocity before limit and locks, of which `moving` is left; it `would_be` that by the acceleration, which
    /// along a locked axis is none.
    fn unrestrained(&self, moving: Vector, would_be: Vector) -> Vector {
        if self.is_limited(moving) && would_be.length() > moving.length() {
            return would_be;
        }
        // Nothing is taken off again where nothing is locked, which would leave a rounding.
        self.body.locks.map_or(moving, |_| moving + would_be - self.body.open(would_be))
    }

    /// All other methods: it stands before and after the tick, or is a law.
    fn around(&self) -> Taken {
        let mut taken = self.nothing();
        if !self.asks() {
            return taken;
        }
        let (decay, rate) =
            self.damping.map_or((Decay::none(self.tick), 0.0), |damping| damping.around(self.tick));
        taken.rate = rate;
        let mass = self.body.mass();
        let [from, to] = taken.between;
        let damped = decay.before_move.map_or(from, |factor| from * factor.whole);
        let entering = self.restrained(damped);
        taken.damping.turn(mass, from, damped);
        taken.limits.turn(mass, damped, entering);
        let would_be = self.leaving(entering);
        let decayed = would_be * decay.after_move.map_or(1.0, |factor| factor.whole);
        let free = if self.is_limited(to) && decayed.length() > to.length() { decayed } else { to };
        taken.limits.turn(mass, free, to);
        let leaving = undone(free, decay.after_move).unwrap_or(would_be);
        taken.damping.turn(mass, leaving, free);
        taken.between = [entering, leaving];
        taken
    }

    /// The velocity at the end of a tick that nothing was taken of, from where the body has come to.
    fn leaving(&self, entering: Vector) -> Vector {
        let [State { position: from, .. }, State { position: to, .. }] = self.body.ends;
        let (mean, kick) = ((to - from) / self.tick, self.acceleration * self.tick);
        match self.method {
            // They move by the velocity at the end.
            Method::PositionVerlet | Method::ImplicitEuler => mean,
            // To the second order of the tick.
            _ => mean * 3.0 - entering * 2.0 - kick * 0.5,
        }
    }
}

/// Least factor that can be undone without being left with rounding errors alone.
const LEAST: Scalar = 1e-6;

/// The velocity that was multiplied by `factor`.
fn undone(v: Vector, factor: Option<Factor<Scalar>>) -> Option<Vector> {
    let factor = factor.map(|factor| factor.whole);
    match factor {
        None => Some(v),
        Some(factor) => (factor.abs() > LEAST).then(|| v / factor),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_of_the_integrals_agree_with_a_sum_of_many_parts() {
        for q in [1e-9, 1e-3, 0.05, 0.0999, 0.1001, 0.7, 5.0, 60.0] {
            let parts = 200_000;
            let f = |s: Scalar| Real::exp_m1(-q * s) / Real::exp_m1(-q);
            let at = |i: i32| f((f64::from(i) + 0.5) / f64::from(parts));
            let sum =
                |g: fn(Scalar) -> Scalar| (0..parts).map(|i| g(at(i))).sum::<Scalar>() / f64::from(parts);
            let [mean, square] = exponential(q);
            assert!((mean - sum(|f| f)).abs() < 1e-8, "{q}: {mean}");
            assert!((square - sum(|f| f * f)).abs() < 1e-8, "{q}: {square}");
        }
        let ([a, b], [c, d]) = (exponential(SMALL - 1e-13), exponential(SMALL));
        assert!((a - c).abs() < 1e-12 && (b - d).abs() < 1e-12, "{a} {c}, {b} {d}");
    }
}
