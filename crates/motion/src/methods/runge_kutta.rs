//! Explicit Runge-Kutta methods on `x' = v, v' = a(t, x, v)`.

use bevy_ecs::prelude::*;

use super::{Field, Integrator, StepState};
use crate::methods::markers::OwnMethod;
use crate::methods::table::{Claims, Method, of_order};

/// Runge-Kutta 2, midpoint (Runge 1895): explicit Euler to the middle of the step, whose slopes then serve the whole
/// step. Order 2. An oscillation gains z^4 / 4 of its energy per step, z = w h.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct RungeKutta2Midpoint;

/// Runge-Kutta 2, Heun (Heun 1900): the mean of the slopes at the start and at the end of an explicit Euler step. Order
/// 2. Energy grows as with the midpoint rule.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct RungeKutta2Heun;

/// Runge-Kutta 4 (Kutta 1901): the classic method of four stages, weighted 1, 2, 2, 1. Order 4. An oscillation loses
/// z^6 / 72 of its energy per step, z = w h.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(OwnMethod)]
pub struct RungeKutta4;

impl RungeKutta2Midpoint {
    /// The claims of the method.
    pub(super) const CLAIMS: Claims = Claims {
        name: "runge_kutta_2_midpoint",
        title: "Runge-Kutta 2, midpoint",
        source: "Runge 1895",
        ..of_order(Method::RungeKutta2Midpoint, 2)
    };
}

impl Integrator for RungeKutta2Midpoint {
    const METHOD: Method = Method::RungeKutta2Midpoint;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        _: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let (h, half) = (field.step(), 0.5);
        let a = field.acceleration(0.0, x, v);
        let middle = v + a * (half * h);
        let a = field.acceleration(half, x + v * (half * h), middle);
        (x + middle * h, v + a * h)
    }
}

impl RungeKutta2Heun {
    /// The claims of the method.
    pub(super) const CLAIMS: Claims = Claims {
        name: "runge_kutta_2_heun",
        title: "Runge-Kutta 2, Heun",
        source: "Heun 1900",
        ..of_order(Method::RungeKutta2Heun, 2)
    };
}

impl Integrator for RungeKutta2Heun {
    const METHOD: Method = Method::RungeKutta2Heun;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        _: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let h = field.step();
        let half = h * 0.5;
        let a = field.acceleration(0.0, x, v);
        let end = v + a * h;
        let b = field.acceleration(1.0, x + v * h, end);
        (x + (v + end) * half, v + (a + b) * half)
    }
}

impl RungeKutta4 {
    /// The claims of the method.
    pub(super) const CLAIMS: Claims = Claims {
        name: "runge_kutta_4",
        title: "Runge-Kutta 4",
        stability_limit: 2.0 * std::f64::consts::SQRT_2,
        source: "Kutta 1901",
        ..of_order(Method::RungeKutta4, 4)
    };
}

impl Integrator for RungeKutta4 {
    const METHOD: Method = Method::RungeKutta4;

    #[inline(always)]
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        _: &mut StepState<F>,
    ) -> (F::Space, F::Space) {
        let (h, middle) = (field.step(), 0.5);
        let (half, sixth) = (h * middle, h * (1.0 / 6.0));
        // The slopes of the position are the velocities of the stages, each v plus an acceleration times a time: their
        // weighted sum needs no more than the accelerations.
        let a1 = field.acceleration(0.0, x, v);
        let v2 = v + a1 * half;
        let a2 = field.acceleration(middle, x + v * half, v2);
        let v3 = v + a2 * half;
        let a3 = field.acceleration(middle, x + v2 * half, v3);
        let v4 = v + a3 * h;
        let a4 = field.acceleration(1.0, x + v3 * h, v4);
        let inner = a2 + a3;
        let sum = a1 + inner;
        (x + (v + sum * sixth) * h, v + (sum + inner + a4) * sixth)
    }
}
