//! The order of every method on every smooth problem, position and velocity apart.

use glam::DVec3;
use motion::{Claims, Method};

use super::problems::{self, Problem, State};
use super::{Check, SKEW, Stepper, all_pass, position, velocity, within};

/// Largest errors over the samples relative to the largest exact values: never one component, which crosses
/// zeros of its leading error.
pub(super) fn errors(stepper: &Stepper, problem: &Problem, steps: u32) -> [f64; 2] {
    let mut bare = problem.bare(stepper, problem.span / f64::from(steps));
    let start = (problem.exact)(0.0);
    let samples = (1..=problem.samples).map(|sample| {
        stepper.run(&mut bare, steps / problem.samples);
        let exact = (problem.exact)(problem.span * f64::from(sample) / f64::from(problem.samples));
        ((position(&bare, 0), velocity(&bare, 0)), exact)
    });
    relative_errors([(start, start)].into_iter().chain(samples))
}

/// Largest distances of positions and of velocities from the exact ones, relative to the largest exact ones.
pub fn relative_errors(samples: impl Iterator<Item = (State, State)>) -> [f64; 2] {
    let (mut error, mut size) = ([0.0_f64; 2], [0.0_f64; 2]);
    for ((x, v), (exact_x, exact_v)) in samples {
        for (i, (got, exact)) in [(x, exact_x), (v, exact_v)].into_iter().enumerate() {
            // `max` would drop a NaN.
            let distance = got.distance(exact);
            error[i] = if distance <= error[i] { error[i] } else { distance };
            size[i] = size[i].max(exact.length());
        }
    }
    [error[0] / size[0], error[1] / size[1]]
}

/// The claimed orders of position and velocity.
pub fn claimed_orders(claims: &Claims, velocity_laws: bool) -> [u32; 2] {
    if velocity_laws {
        [
            claims.order_with_velocity_laws,
            claims.order_with_velocity_laws.min(claims.velocity_order),
        ]
    } else {
        [claims.position_order, claims.velocity_order]
    }
}

/// The claimed order of position and velocity on this problem; `None` is no error but rounding. An order p
/// takes every polynomial acceleration of degree p - 1 into the velocity and of degree p - 2 into the position.
fn claimed(stepper: &Stepper, problem: &Problem) -> [Option<u32>; 2] {
    let orders = claimed_orders(stepper.claims(), problem.velocity_laws);
    // Position Verlet's velocity is that of half a step before, whatever the acceleration.
    let lags = stepper.method == Method::PositionVerlet;
    let exact = |column: usize| {
        let degree =
            problem.degree.is_some_and(|degree| degree + 2 - column as u32 <= orders[column]);
        degree && !(column == 1 && lags)
    };
    [0, 1].map(|column| (!exact(column)).then_some(orders[column]))
}

/// The most that the roundings of `steps` steps add up to, all going one way.
fn rounding(steps: u32) -> f64 {
    f64::EPSILON / 2.0 * f64::from(steps)
}

/// `log2(E(h) / E(h / 2))` of the finest pair of which rounding is at most 1 %, which is 0.014 in the order.
fn order(stepper: &Stepper, problem: &Problem, column: usize, claimed: u32) -> Result<f64, String> {
    let mut steps = if claimed == 1 {
        1 << 14
    } else if claimed == 2 {
        1 << 12
    } else {
        1 << 11
    };
    let mut fine = errors(stepper, problem, steps)[column];
    while steps > 16 {
        let coarse = errors(stepper, problem, steps / 2)[column];
        if fine >= 100.0 * rounding(steps) {
            return Ok((coarse / fine).log2());
        }
        (fine, steps) = (coarse, steps / 2);
    }
    Err(format!("{}: nothing but rounding", problem.name))
}

/// The orders on one problem are within 0.05 of the claimed ones.
fn check_on(stepper: &Stepper, problem: &Problem) -> Check {
    for (column, claimed) in claimed(stepper, problem).into_iter().enumerate() {
        let what = || format!("{}, {}", problem.name, ["position", "velocity"][column]);
        match claimed {
            Some(claimed) => {
                let fitted = order(stepper, problem, column, claimed)?;
                within(
                    || format!("order {fitted:.3} of {}", what()),
                    (fitted - f64::from(claimed)).abs(),
                    0.05,
                )?;
            }
            None => {
                let error = errors(stepper, problem, 64)[column];
                within(|| format!("exact {}", what()), error, 50.0 * f64::EPSILON)?;
            }
        }
    }
    Ok(())
}

/// The orders are the claimed ones on every problem.
pub(super) fn check(stepper: &Stepper) -> Check {
    problems::all().iter().try_for_each(|problem| check_on(stepper, problem))
}

#[test]
fn orders_are_as_claimed() {
    all_pass(check);
}

/// What is left over on a parabola by the methods of order 1, and on a linear thrust by those of order 2.
fn check_constants(stepper: &Stepper) -> Check {
    let along = |problem: &Problem, steps: u32, axis: DVec3| {
        let mut bare = problem.bare(stepper, problem.span / f64::from(steps));
        stepper.run(&mut bare, steps);
        (position(&bare, 0) - (problem.exact)(problem.span).0).dot(axis)
    };
    // g h T / 2, g = 9.8, h = 1/60, T = 2; explicit Euler falls late, the others early.
    let fall = match stepper.method {
        Method::ExplicitEuler => 0.98 / 6.0,
        Method::SemiImplicitEuler | Method::ImplicitEuler => -0.98 / 6.0,
        _ => 0.0,
    };
    let measured = along(&problems::free_fall(), 120, DVec3::Y);
    within(
        || format!("free fall, {measured} for {fall}"),
        (measured - fall).abs(),
        23.0 * rounding(240),
    )?;
    if stepper.claims().position_order == 2 {
        // -a' T h² / 6, a' = 15, h = 1/128, T = 1.
        let thrust = -15.0 / (6.0 * 128.0 * 128.0);
        let measured = along(&problems::linear_thrust(), 128, SKEW);
        within(
            || format!("thrust, {measured} for {thrust}"),
            (measured - thrust).abs(),
            7.5 * rounding(256),
        )?;
    }
    Ok(())
}

#[test]
fn error_constants_are_those_of_theory() {
    all_pass(check_constants);
}

/// Position Verlet's velocity is of order 1 for now, and of order 2 for half a step ago.
#[test]
fn position_verlets_velocity_is_that_of_half_a_step_ago() {
    let (problem, stepper) = (problems::duffing(), Stepper::real(Method::PositionVerlet));
    let error = |steps: u32| {
        let h = problem.span / f64::from(steps);
        let mut bare = problem.bare(&stepper, h);
        stepper.run(&mut bare, steps);
        velocity(&bare, 0).distance((problem.exact)(problem.span - h / 2.0).1)
    };
    let order = (error(1024) / error(2048)).log2();
    assert!((order - 2.0).abs() <= 0.05, "{order}");
}
