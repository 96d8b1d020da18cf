//! One tick of a method on a linear system of a few coordinates, as a matrix.

use std::ops::{Add, Mul, Sub};

use super::matrix::Matrix;
use crate::laws::damping::{Damping, Decay};
use crate::methods::table::Method;
use crate::methods::{Field, Integrator, StepState, with_method};

/// Largest number of coordinates of a system that is not reduced.
pub(crate) const MOST_COORDINATES: usize = 12;

/// The method, tick and substeps of a system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stepping {
    pub method: Method,
    /// Length of a tick, s, above 0.
    pub tick: f64,
    /// Substeps per tick, at least 1.
    pub substeps: u32,
    /// Whether the system can be solved by implicit Euler, which a cure may then name.
    pub may_be_implicit: bool,
}

impl Stepping {
    /// Length of a substep, s.
    pub fn substep(self) -> f64 {
        self.tick / f64::from(self.substeps)
    }
}

/// A linear system `x'' = -A x - C x'` in at most [`MOST_COORDINATES`] coordinates in which the mass is 1, and the scene's damping.
#[derive(Clone, Debug)]
pub(crate) struct Oscillators {
    /// A, 1/s²: symmetric and positive semidefinite.
    pub stiffness: Matrix,
    /// C of laws, 1/s.
    pub damping: Matrix,
    /// The scene's damping by rate, each with the projection on the coordinates with that rate; the projections sum to
    /// 1.
    pub decays: Vec<(Damping, Matrix)>,
}

impl Oscillators {
    /// One oscillator: A = `stiffness`, 1/s², C = `rate`, 1/s.
    pub fn one(stiffness: f64, rate: f64, damping: Option<Damping>) -> Self {
        Self {
            stiffness: Matrix::scalar(1, stiffness),
            damping: Matrix::scalar(1, rate),
            decays: damping.map(|damping| (damping, Matrix::scalar(1, 1.0))).into_iter().collect(),
        }
    }

    /// Largest factor of growth per tick, after many ticks; infinite if it is not finite.
    pub fn growth(&self, stepping: Stepping) -> f64 {
        let matrix = with_method!(stepping.method, M => match self.stiffness.size() {
            1 => self.tick::<M, 1>(stepping),
            _ => self.tick::<M, MOST_COORDINATES>(stepping),
        });
        let radius = matrix.radius();
        if radius.is_nan() { f64::INFINITY } else { radius }
    }

    /// Whether the system does not grow, apart from rounding.
    pub fn is_stable(&self, stepping: Stepping) -> bool {
        // A body at rest has a defective double eigenvalue 1, which rounding moves by its square root.
        let rounding = if self.stiffness.size() == 1 { 1e-11 } else { 1e-7 };
        self.growth(stepping) <= 1.0 + rounding * f64::from(stepping.substeps)
    }

    /// The matrix of a tick; rows and columns are x / h, v.
    fn tick<M: Integrator, const N: usize>(&self, stepping: Stepping) -> Matrix {
        let n = self.stiffness.size();
        let h = stepping.substep();
        let mut field = LinearField::<N>::of::<M>(self, stepping.tick, h);
        let mut step = Matrix::zero(2 * n);
        for column in 0..2 * n {
            let mut unit = [Coordinates([0.0; N]); 2];
            unit[column / n].0[column % n] = 1.0;
            let [x, v] = unit;
            // A step within a run: the first step of position Verlet differs.
            let mut step_state = StepState { last_step: h, start: None };
            let (x, v) = M::step(&mut field, x * h, v, &mut step_state);
            for row in 0..n {
                step.set(row, column, x.0[row] / h);
                step.set(n + row, column, v.0[row]);
            }
        }
        let tick = step.power(stepping.substeps);
        if M::DAMPS_INSIDE || self.decays.is_empty() {
            return tick;
        }
        let of_velocities = |factor: &dyn Fn(&Decay) -> f64| {
            let mut matrix = Matrix::scalar(2 * n, 1.0);
            let factors =
                self.mixed(|damping| factor(&damping.factors_around_tick(stepping.tick).0));
            for (i, j) in (0..n * n).map(|entry| (entry / n, entry % n)) {
                matrix.set(n + i, n + j, factors.at(i, j));
            }
            matrix
        };
        let before = of_velocities(&|decay| decay.before_move.unwrap_or(1.0));
        let after = of_velocities(&|decay| decay.after_move.unwrap_or(1.0));
        after.times(&tick).times(&before)
    }

    /// The matrix that multiplies the coordinates of each damping by `number` of that damping.
    fn mixed(&self, number: impl Fn(Damping) -> f64) -> Matrix {
        let mut sum = Matrix::zero(self.stiffness.size());
        self.decays.iter().for_each(|(damping, part)| sum.add(part, number(*damping)));
        sum
    }
}

/// A vector of positions, velocities or accelerations.
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

/// The linear system as a [`Field`] for the methods.
struct LinearField<const N: usize> {
    h: f64,
    stiffness: Matrix,
    damping: Matrix,
    /// Factors of velocity and acceleration in a kick with exact damping.
    kick: Option<[Matrix; 2]>,
    before: Option<Matrix>,
    after: Option<Matrix>,
}

impl<const N: usize> LinearField<N> {
    /// The field of steps of `h` seconds by `M`, in ticks of `tick` seconds.
    fn of<M: Integrator>(modes: &Oscillators, tick: f64, h: f64) -> Self {
        let mut field = Self {
            h,
            stiffness: modes.stiffness.clone(),
            damping: modes.damping.clone(),
            kick: None,
            before: None,
            after: None,
        };
        if !M::DAMPS_INSIDE {
            field.damping.add(&modes.mixed(|damping| damping.factors_around_tick(tick).1), 1.0);
        } else if !modes.decays.is_empty() {
            let factor = |of: fn(&Decay) -> f64| modes.mixed(|damping| of(&damping.factors(h)));
            field.kick =
                Some([factor(|decay| decay.keep.unwrap_or(1.0)), factor(|decay| decay.gain)]);
            field.before = Some(factor(|decay| decay.before_move.unwrap_or(1.0)));
            field.after = Some(factor(|decay| decay.after_move.unwrap_or(1.0)));
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
