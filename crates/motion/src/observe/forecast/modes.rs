//! One tick of a method on a linear system of a few coordinates, as a matrix.

use std::ops::{Add, Mul, Sub};

use super::matrix::Matrix;
use crate::laws::damping::{Damping, Decay};
use crate::methods::table::Method;
use crate::methods::{Carry, Field, Integrator, with_method};

/// Coordinates of a system that is reckoned with as a whole.
pub(crate) const MOST: usize = 12;

/// How a system is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pace {
    pub method: Method,
    /// Length of a tick, s, above 0.
    pub tick: f64,
    /// Parts of a tick, at least 1.
    pub substeps: u32,
}

/// `x'' = -A x - C x'` in at most [`MOST`] coordinates in which the mass is 1, and damping of the scene.
#[derive(Clone, Debug)]
pub(crate) struct Modes {
    /// A, 1/s²; symmetric, no eigenvalue below 0.
    pub stiffness: Matrix,
    /// C by laws, 1/s.
    pub damping: Matrix,
    /// Damping of the scene, and the part of every coordinate that decays so; the parts add up to 1.
    pub decays: Vec<(Damping, Matrix)>,
}

impl Modes {
    /// One oscillator: A = `stiffness`, 1/s², C = `rate`, 1/s.
    pub fn one(stiffness: f64, rate: f64, damping: Option<Damping>) -> Self {
        Self {
            stiffness: Matrix::scalar(1, stiffness),
            damping: Matrix::scalar(1, rate),
            decays: damping.map(|damping| (damping, Matrix::scalar(1, 1.0))).into_iter().collect(),
        }
    }

    /// By what factor the state grows in a tick at most, when many have passed; infinite where that is no number.
    pub fn growth(&self, pace: Pace) -> f64 {
        let matrix = with_method!(pace.method, M => match self.stiffness.size() {
            1 => self.tick::<M, 1>(pace),
            _ => self.tick::<M, MOST>(pace),
        });
        let radius = matrix.radius();
        if radius.is_nan() { f64::INFINITY } else { radius }
    }

    /// Whether it does not grow, but for rounding.
    pub fn is_stable(&self, pace: Pace) -> bool {
        // A body at rest is an eigenvalue 1 with no second direction: rounding moves such a one by its square root.
        let rounding = if self.stiffness.size() == 1 { 1e-11 } else { 1e-7 };
        self.growth(pace) <= 1.0 + rounding * f64::from(pace.substeps)
    }

    /// The state after a tick from that before it: rows and columns are x / h, v.
    fn tick<M: Integrator, const N: usize>(&self, pace: Pace) -> Matrix {
        let n = self.stiffness.size();
        let h = pace.tick / f64::from(pace.substeps);
        let mut field = LinearField::<N>::of::<M>(self, pace.tick, h);
        let mut step = Matrix::zero(2 * n);
        for column in 0..2 * n {
            let mut unit = [Coordinates([0.0; N]); 2];
            unit[column / n].0[column % n] = 1.0;
            let [x, v] = unit;
            // In the midst of a run: position Verlet's first step is another one.
            let mut carry = Carry { last_step: h, start: None };
            let (x, v) = M::step(&mut field, x * h, v, &mut carry);
            for row in 0..n {
                step.set(row, column, x.0[row] / h);
                step.set(n + row, column, v.0[row]);
            }
        }
        let tick = step.power(pace.substeps);
        if M::DAMPS_INSIDE || self.decays.is_empty() {
            return tick;
        }
        let of_velocities = |factor: &dyn Fn(&Decay<f64>) -> f64| {
            let mut matrix = Matrix::scalar(2 * n, 1.0);
            let factors = self.mixed(|damping| factor(&damping.around(pace.tick).0));
            for (i, j) in (0..n * n).map(|entry| (entry / n, entry % n)) {
                matrix.set(n + i, n + j, factors.at(i, j));
            }
            matrix
        };
        let before = of_velocities(&|decay| decay.before_move.map_or(1.0, |factor| factor.whole));
        let after = of_velocities(&|decay| decay.after_move.map_or(1.0, |factor| factor.whole));
        after.times(&tick).times(&before)
    }

