//! The exact discrete solutions of `x'' = -w² x`: what a method does in exact arithmetic, after any number of
//! steps.

use glam::DVec3;
use motion::Method;

use super::fingerprint::{exact, yoshida_sixth};
use super::laws::Spring;
use super::problems::ACROSS;
use super::{Check, SKEW, Stepper, all_pass, position, velocity, within};
use crate::rigs::Matrix;

/// Modulus and angle of R(-i z), the factor of `w x + i v`, for the methods that have one.
fn factor(method: Method, z: f64) -> Option<(f64, f64)> {
    let z2 = z * z;
    // Of the modulus the logarithm, from what it exceeds 1 by.
    match method {
        Method::ExplicitEuler => Some((z2.ln_1p() / 2.0, -z.atan())),
        Method::ImplicitEuler => Some((-z2.ln_1p() / 2.0, -z.atan())),
        Method::RungeKutta2Midpoint | Method::RungeKutta2Heun => {
            Some(((z2 * z2 / 4.0).ln_1p() / 2.0, -z.atan2(1.0 - z2 / 2.0)))
        }
        Method::RungeKutta4 => {
            let gain = -z2 * z2 * z2 / 72.0 + z2 * z2 * z2 * z2 / 576.0;
            Some((gain.ln_1p() / 2.0, -(z - z * z2 / 6.0).atan2(1.0 - z2 / 2.0 + z2 * z2 / 24.0)))
        }
        _ => None,
    }
}

/// The `n`th power of a matrix of determinant 1 whose half trace is `1 - s`: a rotation in skew coordinates.
fn power(m: Matrix, s: f64, n: f64) -> Matrix {
    let (angle, cos, sin) = (2.0 * (s / 2.0).sqrt().asin(), 1.0 - s, (s * (2.0 - s)).sqrt());
    let (sin_n, cos_n) = (n * angle).sin_cos();
    let turn = |entry: f64| entry * (sin_n / sin);
    [[cos_n + turn(m[0][0] - cos), turn(m[0][1])], [turn(m[1][0]), cos_n + turn(m[1][1] - cos)]]
}

/// The matrix of `n` steps on (w x, v).
pub fn after(method: Method, z: f64, n: u32) -> Matrix {
    let steps = f64::from(n);
    if let Some((growth, angle)) = factor(method, z) {
        let (sin, cos) = (steps * angle).sin_cos();
        let modulus = (steps * growth).exp();
        return [[modulus * cos, -modulus * sin], [modulus * sin, modulus * cos]];
    }
    let z2 = z * z;
    let m = exact(method, z);
    match method {
        Method::Yoshida4 => {
            power(m, z2 / 2.0 - z2 * z2 / 24.0 - yoshida_sixth() * z2 * z2 * z2, steps)
        }
        Method::PositionVerlet => {
            // The first step is the Taylor start; its velocity is the mean one over the step.
            let start = [[1.0 - z2 / 2.0, z], [-z / 2.0, 1.0]];
            let rest = power(m, z2 / 2.0, steps - 1.0);
            [0, 1].map(|i| [0, 1].map(|j| rest[i][0] * start[0][j] + rest[i][1] * start[1][j]))
        }
        _ => power(m, z2 / 2.0, steps),
    }
}

/// Images of a pair of vectors.
pub fn image(m: Matrix, [a, b]: [DVec3; 2]) -> [DVec3; 2] {
    m.map(|row| a * row[0] + b * row[1])
}

/// 10,000 steps lead to the exact discrete state.
pub(super) fn check(stepper: &Stepper) -> Check {
    let coarse = if stepper.claims().symplectic { 1.0 } else { 0.3 };
    for z in [0.05, 0.15, coarse] {
        let start = [SKEW, ACROSS * 0.7];
        let mut bare = stepper.bare(z / 2.0).with_law(Spring(8.0));
        bare.add((start[0] / 2.0).to_array(), (start[1]).to_array(), 0.5);
        stepper.run(&mut bare, 10_000);
        let exact = image(after(stepper.method, z, 10_000), start);
        let got = [position(&bare, 0) * 2.0, velocity(&bare, 0)];
        // The largest component: squares of what explicit Euler has grown to overflow.
        let largest =
            |pair: [DVec3; 2]| pair[0].abs().max_element().max(pair[1].abs().max_element());
        let error = largest([got[0] - exact[0], got[1] - exact[1]]) / largest(exact);
        within(|| format!("z = {z}"), error, 1e-11)?;
    }
    Ok(())
}

#[test]
fn ten_thousand_steps_are_the_exact_discrete_solution() {
    all_pass(check);
}
