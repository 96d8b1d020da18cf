//! The two explicit Eulers of the tutorial, compositions of one kick and one drift.

use bevy_ecs::prelude::*;

use super::{Field, Integrator, StepState};
use crate::methods::markers::OwnMethod;
use crate::methods::table::{Claims, IN_STEP, Method, of_order};

/// Explicit Euler (Euler 1768): `x += v h; v += a(x, v) h`, both from the state at the start of the step. Order 1. The
/// energy grows in every oscillation.
///
/// With `exact` damping the velocity under a constant acceleration is exact at every step size; the position has an
/// error of a h T / 2 after the time T, as without damping.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct ExplicitEuler;

/// Semi-implicit Euler (de Vogelaere 1956; Hairer, Lubich, Wanner 2003, "symplectic Euler"):
/// `v += a(x, v) h; x += v h`, the velocity first, then the position with the new velocity. Order 1; conserves an
/// energy near the true one.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct SemiImplicitEuler;

/// The velocity half of an Euler step, the tutorial's `IntegrateAccel`: `v += a(x, v) h`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Kick;

/// The position half of an Euler step, the tutorial's `IntegrateVelocity`: `x += v h`, with damping, speed limit and
/// locks before it or damping after it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Drift;

impl ExplicitEuler {
    /// The claims of the method.
    pub(super) const CLAIMS: Claims = Claims {
        name: "explicit_euler",
        title: "explicit Euler",
        damping: IN_STEP,
        source: "Euler 1768",
        ..of_order(Method::ExplicitEuler, 1)
    };
}

impl Integrator for ExplicitEuler {
    const METHOD: Method = Method::ExplicitEuler;
    const DAMPS_INSIDE: bool = true;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        _: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        // Evaluated before the drift: at the new position it would be another method.
        let a = field.acceleration(0.0, x, v);
        let (x, v) = drift(field, x, v);
        (x, field.kick(v, a))
    }
}

impl SemiImplicitEuler {
    /// The claims of the method.
    pub(super) const CLAIMS: Claims = Claims {
        name: "semi_implicit_euler",
        title: "semi-implicit Euler",
        stability_limit: 2.0,
        symplectic: true,
        damping: IN_STEP,
        source: "de Vogelaere 1956; Hairer, Lubich, Wanner 2003",
        ..of_order(Method::SemiImplicitEuler, 1)
    };
}

impl Integrator for SemiImplicitEuler {
    const METHOD: Method = Method::SemiImplicitEuler;
    const DAMPS_INSIDE: bool = true;
    const MOVES_WITH_NEW_VELOCITY: bool = true;
    const LIMITS_AFTER_KICK: bool = true;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        _: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let a = field.acceleration(0.0, x, v);
        let v = field.kick(v, a);
        drift(field, x, v)
    }
}

impl Integrator for Kick {
    const METHOD: Method = Method::SemiImplicitEuler;
    const DAMPS_INSIDE: bool = true;
    const MOVES: bool = false;
    const LIMITS_AFTER_KICK: bool = true;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        _: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let a = field.acceleration(0.0, x, v);
        (x, field.kick(v, a))
    }
}

impl Integrator for Drift {
    const METHOD: Method = Method::SemiImplicitEuler;
    const DAMPS_INSIDE: bool = true;
    const KICKS: bool = false;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        _: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        drift(field, x, v)
    }
}

/// The state after a move with the velocity `v`.
#[inline(always)]
fn drift<F: Field>(field: &mut F, x: F::Space, v: F::Space) -> (F::Space, F::Space) {
    let v = field.before_move(v);
    (x + v * field.step(), field.after_move(v))
}
