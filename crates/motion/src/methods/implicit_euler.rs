//! Implicit Euler, solved.

use bevy_ecs::prelude::*;

use super::{Carry, Field, Integrator, NewtonField};
use crate::methods::markers::OwnMethod;
use crate::methods::table::Method;
use crate::real::Real;

/// `v1 = v + a(x1, v1) h; x1 = x + v1 h`: the acceleration at the end of the step, which has to be solved for
/// (Curtiss, Hirschfelder 1952): order 1, stable at every step, and damps what it keeps stable: an oscillation
/// loses w h / 2 of critical damping.
///
/// With constant forces and linear drag c the step has a closed form, `v1 = v + a(v) h / (1 + c h)`. Otherwise
/// Newton's method with the Jacobians of the laws finds v1 to [`ImplicitEuler::tolerance`]; a step that does not
/// get there in [`MOST_ITERATIONS`] keeps the last v1, and is reported. Bodies that act on each other are solved
/// as [`Solver`](crate::Solver) says.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct ImplicitEuler;

/// Newton iterations after which a step is given up.
pub const MOST_ITERATIONS: u32 = 50;

/// How often a correction that makes things worse is halved.
const MOST_HALVINGS: u32 = 8;

/// Account of an implicit solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Newton {
    /// Iterations taken.
    pub iterations: u32,
    /// Whether the last correction was below the tolerance.
    pub converged: bool,
}

impl ImplicitEuler {
    /// Size of a correction of v1, relative to `|v1| + |a| h`, below which a solve has converged. Newton's
    /// iteration converges quadratically: after a correction a little below the square root of the rounding unit
    /// the next one would be rounding. A correction that would not move the body by a rounding of its position
    /// will do as well, or a body at rest, whose forces only cancel, would never get there.
    #[must_use]
    pub fn tolerance<T: Real>() -> T {
        T::EPSILON.sqrt() * T::of(1e-4) + T::EPSILON * T::of(4.0)
    }
}

impl Integrator for ImplicitEuler {
    const METHOD: Method = Method::ImplicitEuler;
    const SOLVES: bool = true;

    #[inline(always)]
    fn step<F: Field>(field: &mut F, x: F::Space, v: F::Space, _: &mut Carry<F>) -> (F::Space, F::Space) {
        let v1 = field.implicit_velocity(x, v);
        (x + v1 * field.step(), v1)
    }
}

/// [`Field::implicit_velocity`] of one body.
#[inline(always)]
pub fn newton_velocity<F: NewtonField>(field: &mut F, x: F::Space, v: F::Space) -> F::Space {
    let (h, end) = (field.step(), F::Real::ONE);
    match field.linear_rate() {
        Some(rate) => v + field.acceleration(end, x, v) * (h / (F::Real::ONE + rate * h)),
        None => solve(field, x, v),
    }
}

/// The v1 of `v1 = v + a(x + v1 h, v1) h`, sought from v on.
fn solve<F: NewtonField>(field: &mut F, x: F::Space, v: F::Space) -> F::Space {
    let (h, end) = (field.step(), F::Real::ONE);
    let half = F::Real::of(0.5);
    let mut v1 = v;
    let mut a = field.acceleration(end, x + v1 * h, v1);
    let mut residual = v + a * h - v1;
    for iterations in 1..=MOST_ITERATIONS {
        let mut correction = field.correction(x + v1 * h, v1, residual);
        let small = |field: &F, correction, v1, a| {
            let size = field.size(correction);
            size <= ImplicitEuler::tolerance::<F::Real>() * (field.size(v1) + field.size(a) * h)
                || size * h <= F::Real::EPSILON * field.size(x)
        };
        if small(field, correction, v1, a) {
            field.report(Newton { iterations, converged: true });
            return v1 + correction;
        }
        // Full steps where they help, shorter ones where the law bends away (Deuflhard 1974).
        let before = field.size(residual);
        for halving in 0..=MOST_HALVINGS {
            let tried = v1 + correction;
            let tried_a = field.acceleration(end, x + tried * h, tried);
            let tried_residual = v + tried_a * h - tried;
            if field.size(tried_residual) <= before || halving == MOST_HALVINGS {
                (v1, a, residual) = (tried, tried_a, tried_residual);
                break;
            }
            correction = correction * half;
        }
    }
    field.report(Newton { iterations: MOST_ITERATIONS, converged: false });
    v1
}
