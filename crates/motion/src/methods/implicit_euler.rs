//! Implicit Euler and its Newton iteration.

use bevy_ecs::prelude::*;

use super::{Field, Integrator, NewtonField, StepState};
use crate::methods::markers::OwnMethod;
use crate::methods::table::{Claims, Method, of_order};

/// Implicit Euler: `v1 = v + a(x1, v1) h; x1 = x + v1 h` (Curtiss, Hirschfelder 1952). Order 1, stable at every step
/// size for linear attractive forces and drag. The acceleration is that at the end of the step, so that each step solves
/// an equation. Oscillations are damped with a damping ratio of w h / 2.
///
/// With constant forces and linear drag c the step has a closed form, `v1 = v + a(v) h / (1 + c h)`. Otherwise Newton's
/// method with the Jacobians of the laws finds v1 to [`ImplicitEuler::tolerance`]. A step that does not converge in
/// [`MOST_ITERATIONS`] keeps the last v1 and is reported. Bodies in groups are solved together, by conjugate gradients.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct ImplicitEuler;

/// Largest number of Newton iterations per step.
pub const MOST_ITERATIONS: u32 = 50;

/// Largest number of times that a correction which increases the residual is halved.
pub(crate) const MOST_HALVINGS: u32 = 8;

/// Result of an implicit solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Newton {
    /// Number of iterations.
    pub iterations: u32,
    /// Whether the last correction was below the tolerance.
    pub converged: bool,
}

impl ImplicitEuler {
    /// Tolerance of the solve: a step has converged when the correction of v1, relative to `|v1| + |a| h`, is below it.
    /// Newton's iteration converges quadratically: after a correction of 1e-4 times the square root of the machine
    /// epsilon, the next one is below rounding.
    ///
    /// A correction that moves the body by less than the rounding of its position also counts as converged: a body at
    /// rest, whose forces cancel, would otherwise never converge.
    #[must_use]
    pub fn tolerance() -> f64 {
        f64::EPSILON.sqrt() * 1e-4 + f64::EPSILON * 4.0
    }
}

impl ImplicitEuler {
    /// The claims of the method.
    pub(super) const CLAIMS: Claims = Claims {
        name: "implicit_euler",
        title: "implicit Euler",
        stability_limit: f64::INFINITY,
        source: "Curtiss, Hirschfelder 1952",
        ..of_order(Method::ImplicitEuler, 1)
    };
}

impl Integrator for ImplicitEuler {
    const METHOD: Method = Method::ImplicitEuler;
    const SOLVES: bool = true;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        _: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let v1 = field.implicit_velocity(x, v);
        (x + v1 * field.step(), v1)
    }
}

/// Solves an implicit step of one body: [`Field::implicit_velocity`] by Newton's method.
#[inline(always)]
pub fn newton_velocity<F: NewtonField>(field: &mut F, x: F::Space, v: F::Space) -> F::Space {
    let (h, end) = (field.step(), 1.0);
    match field.linear_rate() {
        Some(rate) => v + field.acceleration(end, x, v) * (h / (1.0 + rate * h)),
        None => solve(field, x, v),
    }
}

/// Solves `v1 = v + a(x + v1 h, v1) h` for v1, starting at v.
fn solve<F: NewtonField>(field: &mut F, x: F::Space, v: F::Space) -> F::Space {
    let (h, end) = (field.step(), 1.0);
    let mut v1 = v;
    let mut a = field.acceleration(end, x + v1 * h, v1);
    let mut residual = v + a * h - v1;
    for iterations in 1..=MOST_ITERATIONS {
        let mut correction = field.correction(x + v1 * h, v1, residual);
        let small = |field: &F, correction, v1, a| {
            let size = field.size(correction);
            size <= ImplicitEuler::tolerance() * (field.size(v1) + field.size(a) * h)
                || size * h <= f64::EPSILON * field.size(x)
        };
        if small(field, correction, v1, a) {
            field.report(Newton { iterations, converged: true });
            return v1 + correction;
        }
        // Full corrections where they reduce the residual, halved ones elsewhere (Deuflhard 1974).
        let before = field.size(residual);
        for halving in 0..=MOST_HALVINGS {
            let tried = v1 + correction;
            let tried_a = field.acceleration(end, x + tried * h, tried);
            let tried_residual = v + tried_a * h - tried;
            if field.size(tried_residual) <= before || halving == MOST_HALVINGS {
                (v1, a, residual) = (tried, tried_a, tried_residual);
                break;
            }
            correction = correction * 0.5;
        }
    }
    field.report(Newton { iterations: MOST_ITERATIONS, converged: false });
    v1
}
