//! The flight of one body apart from its world: the method itself steps it on all of its laws.

use std::ops::ControlFlow;

use glam::{DMat3, DVec3};

use super::modes::Stepping;
use crate::laws::damping::{Damping, Decay};
use crate::laws::{BodyState, EvaluationTime, Jacobians, Law};
use crate::methods::{
    Field, Integrator, Newton, NewtonField, StepState, newton_velocity, with_method,
};
use crate::state::components::AxisLocks;

/// A body with everything that acts on it. Two bodies that attract each other are one subject: their distance, in a well of
/// the strength G (m1 + m2).
#[derive(Clone, Copy)]
pub(super) struct Subject<'a> {
    /// Every law, gravity included.
    pub laws: &'a [&'a dyn Law],
    pub damping: Option<Damping>,
    pub locks: Option<AxisLocks>,
    /// Largest speed, m/s.
    pub speed_limit: Option<f64>,
    pub start: BodyState,
    /// Time at the start, s.
    pub time: f64,
}

/// Position and velocity.
pub(super) type Point = [DVec3; 2];

/// Steps of the true motion per reciprocal of the fastest rate that it meets.
const STEPS_PER_TIME: f64 = 16.0;

/// Most steps of the true motion.
const MOST_STEPS: u32 = 400_000;

impl Subject<'_> {
    /// Steps the body for `ticks` ticks, or until `see` breaks. `see` is called with the number of each tick and the
    /// state after it. Returns whether every state was finite.
    pub fn fly(
        &self,
        stepping: Stepping,
        ticks: u32,
        see: &mut dyn FnMut(u32, Point) -> ControlFlow<()>,
    ) -> bool {
        with_method!(stepping.method, M => self.fly_by::<M>(stepping, ticks, see))
    }

    fn fly_by<M: Integrator>(
        &self,
        stepping: Stepping,
        ticks: u32,
        see: &mut dyn FnMut(u32, Point) -> ControlFlow<()>,
    ) -> bool {
        let h = stepping.tick / f64::from(stepping.substeps);
        let (around, rate) = self
            .damping
            .filter(|_| !M::DAMPS_INSIDE)
            .map_or((Decay::none(stepping.tick), 0.0), |damping| {
                damping.factors_around_tick(stepping.tick)
            });
        let decay = self
            .damping
            .filter(|_| M::DAMPS_INSIDE)
            .map_or(Decay::none(h), |damping| damping.factors(h));
        let mut field = BodyField { body: self, h, start: self.time, rate, decay };
        let BodyState { position: mut x, velocity, .. } = self.start;
        let mut v = field.open(velocity);
        let mut state = StepState::<BodyField<'_>>::default();
        for tick in 1..=ticks {
            v *= around.before_move.unwrap_or(1.0);
            for _ in 0..stepping.substeps {
                (x, v) = M::step(&mut field, x, v, &mut state);
                field.start += h;
            }
            v *= around.after_move.unwrap_or(1.0);
            if around.after_move.is_some() | field.limit(&mut v) {
                state.start = None;
            }
            if !(x.is_finite() && v.is_finite()) {
                return false;
            }
            if see(tick, [x, v]).is_break() {
                break;
            }
        }
        true
    }

    /// The state one step after `point`, within a run.
    pub fn step_within(&self, stepping: Stepping, [x, v]: Point) -> Point {
        let h = stepping.tick;
        let mut field =
            BodyField { body: self, h, start: self.time, rate: 0.0, decay: Decay::none(h) };
        // A step within a run: the first step of position Verlet differs.
        let mut state = StepState { last_step: h, start: None };
        let (x, v) = with_method!(stepping.method, M => M::step(&mut field, x, v, &mut state));
        [x, v]
    }

    /// Computes the true motion over `ticks` ticks, by Runge-Kutta 4 at steps that follow the rates that it meets. `see` is
    /// called with whether a tick ends and the state after every step. Returns whether the motion could be resolved.
    pub fn reference_motion(
        &self,
        tick: f64,
        ticks: u32,
        see: &mut dyn FnMut(bool, Point),
    ) -> bool {
        use crate::methods::RungeKutta4;
        let rate = self.damping.map_or(0.0, |damping| damping.rate);
        let mut field =
            BodyField { body: self, h: tick, start: self.time, rate, decay: Decay::none(tick) };
        let BodyState { position: mut x, velocity: mut v, .. } = self.start;
        let mut left = MOST_STEPS;
        for _ in 0..ticks {
            let mut rest = tick;
            while rest > 0.0 {
                if left == 0 {
                    return false;
                }
                left -= 1;
                let most = 1.0 / (STEPS_PER_TIME * self.fastest_rate(field.start, [x, v]));
                let steps = (rest / most).ceil().max(1.0);
                if steps > f64::from(MOST_STEPS) || steps.is_nan() {
                    return false;
                }
                field.h = rest / steps;
                rest = if steps > 1.0 { rest - field.h } else { 0.0 };
                (x, v) = RungeKutta4::step(&mut field, x, v, &mut StepState::default());
                field.start += field.h;
                field.limit(&mut v);
                if !(x.is_finite() && v.is_finite()) {
                    return false;
                }
                see(rest == 0.0, [x, v]);
            }
        }
        true
    }

    /// The largest rate at which the laws change along a motion, 1/s: by position, or by velocity.
    fn fastest_rate(&self, time: f64, [position, velocity]: Point) -> f64 {
        let at = EvaluationTime { time, within_step: time };
        let body = BodyState { position, velocity, ..self.start };
        let mut sum = Jacobians::zero();
        for law in self.laws {
            let of_law = law.jacobians(at, body);
            sum.position += of_law.position;
            sum.velocity += of_law.velocity;
        }
        let damping = self.damping.map_or(0.0, |damping| damping.rate);
        size(sum.position).sqrt().max(size(sum.velocity) + damping)
    }

    /// Potential energy at a position, J; `None` if something takes or gives energy.
    pub fn potential(&self, position: DVec3) -> Option<f64> {
        let keeps = self.damping.is_none_or(|damping| damping.rate == 0.0)
            && self.laws.iter().all(|law| law.has_potential());
        let body = BodyState { position, ..self.start };
        keeps.then(|| self.laws.iter().map(|law| law.potential_energy(body)).sum())
    }
}

