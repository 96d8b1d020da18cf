//! One step of `x'' = -w² x`: four numbers that tell the methods apart, and from which stability, symplecticity
//! and damping follow.

use motion::Method;

use super::laws::Spring;
use super::{Check, SKEW, Stepper, all_pass, position, velocity, within};
use crate::rigs::{Matrix, step_matrix, yoshida_steps};

/// The matrix of a step of `x'' = -x`. Rows and columns are (w x, v).
pub fn exact(method: Method, z: f64) -> Matrix {
    step_matrix(method, z, [1.0, 0.0])
}

/// The coefficient of z⁶ in half the trace of Yoshida's matrix, the three multiplied out by hand; the lower
/// ones are those of the cosine.
pub fn yoshida_sixth() -> f64 {
    let (outer, inner) = yoshida_steps();
    let (o2, i2) = (outer * outer, inner * inner);
    -i2 * o2 * o2 / 4.0 - o2 * outer * inner * (i2 + o2) / 8.0
}

/// Terms that add up to the trace, and those of the determinant.
fn trace_and_determinant(method: Method, z: f64) -> (Vec<f64>, Vec<f64>) {
    let z2 = z * z;
    let (z4, z6, z8) = (z2 * z2, z2 * z2 * z2, z2 * z2 * z2 * z2);
    match method {
        Method::ExplicitEuler => (vec![2.0], vec![1.0, z2]),
        Method::ImplicitEuler => (vec![2.0 / (1.0 + z2)], vec![1.0 / (1.0 + z2)]),
        Method::SemiImplicitEuler | Method::PositionVerlet | Method::VelocityVerlet => {
            (vec![2.0, -z2], vec![1.0])
        }
        Method::RungeKutta2Midpoint | Method::RungeKutta2Heun => {
            (vec![2.0, -z2], vec![1.0, z4 / 4.0])
        }
        Method::RungeKutta4 => (vec![2.0, -z2, z4 / 12.0], vec![1.0, -z6 / 72.0, z8 / 576.0]),
        Method::Yoshida4 => (vec![2.0, -z2, z4 / 12.0, 2.0 * yoshida_sixth() * z6], vec![1.0]),
    }
}

/// Images of (1, 0) and (0, 1) after one step of `z / 2` seconds, w = 2; `run` continues from x and v for some ticks.
pub fn matrix(method: Method, z: f64, run: impl Fn([f64; 2], u32) -> [f64; 2]) -> Matrix {
    let column = |start: [f64; 2]| {
        let (mut state, mut ticks) = (start, 1);
        if method == Method::PositionVerlet {
            // Its first step has a Taylor start: the state from which that leads to the one asked for.
            let before = start[0] - z * start[1];
            (state, ticks) = ([before, start[1] + z / 2.0 * before], 2);
        }
        let [x, v] = run([state[0] / 2.0, state[1]], ticks);
        [x * 2.0, v]
    };
    let (a, b) = (column([1.0, 0.0]), column([0.0, 1.0]));
    [[a[0], b[0]], [a[1], b[1]]]
}

/// The matrix along a skew axis, of a body of 2 kg.
fn measured(stepper: &Stepper, z: f64) -> Matrix {
    matrix(stepper.method, z, |[x, v], ticks| {
        let mut bare = stepper.bare(z / 2.0).with_law(Spring(8.0));
        bare.add((SKEW * x).to_array(), (SKEW * v).to_array(), 0.5);
        stepper.run(&mut bare, ticks);
        [position(&bare, 0).dot(SKEW), velocity(&bare, 0).dot(SKEW)]
    })
}

pub fn trace(m: Matrix) -> f64 {
    m[0][0] + m[1][1]
}

pub fn determinant(m: Matrix) -> f64 {
    m[0][0] * m[1][1] - m[0][1] * m[1][0]
}

