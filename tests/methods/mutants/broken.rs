//! The broken methods. Each is written like the one it breaks, but for the mistake.

use motion::Method;
use motion::methods::{Field, Integrator, MethodStateKind, StepState};

use super::{
    CHANGING_STEPS, Checked, DECAY, FAR_AWAY, FINGERPRINT, MULTIPLIERS, ORDERS, PUSH, START,
    Stepper, TERMINAL_SPEED,
};
use crate::rigs::Bare;

/// `x += v h` with damping around it, as the two Eulers have it.
fn advance<F: Field>(field: &mut F, x: F::Space, v: F::Space) -> (F::Space, F::Space) {
    let v = field.before_move(v);
    (x + v * field.step(), field.after_move(v))
}

/// Runge-Kutta 4 with weights in sixths and the parts of the step at which its stages are evaluated.
fn four_stages<F: Field>(
    field: &mut F,
    x: F::Space,
    v: F::Space,
    weights: [f64; 4],
    parts: [f64; 4],
    quarantined: bool,
) -> (F::Space, F::Space) {
    let h = field.step();
    let mut evaluate = |stage: usize, x, v| field.acceleration(parts[stage], x, v);
    let a1 = evaluate(0, x, v);
    let mut stage = |stage, x, v| if quarantined { a1 } else { evaluate(stage, x, v) };
    let (half, sixth) = (h * 0.5, h / 6.0);
    let v2 = v + a1 * half;
    let a2 = stage(1, x + v * half, v2);
    let v3 = v + a2 * half;
    let a3 = stage(2, x + v2 * half, v3);
    let v4 = v + a3 * h;
    let a4 = stage(3, x + v3 * h, v4);
    let [w1, w2, w3, w4] = weights.map(|w| sixth * w);
    (x + v * w1 + v2 * w2 + v3 * w3 + v4 * w4, v + a1 * w1 + a2 * w2 + a3 * w3 + a4 * w4)
}

const KUTTA: [f64; 4] = [1.0, 2.0, 2.0, 1.0];
const TIMES: [f64; 4] = [0.0, 0.5, 0.5, 1.0];

broken! { Inside, InsideMistake, SemiImplicitEuler, None, true
    /// Update order swapped: this is explicit Euler.
    PositionFirst: SemiImplicitEuler, |field, x, v, _carry| {
        let a = field.acceleration(0.0, x, v);
        let (x, v) = advance(field, x, v);
        (x, field.kick(v, a))
    }
    /// Update order swapped: this is semi-implicit Euler.
    VelocityFirst: ExplicitEuler, |field, x, v, _carry| {
        let a = field.acceleration(0.0, x, v);
        let v = field.kick(v, a);
        advance(field, x, v)
    }
    /// The acceleration read after the move.
    ReadAfterMove: ExplicitEuler, |field, x, v, _carry| {
        let (x, v) = advance(field, x, v);
        let a = field.acceleration(0.0, x, v);
        (x, field.kick(v, a))
    }
    /// Exact damping left out of the update.
    Undamped: SemiImplicitEuler, |field, x, v, _carry| {
        let a = field.acceleration(0.0, x, v);
        advance(field, x, v + a * field.step())
    }
    /// The tutorial's damping before the move.
    DampedBefore: SemiImplicitEuler, |field, x, v, _carry| {
        let a = field.acceleration(0.0, x, v);
        let v = field.kick(v, a);
        let v = field.before_move(v);
        let v = field.after_move(v);
        (x + v * field.step(), v)
    }
    /// The clamped damping after the move.
    DampedAfter: SemiImplicitEuler, |field, x, v, _carry| {
        let a = field.acceleration(0.0, x, v);
        let v = field.kick(v, a);
        let x = x + v * field.step();
        let v = field.before_move(v);
        (x, field.after_move(v))
    }
    /// Damping twice in a step.
    DampedTwice: SemiImplicitEuler, |field, x, v, _carry| {
        let a = field.acceleration(0.0, x, v);
        let v = field.kick(v, a);
        let (x, v) = advance(field, x, v);
        let v = field.after_move(v);
        (x, field.before_move(v))
    }
    /// Damping at every stage.
    DampedByStage: RungeKutta4, |field, x, v, _carry| {
        let (x, v) = four_stages(field, x, v, KUTTA, TIMES, false);
        let v = (0..4).fold(v, |v, _| {
            let v = field.before_move(v);
            field.after_move(v)
        });
        (x, v)
    }
}

