//! The arithmetic alone: the problems of single bodies in loops over plain arrays.
//!
//! The methods are those of the program, and so is their arithmetic, but here the compiler sees the law: nothing is called,
//! copied or checked. The time of such a loop is the price of the method; what the program takes longer is its own.

use glam::{DMat3, DVec3};
use motion::Method;
use motion::methods::{
    ExplicitEuler, Field, ImplicitEuler, Integrator, MethodStateKind, Newton, NewtonField, PositionVerlet,
    RungeKutta2Heun, RungeKutta2Midpoint, RungeKutta4, SemiImplicitEuler, StepState, VelocityVerlet,
    Yoshida4, newton_velocity,
};

use super::problem::State;
use super::record::{Counts, Failure, Setting};
use super::runner::{Runner, Sample};
use super::subject::Subject;
use crate::run::movable;

/// The acceleration of one body, m/s², as a person would write it for one problem.
pub(crate) trait Formula: Copy + Send + 'static {
    /// Whether it depends on neither position nor velocity.
    const IS_CONSTANT: bool = false;
    /// Whether it depends on the velocity.
    const DEPENDS_ON_VELOCITY: bool = false;

    fn acceleration(self, x: DVec3, v: DVec3) -> DVec3;

    /// The rate c, 1/s, of an acceleration `constant - c v`.
    fn linear_rate(self) -> Option<f64> {
        None
    }

    /// Derivatives by position, 1/s², and velocity, 1/s.
    fn jacobians(self, x: DVec3, v: DVec3) -> [DMat3; 2] {
        let _ = (x, v);
        [DMat3::ZERO; 2]
    }
}

/// The field of one body under a formula.
struct OneBody<F> {
    formula: F,
    h: f64,
}

impl<F: Formula> Field for OneBody<F> {
    type Real = f64;
    type Space = DVec3;

    #[inline(always)]
    fn step(&self) -> f64 {
        self.h
    }

    #[inline(always)]
    fn laws(&mut self, _: f64, x: DVec3, v: DVec3) -> DVec3 {
        self.formula.acceleration(x, v)
    }

    #[inline(always)]
    fn applied(&self) -> DVec3 {
        DVec3::ZERO
    }

    #[inline(always)]
    fn plus_applied(&self, a: DVec3) -> DVec3 {
        a
    }

    #[inline(always)]
    fn depends_on_velocity(&self) -> bool {
        F::DEPENDS_ON_VELOCITY
    }

    #[inline(always)]
    fn is_constant(&self) -> bool {
        F::IS_CONSTANT
    }

    #[inline(always)]
    fn implicit_velocity(&mut self, x: DVec3, v: DVec3) -> DVec3 {
        newton_velocity(self, x, v)
    }
}

impl<F: Formula> NewtonField for OneBody<F> {
    fn linear_rate(&self) -> Option<f64> {
        self.formula.linear_rate()
    }

    fn correction(&mut self, x: DVec3, v: DVec3, residual: DVec3) -> DVec3 {
        let [by_x, by_v] = self.formula.jacobians(x, v);
        (DMat3::IDENTITY - by_v * self.h - by_x * (self.h * self.h)).inverse() * residual
    }

    fn size(&self, v: DVec3) -> f64 {
        v.abs().max_element()
    }

    fn report(&mut self, _: Newton) {}
}

/// Bodies in arrays, one for each coordinate.
struct Loop<F> {
    formula: F,
    method: Method,
    h: f64,
    ids: Vec<u32>,
    x: [Vec<f64>; 3],
    v: [Vec<f64>; 3],
    /// The last accelerations, if the method has computed them.
    a: [Vec<f64>; 3],
    has_a: bool,
    /// Length of the last step, s; 0 at the start.
    last_step: f64,
}

/// Makes the run of a subject in a loop.
pub(crate) type MakeLoop = fn(&Subject, Setting) -> Box<dyn Runner>;