fn largest(terms: impl IntoIterator<Item = f64>) -> f64 {
    terms.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// Magnitude of the terms that an entry is the sum of.
pub fn terms(method: Method, z: f64) -> f64 {
    let most = |z: f64| largest([1.0, z, z * z, z * z * z / 4.0]);
    match method {
        Method::RungeKutta4 => {
            largest([1.0, z * z / 2.0, z, z * z * z / 6.0, z * z * z * z / 24.0])
        }
        Method::Yoshida4 => {
            let (outer, inner) = yoshida_steps();
            most(outer * z) * most(outer * z) * most(inner * z)
        }
        _ => most(z),
    }
}

/// The matrix of a step is the exact one.
pub(super) fn check(stepper: &Stepper) -> Check {
    let bound = 8.0 * f64::EPSILON;
    for z in [0.1, 0.5, 1.0, 1.7, 2.5] {
        let (m, exact) = (measured(stepper, z), exact(stepper.method, z));
        let scale = terms(stepper.method, z);
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let what = || format!("entry {i}{j} at z = {z}");
            within(what, (m[i][j] - exact[i][j]).abs(), bound * scale)?;
        }
        let (of_trace, of_determinant) = trace_and_determinant(stepper.method, z);
        let error = (trace(m) - of_trace.iter().sum::<f64>()).abs();
        within(|| format!("trace at z = {z}"), error, bound * largest(of_trace).max(scale))?;
        let error = (determinant(m) - of_determinant.iter().sum::<f64>()).abs();
        let entries = largest(m.into_iter().flatten());
        within(
            || format!("determinant at z = {z}"),
            error,
            bound * largest(of_determinant).max(scale * entries),
        )?;
    }
    Ok(())
}

#[test]
fn one_step_is_the_exact_matrix_of_its_method() {
    all_pass(check);
}

/// A spring of k / m = 1e8 at 60 Hz, z = 167: an implicit step leaves 1 / sqrt(1 + z²) of it.
#[test]
fn implicit_euler_puts_a_stiff_spring_out() {
    let (stepper, z) = (Stepper::real(Method::ImplicitEuler), 1e4 / 60.0);
    let (m, exact) = (measured(&stepper, z), exact(Method::ImplicitEuler, z));
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        // The step is v1 h away from x: rounded at the size of either.
        assert!(
            (m[i][j] - exact[i][j]).abs() <= 8.0 * f64::EPSILON,
            "{i}{j}: {} {}",
            m[i][j],
            exact[i][j]
        );
    }
}

#[test]
fn the_exact_matrices_have_the_traces_and_determinants_of_the_table() {
    for method in Method::ALL {
        for z in [0.1, 0.5, 1.0, 1.7, 2.5] {
            let (of_trace, of_determinant) = trace_and_determinant(method, z);
            let m = exact(method, z);
            let bound = 16.0 * f64::EPSILON * terms(method, z);
            assert!((trace(m) - of_trace.iter().sum::<f64>()).abs() <= bound, "{method:?} {z}");
            let bound = bound * largest(m.into_iter().flatten());
            assert!(
                (determinant(m) - of_determinant.iter().sum::<f64>()).abs() <= bound,
                "{method:?} {z}"
            );
        }
    }
}

fn spectral_radius(m: Matrix) -> f64 {
    let (half, determinant) = (trace(m) / 2.0, determinant(m));
    let discriminant = half * half - determinant;
    if discriminant < 0.0 { determinant.sqrt() } else { half.abs() + discriminant.sqrt() }
}

/// RK2 at z = 0.01 grows by z⁴/8 = 1.25e-9 a step: above the rounding of the radius, which this is.
const ROUNDING: f64 = 1e-11;

/// The end of the stable steps from 0 on, by bisection; 0 if none is.
pub fn last_stable(stable: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 0.01);
    while stable(high) {
        (low, high) = (high, high * 1.02);
        if high > 1e4 {
            return f64::INFINITY;
        }
    }
    if low == 0.0 {
        return 0.0;
    }
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if stable(middle) { low = middle } else { high = middle }
    }
    low
}

#[test]
fn stability_limits_are_as_claimed() {
    for stepper in Stepper::all() {
        let stable = |z: f64| spectral_radius(measured(&stepper, z)) <= 1.0 + ROUNDING;
        let (measured, claimed) = (last_stable(stable), stepper.claims().stability_limit);
        if claimed > 0.0 && claimed < f64::INFINITY {
            assert!(
                (measured / claimed - 1.0).abs() <= 0.002,
                "{}: {measured} {claimed}",
                stepper.name
            );
        } else {
            assert_eq!(measured, claimed, "{}", stepper.name);
        }
    }
}

#[test]
fn the_symplectic_methods_keep_areas_and_no_others() {
    for stepper in Stepper::all() {
        for z in [0.1, 0.5, 1.0, 1.5] {
            let m = measured(&stepper, z);
            let bound =
                8.0 * f64::EPSILON * terms(stepper.method, z) * largest(m.into_iter().flatten());
            let kept = (determinant(m) - 1.0).abs() <= bound;
            assert_eq!(kept, stepper.claims().symplectic, "{} {z}", stepper.name);
        }
    }
}