broken! { Environment, AroundMistake, RungeKutta4, None, false
    /// Explicit Euler's acceleration for the implicit one.
    FrozenImplicit: ImplicitEuler, |field, x, v, _carry| {
        let v = v + field.acceleration(1.0, x, v) * field.step();
        (x + v * field.step(), v)
    }
    /// One iteration of the fixed point in place of a solve.
    Unsolved: ImplicitEuler, |field, x, v, _carry| {
        let h = field.step();
        let guess = v + field.acceleration(1.0, x, v) * h;
        let v = v + field.acceleration(1.0, x + guess * h, guess) * h;
        (x + v * h, v)
    }
    /// Forces evaluated once a step.
    FrozenMidpoint: RungeKutta2Midpoint, |field, x, v, _carry| {
        let h = field.step();
        let a = field.acceleration(0.0, x, v);
        (x + (v + a * (h * 0.5)) * h, v + a * h)
    }
    /// Forces evaluated once a step.
    FrozenHeun: RungeKutta2Heun, |field, x, v, _carry| {
        let h = field.step();
        let a = field.acceleration(0.0, x, v);
        let end = v + a * h;
        (x + (v + end) * (h * 0.5), v + (a + a) * (h * 0.5))
    }
    /// Forces evaluated once a step.
    FrozenKutta: RungeKutta4, |field, x, v, _carry| {
        four_stages(field, x, v, KUTTA, TIMES, true)
    }
    /// Forces evaluated once a step.
    FrozenVerlet: VelocityVerlet, |field, x, v, _carry| {
        let h = field.step();
        let a = field.acceleration(0.0, x, v);
        (x + (v + a * (h * 0.5)) * h, v + a * h)
    }
    /// Equal weights.
    EqualWeights: RungeKutta4, |field, x, v, _carry| {
        four_stages(field, x, v, [1.5; 4], TIMES, false)
    }
    /// Every stage at the time of the start.
    StagesAtStart: RungeKutta4, |field, x, v, _carry| {
        four_stages(field, x, v, KUTTA, [0.0; 4], false)
    }
    /// The last stage in the middle of the step.
    LastStageEarly: RungeKutta4, |field, x, v, _carry| {
        four_stages(field, x, v, KUTTA, [0.0, 0.5, 0.5, 0.5], false)
    }
    /// The middle at the time of the start.
    MidpointAtStart: RungeKutta2Midpoint, |field, x, v, _carry| {
        let (h, half) = (field.step(), 0.5);
        let a = field.acceleration(0.0, x, v);
        let middle = v + a * (half * h);
        let a = field.acceleration(0.0, x + v * (half * h), middle);
        (x + middle * h, v + a * h)
    }
    /// The middle at the time of the end.
    MidpointAtEnd: RungeKutta2Midpoint, |field, x, v, _carry| {
        let (h, half) = (field.step(), 0.5);
        let a = field.acceleration(0.0, x, v);
        let middle = v + a * (half * h);
        let a = field.acceleration(1.0, x + v * (half * h), middle);
        (x + middle * h, v + a * h)
    }
    /// The end at the time of the start.
    HeunAtStart: RungeKutta2Heun, |field, x, v, _carry| {
        let h = field.step();
        let half = h * 0.5;
        let a = field.acceleration(0.0, x, v);
        let end = v + a * h;
        let b = field.acceleration(0.0, x + v * h, end);
        (x + (v + end) * half, v + (a + b) * half)
    }
    /// The slope at the end only.
    HeunWithoutMean: RungeKutta2Heun, |field, x, v, _carry| {
        let h = field.step();
        let a = field.acceleration(0.0, x, v);
        let end = v + a * h;
        let b = field.acceleration(1.0, x + v * h, end);
        (x + end * h, v + b * h)
    }
    /// The push once a stage.
    PushedByStage: RungeKutta4, |field, x, v, _carry| {
        let pushes = field.applied() * (field.step() * 3.0);
        let (x, v) = four_stages(field, x, v, KUTTA, TIMES, false);
        (x, v + pushes)
    }
    /// The push at the first stage only, with a sixth of the weight.
    PushedOnce: RungeKutta4, |field, x, v, _carry| {
        let lost = field.applied() * (field.step() * (5.0 / 6.0));
        let (x, v) = four_stages(field, x, v, KUTTA, TIMES, false);
        (x, v - lost)
    }
    /// Velocity Verlet's end evaluated at the time of the start.
    EndAtStart: VelocityVerlet, |field, x, v, _carry| {
        let (h, half) = (field.step(), 0.5);
        let a = field.acceleration(0.0, x, v);
        let x = x + (v + a * (half * h)) * h;
        let b = field.acceleration(0.0, x, v + a * h);
        (x, v + (a + b) * (half * h))
    }
    /// Drag at the end with the velocity of the start.
    LaggedDrag: VelocityVerlet, |field, x, v, _carry| {
        let (h, half) = (field.step(), 0.5);
        let a = field.acceleration(0.0, x, v);
        let x = x + (v + a * (half * h)) * h;
        let b = field.acceleration(1.0, x, v);
        (x, v + (a + b) * (half * h))
    }
    /// Drag at the end with the velocity after half a kick.
    HalfKickedDrag: VelocityVerlet, |field, x, v, _carry| {
        let (h, half) = (field.step(), 0.5);
        let a = field.acceleration(0.0, x, v);
        let middle = v + a * (half * h);
        let x = x + middle * h;
        let b = field.acceleration(1.0, x, middle);
        (x, middle + b * (half * h))
    }
    /// Three equal steps: velocity Verlet with substeps.
    EqualParts: Yoshida4, |field, x, v, _carry| {
        let third = 1.0 / 3.0;
        composed(field, x, v, [(0.0, third), (third, third), (third + third, third)])
    }
    /// Every inner step begins at the time of the start.
    InnerTimes: Yoshida4, |field, x, v, _carry| {
        let [outer, inner] = yoshida();
        composed(field, x, v, [(0.0, outer), (0.0, inner), (0.0, outer)])
    }
    /// The step back is missing.
    NoStepBack: Yoshida4, |field, x, v, _carry| {
        let half = 0.5;
        composed(field, x, v, [(0.0, half), (half, 0.0), (half, half)])
    }
}

