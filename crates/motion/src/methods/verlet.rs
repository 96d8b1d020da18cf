//! Position Verlet and velocity Verlet.

use bevy_ecs::prelude::*;

use super::{Field, Integrator, MethodStateKind, StepState};
use crate::methods::markers::OwnMethod;
use crate::methods::table::{Claims, Method, of_order};
use crate::state::method_state::LastStep;

/// Position Verlet (Stormer 1907; Verlet 1967): `x1 = 2 x - x0 + a h²`, in the increment form
/// `d1 = d + a h²; x1 = x + d1`, which has no cancellation. Order 2 in the position.
///
/// The velocity of a body is d / h, the mean velocity of the last step. It is half a step behind the position and of
/// order 1. A law that depends on the velocity makes the position order 1 too.
///
/// A step of length h after one of a different length p adds `a h (h + p) / 2` instead of `a h²`. At a start p is 0, which
/// gives a h² / 2, the Taylor value. After a reversal of velocities p is -h: the body returns along its path.
///
/// Applied forces are constant over the tick and are solved exactly: `F w h²/2` for the position, `F w h` for the
/// velocity.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod, LastStep)]
pub struct PositionVerlet;

/// Velocity Verlet (Swope et al. 1982): kick, drift, kick. Order 2; conserves an energy near the true one. One
/// evaluation per step, because the last evaluation of a step is the first of the next.
///
/// Laws that depend on the velocity are evaluated at the end with the predicted velocity `v + a h` (Groot, Warren 1997,
/// lambda = 1), which keeps order 2 and takes two evaluations per step.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct VelocityVerlet;

impl PositionVerlet {
    /// The claims of the method.
    pub(super) const CLAIMS: Claims = Claims {
        name: "position_verlet",
        title: "position Verlet",
        position_order: 2,
        stability_limit: 2.0,
        symplectic: true,
        reversible: true,
        source: "Stormer 1907; Verlet 1967",
        ..of_order(Method::PositionVerlet, 1)
    };
}

impl Integrator for PositionVerlet {
    const METHOD: Method = Method::PositionVerlet;
    const STATE: MethodStateKind = MethodStateKind::LastStep;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        step_state: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let (h, half) = (field.step(), 0.5);
        let last = step_state.last_step;
        let a = field.laws(0.0, x, v);
        let v = match field.laws_before_jump(x, v) {
            Some(before) => v + (before * last + a * h) * half,
            None => v + a * (half * (h + last)),
        };
        let applied = field.applied();
        step_state.last_step = h;
        (x + (v + applied * (half * h)) * h, v + applied * h)
    }
}

impl VelocityVerlet {
    /// The claims of the method.
    pub(super) const CLAIMS: Claims = Claims {
        name: "velocity_verlet",
        title: "velocity Verlet",
        evaluations: 1,
        start_up_evaluations: 1,
        stability_limit: 2.0,
        symplectic: true,
        reversible: true,
        source: "Swope et al. 1982; predicted velocity: Groot, Warren 1997, lambda = 1",
        ..of_order(Method::VelocityVerlet, 2)
    };
}

impl Integrator for VelocityVerlet {
    const METHOD: Method = Method::VelocityVerlet;
    const STATE: MethodStateKind = MethodStateKind::LastAcceleration;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        step_state: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let h = field.step();
        kick_drift_kick(field, 0.0, h, x, v, step_state)
    }
}

/// A step of velocity Verlet of `h` seconds within the field's step, starting at the fraction `part`.
#[inline(always)]
pub(super) fn kick_drift_kick<F: Field>(
    field: &mut F,
    part: f64,
    h: f64,
    x: F::Space,
    v: F::Space,
    step_state: &mut StepState<F>,
) -> (F::Space, F::Space) {
    let half = h * 0.5;
    let start = match step_state.start {
        Some(start) => start,
        None => field.laws(part, x, v),
    };
    let a = field.plus_applied(start);
    let x = x + (v + a * half) * h;
    if field.is_constant() {
        return (x, v + a * h);
    }
    // Exactly 1 at the end of the step, where the sum of fractions may have a rounding error.
    let end = part + h / field.step();
    let end = if (end - 1.0).abs() <= 4.0 * f64::EPSILON { 1.0 } else { end };
    let b = field.laws(end, x, v + a * h);
    step_state.start = if field.depends_on_velocity() { None } else { Some(b) };
    (x, v + (a + field.plus_applied(b)) * half)
}

/// Advances the velocity of position Verlet by half a step to the time of the position, so that another method can
/// start.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Synchronize;

impl Integrator for Synchronize {
    const METHOD: Method = Method::PositionVerlet;
    const STATE: MethodStateKind = MethodStateKind::LastStep;
    const MOVES: bool = false;
    const PASSES_TIME: bool = false;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        step_state: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let a = match field.laws_before_jump(x, v) {
            Some(before) => before,
            None => field.laws(0.0, x, v),
        };
        let last_step = std::mem::replace(&mut step_state.last_step, 0.0);
        (x, v + a * (last_step * 0.5))
    }
}