/// The run of `subject` in a loop with a formula.
pub(crate) fn run<F: Formula + Default>(subject: &Subject, setting: Setting) -> Box<dyn Runner> {
    let bodies: Vec<_> = movable(&subject.scene).collect();
    let column = |number: &dyn Fn(State) -> f64| -> Vec<f64> {
        bodies.iter().map(|(_, body)| number((body.position, body.velocity))).collect()
    };
    let (x, v) = ([0, 1, 2].map(|i| column(&|(x, _)| x[i])), [0, 1, 2].map(|i| column(&|(_, v)| v[i])));
    Box::new(Loop {
        formula: F::default(),
        method: setting.method,
        h: 1.0 / (subject.scene.step_hz * f64::from(setting.substeps)),
        ids: bodies.iter().map(|(id, _)| *id).collect(),
        a: [0, 1, 2].map(|_| vec![0.0; bodies.len()]),
        x,
        v,
        has_a: false,
        last_step: 0.0,
    })
}

/// One number of every body, by axis.
struct Columns<'a>([&'a mut [f64]; 3]);

impl<'a> Columns<'a> {
    /// Cut to `n`, so that the compiler knows that they are equally long.
    fn of(columns: &'a mut [Vec<f64>; 3], n: usize) -> Self {
        Self(columns.each_mut().map(|column| &mut column[..n]))
    }

    #[inline(always)]
    fn get(&self, i: usize) -> DVec3 {
        DVec3::new(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    #[inline(always)]
    fn set(&mut self, i: usize, to: DVec3) {
        (self.0[0][i], self.0[1][i], self.0[2][i]) = (to.x, to.y, to.z);
    }
}

impl<F: Formula> Loop<F> {
    fn step<M: Integrator>(&mut self) {
        let caches =
            M::STATE == MethodStateKind::LastAcceleration && !F::DEPENDS_ON_VELOCITY && !F::IS_CONSTANT;
        match (caches, self.has_a) {
            (true, true) => self.step_each::<M, true, true>(),
            (true, false) => self.step_each::<M, true, false>(),
            (false, _) => self.step_each::<M, false, false>(),
        }
        (self.has_a, self.last_step) = (caches, self.h);
    }

    /// A step of every body. Whether accelerations are cached, and known, is no branch of the loop: it would keep the
    /// compiler from vector instructions.
    fn step_each<M: Integrator, const CACHES: bool, const KNOWN: bool>(&mut self) {
        let (n, last_step) = (self.ids.len(), self.last_step);
        let mut field = OneBody { formula: self.formula, h: self.h };
        let (mut x, mut v) = (Columns::of(&mut self.x, n), Columns::of(&mut self.v, n));
        let mut a = Columns::of(&mut self.a, n);
        for i in 0..n {
            let start = if KNOWN { Some(a.get(i)) } else { None };
            let mut state = StepState { last_step, start };
            let (to, velocity) = M::step(&mut field, x.get(i), v.get(i), &mut state);
            x.set(i, to);
            v.set(i, velocity);
            if CACHES {
                a.set(i, state.start.unwrap_or_default());
            }
        }
    }
}

impl<F: Formula> Runner for Loop<F> {
    fn tick(&mut self) {
        match self.method {
            Method::ExplicitEuler => self.step::<ExplicitEuler>(),
            Method::SemiImplicitEuler => self.step::<SemiImplicitEuler>(),
            Method::ImplicitEuler => self.step::<ImplicitEuler>(),
            Method::PositionVerlet => self.step::<PositionVerlet>(),
            Method::VelocityVerlet => self.step::<VelocityVerlet>(),
            Method::RungeKutta2Midpoint => self.step::<RungeKutta2Midpoint>(),
            Method::RungeKutta2Heun => self.step::<RungeKutta2Heun>(),
            Method::RungeKutta4 => self.step::<RungeKutta4>(),
            Method::Yoshida4 => self.step::<Yoshida4>(),
        }
    }

    fn states(&mut self) -> Vec<Sample> {
        let vector = |[x, y, z]: &[Vec<f64>; 3], i: usize| DVec3::new(x[i], y[i], z[i]);
        self.ids.iter().enumerate().map(|(i, id)| (*id, vector(&self.x, i), vector(&self.v, i))).collect()
    }

    /// Not counted: it is timed alone.
    fn counts(&mut self) -> Counts {
        Counts::default()
    }

    fn failure(&mut self) -> Option<Failure> {
        None
    }
}