broken! { StepKept, StepMistake, PositionVerlet, LastStep, false
    /// Started from `x - v h` in place of the Taylor value.
    NoTaylorStart: PositionVerlet, |field, x, v, step_state| {
        let (h, half) = (field.step(), 0.5);
        let last = if step_state.last_step == 0.0 { h } else { step_state.last_step };
        let v = v + field.laws(0.0, x, v) * (half * (h + last));
        step_state.last_step = h;
        (x + (v + field.applied() * (half * h)) * h, v + field.applied() * h)
    }
    /// Started from a previous position at the origin.
    FromOrigin: PositionVerlet, |field, x, v, step_state| {
        let h = field.step();
        let v = if step_state.last_step == 0.0 { x * (1.0 / h) } else { v };
        let v = v + field.laws(0.0, x, v) * h + field.applied() * h;
        step_state.last_step = h;
        (x + v * h, v)
    }
    /// The increment of the last step whatever its length.
    NoRatio: PositionVerlet, |field, x, v, step_state| {
        let (h, half) = (field.step(), 0.5);
        let last = step_state.last_step;
        let kept = if last == 0.0 { v } else { v * (last / h) };
        let v = kept + field.laws(0.0, x, v) * (half * (h + last)) + field.applied() * h;
        step_state.last_step = h;
        (x + v * h, v)
    }
    /// The published correction: a ratio of the steps, but `a h²`.
    HalfRatio: PositionVerlet, |field, x, v, step_state| {
        let (h, half) = (field.step(), 0.5);
        let gain = if step_state.last_step == 0.0 { half * h } else { h };
        let v = v + field.laws(0.0, x, v) * gain + field.applied() * h;
        step_state.last_step = h;
        (x + v * h, v)
    }
}

broken! { AccelerationKept, AccelerationMistake, VelocityVerlet, LastAcceleration, false
    /// The push kept with the acceleration at the end: half of it acts in the next tick.
    PushKept: VelocityVerlet, |field, x, v, step_state| {
        let (h, half) = (field.step(), 0.5);
        let a = match step_state.start {
            Some(start) => start,
            None => field.laws(0.0, x, v),
        };
        let x = x + (v + a * (half * h)) * h;
        let b = field.acceleration(1.0, x, v + a * h);
        step_state.start = Some(b);
        (x, v + (a + b) * (half * h))
    }
}

fn yoshida() -> [f64; 2] {
    let outer = 1.0 / (2.0 - 2.0_f64.cbrt());
    [outer, 1.0 - 2.0 * outer]
}

