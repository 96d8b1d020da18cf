//! The two Verlets.

use bevy_ecs::prelude::*;

use super::{Carry, Field, Integrator, Memory};
use crate::methods::markers::OwnMethod;
use crate::methods::table::Method;
use crate::real::Real;
use crate::state::method_state::LastStep;

/// Positions from positions (Stormer 1907; Verlet 1967): `x1 = 2 x - x0 + a h²`, in increment form
/// `d1 = d + a h²; x1 = x + d1`, which loses nothing to cancellation.
///
/// The velocity of a body is d / h: the mean velocity of the last step, half a step behind, so of order 1 where
/// the position is of order 2; a law of the velocity sees it lag, and makes everything order 1.
///
/// A step of another length than the last one, p, takes `a h (h + p) / 2` in place of `a h²`. A start is a step
/// after one of no length, which makes that a h² / 2: the Taylor value. Velocities turned round are a step
/// after one of length -h: a body goes back the way it came.
///
/// Applied forces are constant over the tick and have an exact solution: `F w h²/2` for the position, `F w h`
/// for the velocity.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod, LastStep)]
pub struct PositionVerlet;

/// Kick, drift, kick (Swope et al. 1982): order 2, keeps a nearby energy; one evaluation a step, because the
/// one at the end is the next step's at the start.
///
/// Under laws of the velocity the end is evaluated at the predicted velocity `v + a h` (Groot, Warren 1997,
/// lambda = 1), which keeps order 2 and takes two evaluations a step.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct VelocityVerlet;

impl Integrator for PositionVerlet {
    const METHOD: Method = Method::PositionVerlet;
    const MEMORY: Memory = Memory::LastStep;

    #[inline(always)]
    fn step<F: Field>(field: &mut F, x: F::Space, v: F::Space, carry: &mut Carry<F>) -> (F::Space, F::Space) {
        let (h, half) = (field.step(), F::Real::of(0.5));
        let last = carry.last_step;
        let a = field.laws(F::Real::ZERO, x, v);
        let v = match field.laws_before_jump(x, v) {
            Some(before) => v + (before * last + a * h) * half,
            None => v + a * (half * (h + last)),
        };
        let applied = field.applied();
        carry.last_step = h;
        (x + (v + applied * (half * h)) * h, v + applied * h)
    }
}

impl Integrator for VelocityVerlet {
    const METHOD: Method = Method::VelocityVerlet;
    const MEMORY: Memory = Memory::LastAcceleration;

    #[inline(always)]
    fn step<F: Field>(field: &mut F, x: F::Space, v: F::Space, carry: &mut Carry<F>) -> (F::Space, F::Space) {
        let h = field.step();
        kick_drift_kick(field, F::Real::ZERO, h, x, v, carry)
    }
}

/// A step of velocity Verlet over a part of the field's step, from the fraction `part` on and `h` seconds long.
#[inline(always)]
pub(super) fn kick_drift_kick<F: Field>(
    field: &mut F,
    part: F::Real,
    h: F::Real,
    x: F::Space,
    v: F::Space,
    carry: &mut Carry<F>,
) -> (F::Space, F::Space) {
    let half = h * F::Real::of(0.5);
    let start = match carry.start {
        Some(start) => start,
        None => field.laws(part, x, v),
    };
    let applied = field.applied();
    let a = start + applied;
    let x = x + (v + a * half) * h;
    if field.is_constant() {
        return (x, v + a * h);
    }
    // At the end of the step exactly, whatever rounding a sum of fractions would leave.
    let end = part + h / field.step();
    let end =
        if (end - F::Real::ONE).abs() <= F::Real::of(4.0) * F::Real::EPSILON { F::Real::ONE } else { end };
    let b = field.laws(end, x, v + a * h);
    carry.start = if field.depends_on_velocity() { None } else { Some(b) };
    (x, v + (a + (b + applied)) * half)
}

/// Position Verlet's velocity brought from half a step ago to the time of the position: what another method starts from.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Synchronize;

impl Integrator for Synchronize {
    const METHOD: Method = Method::PositionVerlet;
    const MEMORY: Memory = Memory::LastStep;
    const MOVES: bool = false;
    const PASSES_TIME: bool = false;

    #[inline(always)]
    fn step<F: Field>(field: &mut F, x: F::Space, v: F::Space, carry: &mut Carry<F>) -> (F::Space, F::Space) {
        let a = match field.laws_before_jump(x, v) {
            Some(before) => before,
            None => field.laws(F::Real::ZERO, x, v),
        };
        let last_step = std::mem::replace(&mut carry.last_step, F::Real::ZERO);
        (x, v + a * (last_step * F::Real::of(0.5)))
    }
}