/// An upper bound of the magnitude of the eigenvalues: exact for a multiple of the unit matrix, 1.22 times too large for the
/// pull of a point.
fn size(derivative: DMat3) -> f64 {
    let [x, y, z] = derivative.to_cols_array_2d().map(DVec3::from_array);
    let rows = (x.abs() + y.abs() + z.abs()).max_element();
    let square = x.length_squared() + y.length_squared() + z.length_squared();
    rows.min(square.sqrt())
}

/// The field of one body in one step.
struct BodyField<'a> {
    body: &'a Subject<'a>,
    h: f64,
    /// Time at the start of the step, s.
    start: f64,
    /// Rate of exact damping as a law, 1/s.
    rate: f64,
    decay: Decay,
}

impl BodyField<'_> {
    fn at(&self, part: f64) -> EvaluationTime {
        EvaluationTime { time: self.start + part * self.h, within_step: self.start + 0.5 * self.h }
    }

    fn state(&self, position: DVec3, velocity: DVec3) -> BodyState {
        BodyState { position, velocity, ..self.body.start }
    }

    fn open(&self, a: DVec3) -> DVec3 {
        self.body.locks.map_or(a, |locks| {
            let open = |locked: bool| f64::from(u8::from(!locked));
            a * DVec3::new(open(locks.x), open(locks.y), open(locks.z))
        })
    }

    /// Limits the speed; returns whether it was too large.
    fn limit(&self, v: &mut DVec3) -> bool {
        let Some(most) = self.body.speed_limit.filter(|most| v.length() > *most) else {
            return false;
        };
        *v = v.clamp_length_max(most);
        true
    }
}

impl Field for BodyField<'_> {
    type Space = DVec3;

    fn step(&self) -> f64 {
        self.h
    }

    fn laws(&mut self, part: f64, x: DVec3, v: DVec3) -> DVec3 {
        let (at, body) = (self.at(part), self.state(x, v));
        let sum: DVec3 = self.body.laws.iter().map(|law| law.acceleration(at, body)).sum();
        self.open(sum - v * self.rate)
    }

    fn applied(&self) -> DVec3 {
        DVec3::ZERO
    }

    fn depends_on_velocity(&self) -> bool {
        self.rate != 0.0 || self.body.laws.iter().any(|law| law.depends_on_velocity())
    }

    fn kick(&mut self, v: DVec3, a: DVec3) -> DVec3 {
        v * self.decay.keep.unwrap_or(1.0) + a * self.decay.gain
    }

    fn before_move(&mut self, v: DVec3) -> DVec3 {
        v * self.decay.before_move.unwrap_or(1.0)
    }

    fn after_move(&mut self, v: DVec3) -> DVec3 {
        v * self.decay.after_move.unwrap_or(1.0)
    }

    fn implicit_velocity(&mut self, x: DVec3, v: DVec3) -> DVec3 {
        newton_velocity(self, x, v)
    }
}

impl NewtonField for BodyField<'_> {
    fn linear_rate(&self) -> Option<f64> {
        None
    }

    fn correction(&mut self, x: DVec3, v: DVec3, residual: DVec3) -> DVec3 {
        let (at, body) = (self.at(1.0), self.state(x, v));
        let mut matrix = DMat3::IDENTITY * (1.0 + self.rate * self.h);
        for law in self.body.laws {
            let Jacobians { position, velocity } = law.jacobians(at, body);
            matrix -= velocity * self.h + position * (self.h * self.h);
        }
        matrix.inverse() * residual
    }

    fn size(&self, v: DVec3) -> f64 {
        v.abs().max_element()
    }

    fn report(&mut self, _: Newton) {}
}