/// Steps of velocity Verlet from a part of the step on and over a part of it.
fn composed<F: Field>(
    field: &mut F,
    mut x: F::Space,
    mut v: F::Space,
    steps: [(f64, f64); 3],
) -> (F::Space, F::Space) {
    for (from, over) in steps {
        let h = field.step() * over;
        let a = field.acceleration(from, x, v);
        x = x + (v + a * (h * 0.5)) * h;
        let b = field.acceleration(from + over, x, v + a * h);
        v = v + (a + b) * (h * 0.5);
    }
    (x, v)
}

/// `2 x - x0 + a h²`, with x0 in the place of the kept acceleration: a mistake in single precision alone.
#[derive(Clone, Copy, Default)]
struct TwoPositions;

impl Integrator for TwoPositions {
    const METHOD: Method = Method::VelocityVerlet;
    const STATE: MethodStateKind = MethodStateKind::LastAcceleration;

    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        step_state: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let h = field.step();
        let a = field.acceleration(0.0, x, v);
        let before = match step_state.start {
            Some(before) => before,
            None => x - v * h + a * (h * h * 0.5),
        };
        step_state.start = Some(x);
        let next = x + x - before + a * (h * h);
        (next, (next - x) * (1.0 / h))
    }
}

/// Every broken method and the check that has to reject it.
pub fn all() -> Vec<(Stepper, Checked)> {
    vec![
        PositionFirst::mutant("semi-implicit Euler, order swapped", FINGERPRINT),
        VelocityFirst::mutant("explicit Euler, order swapped", FINGERPRINT),
        ReadAfterMove::mutant("explicit Euler, acceleration after the move", FINGERPRINT),
        Undamped::mutant("semi-implicit Euler, exact damping left out", DECAY),
        DampedBefore::mutant(
            "semi-implicit Euler, tutorial's damping before the move",
            TERMINAL_SPEED,
        ),
        DampedAfter::mutant("semi-implicit Euler, clamped damping after the move", TERMINAL_SPEED),
        DampedTwice::mutant("semi-implicit Euler, damped twice", MULTIPLIERS),
        DampedByStage::mutant("Runge-Kutta 4, damped at every stage", MULTIPLIERS),
        FrozenImplicit::mutant("implicit Euler, forces of the start", FINGERPRINT),
        Unsolved::mutant("implicit Euler, one iteration", FINGERPRINT),
        FrozenMidpoint::mutant("midpoint, forces of the start", FINGERPRINT),
        FrozenHeun::mutant("Heun, forces of the start", FINGERPRINT),
        FrozenKutta::mutant("Runge-Kutta 4, forces of the start", FINGERPRINT),
        FrozenVerlet::mutant("velocity Verlet, forces of the start", FINGERPRINT),
        EqualWeights::mutant("Runge-Kutta 4, equal weights", FINGERPRINT),
        StagesAtStart::mutant("Runge-Kutta 4, stages at the start", ORDERS),
        LastStageEarly::mutant("Runge-Kutta 4, last stage early", ORDERS),
        MidpointAtStart::mutant("midpoint, stage at the start", ORDERS),
        MidpointAtEnd::mutant("midpoint, stage at the end", ORDERS),
        HeunAtStart::mutant("Heun, stage at the start", ORDERS),
        HeunWithoutMean::mutant("Heun, slope of the end", FINGERPRINT),
        PushedByStage::mutant("Runge-Kutta 4, pushed at every stage", PUSH),
        PushedOnce::mutant("Runge-Kutta 4, pushed at one stage", PUSH),
        EndAtStart::mutant("velocity Verlet, end at the start", ORDERS),
        LaggedDrag::mutant("velocity Verlet, drag of the start", ORDERS),
        HalfKickedDrag::mutant("velocity Verlet, drag of half a kick", ORDERS),
        PushKept::mutant("velocity Verlet, push kept", PUSH),
        NoTaylorStart::mutant("position Verlet, no Taylor start", FINGERPRINT),
        FromOrigin::mutant("position Verlet, from the origin", START),
        (Stepper::of::<TwoPositions>("position Verlet, of two positions"), FAR_AWAY),
        NoRatio::mutant("position Verlet, no ratio of steps", CHANGING_STEPS),
        HalfRatio::mutant("position Verlet, half the ratio", CHANGING_STEPS),
        EqualParts::mutant("Yoshida 4, equal parts", FINGERPRINT),
        InnerTimes::mutant("Yoshida 4, times of the start", ORDERS),
        NoStepBack::mutant("Yoshida 4, no step back", FINGERPRINT),
    ]
}