    /// A number of each damping, in coordinates.
    fn mixed(&self, number: impl Fn(Damping) -> f64) -> Matrix {
        let mut sum = Matrix::zero(self.stiffness.size());
        self.decays.iter().for_each(|(damping, part)| sum.add(part, number(*damping)));
        sum
    }
}

/// Positions, velocities or accelerations.
#[derive(Clone, Copy)]
struct Coordinates<const N: usize>([f64; N]);

impl<const N: usize> Add for Coordinates<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl<const N: usize> Sub for Coordinates<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl<const N: usize> Mul<f64> for Coordinates<N> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|part| part * factor))
    }
}

/// The system for the methods of integration.
struct LinearField<const N: usize> {
    h: f64,
    stiffness: Matrix,
    damping: Matrix,
    /// What exact damping leaves of a velocity and of an acceleration.
    kick: Option<[Matrix; 2]>,
    before: Option<Matrix>,
    after: Option<Matrix>,
}

impl<const N: usize> LinearField<N> {
    /// Of steps of `M` of `h` seconds in ticks of `tick` seconds.
    fn of<M: Integrator>(modes: &Modes, tick: f64, h: f64) -> Self {
        let mut field = Self {
            h,
            stiffness: modes.stiffness.clone(),
            damping: modes.damping.clone(),
            kick: None,
            before: None,
            after: None,
        };
        if !M::DAMPS_INSIDE {
            field.damping.add(&modes.mixed(|damping| damping.around(tick).1), 1.0);
        } else if !modes.decays.is_empty() {
            let factor = |of: fn(&Decay<f64>) -> f64| modes.mixed(|damping| of(&damping.factors(h)));
            field.kick =
                Some([factor(|decay| decay.keep.map_or(1.0, |keep| keep.whole)), factor(|decay| decay.gain)]);
            field.before = Some(factor(|decay| decay.before_move.map_or(1.0, |factor| factor.whole)));
            field.after = Some(factor(|decay| decay.after_move.map_or(1.0, |factor| factor.whole)));
        }
        field
    }

    fn apply(matrix: &Matrix, x: Coordinates<N>) -> Coordinates<N> {
        let n = matrix.size();
        let row = |i: usize| (0..n).map(|j| matrix.at(i, j) * x.0[j]).sum();
        Coordinates(std::array::from_fn(|i| if i < n { row(i) } else { 0.0 }))
    }

    fn apply_to(matrix: Option<&Matrix>, v: Coordinates<N>) -> Coordinates<N> {
        matrix.map_or(v, |matrix| Self::apply(matrix, v))
    }
}

impl<const N: usize> Field for LinearField<N> {
    type Real = f64;
    type Space = Coordinates<N>;

    fn step(&self) -> f64 {
        self.h
    }

    fn laws(&mut self, _: f64, x: Coordinates<N>, v: Coordinates<N>) -> Coordinates<N> {
        (Self::apply(&self.stiffness, x) + Self::apply(&self.damping, v)) * -1.0
    }

    fn applied(&self) -> Coordinates<N> {
        Coordinates([0.0; N])
    }

    fn depends_on_velocity(&self) -> bool {
        !self.damping.is_zero()
    }

    fn kick(&mut self, v: Coordinates<N>, a: Coordinates<N>) -> Coordinates<N> {
        match &self.kick {
            Some([keep, gain]) => Self::apply(keep, v) + Self::apply(gain, a),
            None => v + a * self.h,
        }
    }

    fn before_move(&mut self, v: Coordinates<N>) -> Coordinates<N> {
        Self::apply_to(self.before.as_ref(), v)
    }

    fn after_move(&mut self, v: Coordinates<N>) -> Coordinates<N> {
        Self::apply_to(self.after.as_ref(), v)
    }

    fn implicit_velocity(&mut self, x: Coordinates<N>, v: Coordinates<N>) -> Coordinates<N> {
        let n = self.stiffness.size();
        let mut matrix = Matrix::scalar(n, 1.0);
        matrix.add(&self.damping, self.h);
        matrix.add(&self.stiffness, self.h * self.h);
        let mut v1 = v + Self::apply(&self.stiffness, x) * -self.h;
        matrix.solve(&mut v1.0[..n]);
        v1
    }
}
