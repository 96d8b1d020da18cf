//! The arithmetic alone: the problems in loops over plain arrays.
//!
//! The methods are those of the program, and so is their arithmetic, but here the compiler sees the law: nothing is
//! called, copied or checked. The time of such a loop is the price of the method; the rest of a tick's time is
//! overhead of the program.

mod columns;
mod several;

use glam::{DMat3, DVec3};
use motion::Method;
use motion::methods::{
    ExplicitEuler, Field, ImplicitEuler, Integrator, MethodStateKind, Newton, NewtonField,
    PositionVerlet, RungeKutta2Heun, RungeKutta2Midpoint, RungeKutta4, SemiImplicitEuler,
    StepState, VelocityVerlet, Yoshida4, newton_velocity,
};

use scene::Scene;

use super::record::{Counts, Failure, Setting};
use super::runner::{Runner, Sample};
use crate::run::movable;
use columns::{Columns, each, each_with};
pub(crate) use several::{Springs, run_groups};

/// The acceleration of one body, m/s², as a person would write it for one problem.
pub(crate) trait Formula: Copy + Send + 'static {
    /// Whether it depends on neither position nor velocity.
    const IS_CONSTANT: bool = false;
    /// Whether it depends on the velocity.
    const DEPENDS_ON_VELOCITY: bool = false;

    fn acceleration(self, t: f64, x: DVec3, v: DVec3) -> DVec3;

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
#[derive(Clone, Copy)]
struct OneBody<F> {
    formula: F,
    /// Time at the start of the step, s.
    start: f64,
    h: f64,
    counts: Counts,
    unconverged: u64,
}

impl<F: Formula> Field for OneBody<F> {
    type Space = DVec3;

    #[inline(always)]
    fn step(&self) -> f64 {
        self.h
    }

    #[inline(always)]
    fn laws(&mut self, part: f64, x: DVec3, v: DVec3) -> DVec3 {
        self.counts.accelerations += 1;
        self.formula.acceleration(self.start + part * self.h, x, v)
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

    fn report(&mut self, Newton { iterations, converged }: Newton) {
        self.counts.solver += u64::from(iterations);
        self.unconverged += u64::from(!converged);
    }
}

/// Bodies in arrays, one for each coordinate.
struct Loop<F> {
    field: OneBody<F>,
    method: Method,
    substeps: u32,
    ids: Vec<u32>,
    x: Columns,
    v: Columns,
    /// The last accelerations, if the method has computed them.
    a: Columns,
    has_a: bool,
    /// Length of the last step, s; 0 at the start.
    last_step: f64,
    steps: u64,
}

/// A loop that takes the steps of a tick by any method.
trait Steps {
    fn step<M: Integrator>(&mut self);
}

/// Takes the steps of a tick by `method`.
fn step_by(method: Method, run: &mut impl Steps) {
    match method {
        Method::ExplicitEuler => run.step::<ExplicitEuler>(),
        Method::SemiImplicitEuler => run.step::<SemiImplicitEuler>(),
        Method::ImplicitEuler => run.step::<ImplicitEuler>(),
        Method::PositionVerlet => run.step::<PositionVerlet>(),
        Method::VelocityVerlet => run.step::<VelocityVerlet>(),
        Method::RungeKutta2Midpoint => run.step::<RungeKutta2Midpoint>(),
        Method::RungeKutta2Heun => run.step::<RungeKutta2Heun>(),
        Method::RungeKutta4 => run.step::<RungeKutta4>(),
        Method::Yoshida4 => run.step::<Yoshida4>(),
    }
}

/// Makes the run of a scene in a loop.
pub(crate) type MakeLoop = fn(&Scene, Setting) -> Box<dyn Runner>;

/// The run of `scene` in a loop with a formula.
pub(crate) fn run<F: Formula + Default>(scene: &Scene, setting: Setting) -> Box<dyn Runner> {
    Box::new(Loop::<F>::new(scene, setting))
}

impl<F: Formula + Default> Loop<F> {
    fn new(scene: &Scene, setting: Setting) -> Self {
        let mut new = Self {
            field: OneBody {
                formula: F::default(),
                start: 0.0,
                h: 1.0 / (scene.step_hz * f64::from(setting.substeps.least())),
                counts: Counts::default(),
                unconverged: 0,
            },
            method: setting.method,
            substeps: setting.substeps.least(),
            ids: Vec::new(),
            x: Columns::default(),
            v: Columns::default(),
            a: Columns::default(),
            has_a: false,
            last_step: 0.0,
            steps: 0,
        };
        for (id, body) in movable(scene) {
            new.ids.push(id);
            columns::push(&mut new.x, body.position);
            columns::push(&mut new.v, body.velocity);
            columns::push(&mut new.a, DVec3::ZERO);
        }
        new
    }
}

impl<F: Formula> Steps for Loop<F> {
    fn step<M: Integrator>(&mut self) {
        let caches = M::STATE == MethodStateKind::LastAcceleration
            && !F::DEPENDS_ON_VELOCITY
            && !F::IS_CONSTANT;
        for _ in 0..self.substeps {
            match (caches, self.has_a) {
                (true, true) => self.step_each::<M, true, true>(),
                (true, false) => self.step_each::<M, true, false>(),
                (false, _) => self.step_each::<M, false, false>(),
            }
            (self.has_a, self.last_step) = (caches, self.field.h);
            self.steps += 1;
            self.field.start = self.steps as f64 * self.field.h;
        }
    }
}

impl<F: Formula> Loop<F> {
    /// A step of every body. `CACHES` and `KNOWN` are constants, because a branch in the loop would keep the compiler
    /// from vector instructions.
    fn step_each<M: Integrator, const CACHES: bool, const KNOWN: bool>(&mut self) {
        let (field, last_step) = (self.field, self.last_step);
        let step = |field: &mut OneBody<F>, x, v, start| {
            let mut state = StepState { last_step, start };
            let (x, v) = M::step(field, x, v, &mut state);
            (x, v, state.start)
        };
        self.field = if CACHES {
            let columns = [&mut self.x, &mut self.v, &mut self.a];
            each_with(columns, field, |field, [x, v, a]| {
                let (x, v, a) = step(field, x, v, KNOWN.then_some(a));
                [x, v, a.unwrap_or_default()]
            })
        } else {
            each([&mut self.x, &mut self.v], field, |field, [x, v]| {
                let (x, v, _) = step(field, x, v, None);
                [x, v]
            })
        };
    }
}

impl<F: Formula> Runner for Loop<F> {
    fn tick(&mut self) {
        step_by(self.method, self);
    }

    fn states(&mut self) -> Vec<Sample> {
        let sample =
            |(i, id): (usize, &u32)| (*id, columns::get(&self.x, i), columns::get(&self.v, i));
        self.ids.iter().enumerate().map(sample).collect()
    }

    fn counts(&mut self) -> Counts {
        self.field.counts
    }

    fn failure(&mut self) -> Option<Failure> {
        let steps = self.field.unconverged;
        (steps > 0).then_some(Failure::Unconverged { steps })
    }
}
