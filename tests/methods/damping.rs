//! The three damping models under every method.

use motion::{Damping, DampingModel, Method};

use super::fingerprint::last_stable;
use super::{Check, SKEW, Stepper, all_pass, position, velocity, within};
use crate::rigs::Bare;
use crate::rigs::{engine, step_matrix};

const H: f64 = 1.0 / 60.0;

/// The speed left of 1 after a coasting step, as the difference equation of the method has it. Position
/// Verlet's is that of a step after another.
fn left(method: Method, q: f64) -> f64 {
    match method {
        // These apply exact damping within the step.
        Method::ExplicitEuler | Method::SemiImplicitEuler => (-q).exp(),
        method => step_matrix(method, 1.0, [0.0, q])[1][1],
    }
}

/// The largest stable q = c h of pure drag, from [`left`].
fn limit(method: Method) -> f64 {
    last_stable(|q| left(method, q).abs() <= 1.0)
}

#[test]
fn limits_under_drag_are_those_of_the_stability_functions() {
    for (method, known) in [
        (Method::ExplicitEuler, f64::INFINITY),
        (Method::SemiImplicitEuler, f64::INFINITY),
        (Method::ImplicitEuler, f64::INFINITY),
        (Method::PositionVerlet, 2.0),
        (Method::VelocityVerlet, 2.0),
        (Method::RungeKutta2Midpoint, 2.0),
        (Method::RungeKutta2Heun, 2.0),
        (Method::RungeKutta4, 2.785_293_563),
        // The step back gains speed under drag.
        (Method::Yoshida4, 0.893_399_012),
    ] {
        let limit = limit(method);
        assert!(limit == known || (limit - known).abs() <= 1e-8, "{method:?}: {limit}");
    }
}

fn damped(stepper: &Stepper, model: DampingModel, q: f64) -> Bare {
    stepper.bare(H).with_damping(Damping { model, rate: q / H })
}

/// A coasting step leaves of the velocity what the method's stability function says.
pub fn check_decay(stepper: &Stepper) -> Check {
    for q in [1e-3, 0.1, 0.5, 1.0, 1.5, 2.5, 30.0] {
        let mut bare = damped(stepper, DampingModel::Exact, q);
        bare.add([0.0; 3], SKEW.to_array(), 0.5);
        stepper.run(&mut bare, 1);
        let before = velocity(&bare, 0);
        stepper.run(&mut bare, 1);
        let exact = before * left(stepper.method, q);
        // The terms of Yoshida's three quadratics, or of a quartic.
        let terms = (1.0 + 1.8 * q + 1.8 * q * q).powi(if stepper.method == Method::Yoshida4 {
            3
        } else {
            2
        });
        let error = velocity(&bare, 0).distance(exact);
        within(
            || format!("decay at q = {q}"),
            error,
            8.0 * f64::EPSILON * terms * before.length(),
        )?;
    }
    Ok(())
}

#[test]
fn exact_damping_decays_by_the_stability_function() {
    all_pass(check_decay);
}

#[test]
fn exact_damping_diverges_above_the_limit_and_not_below() {
    for stepper in Stepper::all().filter(|stepper| limit(stepper.method).is_finite()) {
        for (part, grows) in [(0.97, false), (1.03, true)] {
            let mut bare = damped(&stepper, DampingModel::Exact, part * limit(stepper.method));
            bare.add([0.0; 3], SKEW.to_array(), 0.5);
            stepper.run(&mut bare, 500);
            assert_eq!(velocity(&bare, 0).length() >= 1.0, grows, "{} {part}", stepper.name);
        }
    }
}

/// Of the terminal speed a / c, what is stored and what the body moves at.
fn terminal(method: Method, model: DampingModel, q: f64) -> (f64, f64) {
    let half_taken_in = match method {
        Method::ImplicitEuler | Method::PositionVerlet => 1.0,
        _ => 1.0 - q / 2.0,
    };
    match (model, method) {
        (DampingModel::Exact, _) => (1.0, 1.0),
        (DampingModel::Tutorial, Method::ExplicitEuler) => (1.0, 1.0),
        (DampingModel::Tutorial, Method::SemiImplicitEuler) => (1.0 - q, 1.0),
        (DampingModel::Clamped, Method::ExplicitEuler) => (1.0, 1.0 - q),
        (DampingModel::Clamped, Method::SemiImplicitEuler) => (1.0 - q, 1.0 - q),
        (DampingModel::Tutorial, _) => (1.0 - q, half_taken_in),
        (DampingModel::Clamped, _) => (1.0, half_taken_in),
        (DampingModel::Implicit, Method::SemiImplicitEuler) => (1.0, 1.0),
        (DampingModel::Implicit, Method::ExplicitEuler) => (1.0 + q, 1.0),
        // Divided before the force is added, which the velocity has whole and the move in part.
        (DampingModel::Implicit, _) => (1.0 + q, half_taken_in + q),
    }
}

/// The terminal speed of each model, stored and moved at; the exact one right at every stable step.
pub fn check_terminal(stepper: &Stepper) -> Check {
    let most = (0.97 * limit(stepper.method)).min(100.0);
    for model in DampingModel::ALL {
        let rates = if model == DampingModel::Exact { [0.05, 0.5, most] } else { [0.05, 0.5, 0.9] };
        for q in rates {
            let mut bare = damped(stepper, model, q).with_law(engine([SKEW * (2.0 * q / H)]));
            bare.add([0.0; 3], [0.0; 3], 0.5);
            // At 0.97 of a limit 3 % of a transient go in a step, at q = 0.05 5 %: e^-36 is below rounding.
            stepper.run(&mut bare, 1200);
            let before = position(&bare, 0);
            stepper.run(&mut bare, 1);
            let moves = (position(&bare, 0) - before).dot(SKEW) / H;
            let stored = velocity(&bare, 0).dot(SKEW);
            let (right, right_moves) = terminal(stepper.method, model, q);
            let what = |kind: &str| format!("{model:?}, q = {q}, {kind} {stored} {moves}");
            within(|| what("stored"), (stored - right).abs(), 1e-13)?;
            // Rounding of a position of 20 m, seen as a speed.
            let noise = 20.0 * f64::EPSILON / H;
            within(|| what("moves"), (moves - right_moves).abs(), noise + 1e-13)?;
        }
    }
    Ok(())
}

#[test]
fn terminal_speeds_are_those_of_theory() {
    all_pass(check_terminal);
}

/// Coasting: the multipliers of tutorial and clamped act once a tick, or once a substep of the two Eulers, which
/// have them inside.
pub fn check_multipliers(stepper: &Stepper) -> Check {
    let euler = matches!(stepper.method, Method::ExplicitEuler | Method::SemiImplicitEuler);
    for (model, q, substeps) in [
        (DampingModel::Tutorial, 0.3, 1),
        (DampingModel::Tutorial, 0.3, 3),
        (DampingModel::Tutorial, 1.5, 1),
        (DampingModel::Clamped, 0.3, 1),
        (DampingModel::Clamped, 0.3, 8),
        (DampingModel::Clamped, 1.5, 1),
        (DampingModel::Implicit, 0.3, 1),
        (DampingModel::Implicit, 1.5, 8),
    ] {
        let mut bare = damped(stepper, model, q).with_substeps(substeps);
        bare.add([0.0; 3], SKEW.to_array(), 0.5);
        stepper.run(&mut bare, 1);
        let parts = if euler { f64::from(substeps) } else { 1.0 };
        let factor = 1.0 - q / parts;
        let factor = match model {
            DampingModel::Clamped => factor.max(0.0),
            DampingModel::Implicit => (1.0 + q / parts).recip(),
            _ => factor,
        };
        let error = velocity(&bare, 0).distance(SKEW * factor.powf(parts));
        within(|| format!("{model:?}, q = {q}, {substeps} substeps"), error, 16.0 * f64::EPSILON)?;
        // The clamped and the implicit factor act before the move, the tutorial's after it.
        let moved = position(&bare, 0).dot(SKEW) / H;
        let each = |part: i32| match model {
            DampingModel::Clamped | DampingModel::Implicit => {
                factor.powi(if euler { part + 1 } else { 1 })
            }
            _ => factor.powi(if euler { part } else { 0 }),
        };
        let count = i32::try_from(substeps).unwrap();
        let expected = (0..count).map(each).sum::<f64>() / f64::from(substeps);
        within(
            || format!("{model:?}, q = {q}, {substeps} substeps, moved"),
            (moved - expected).abs(),
            64.0 * f64::EPSILON,
        )?;
    }
    Ok(())
}

#[test]
fn multipliers_act_once() {
    all_pass(check_multipliers);
}

/// The last digit of a percentage.
fn percent(value: f64, digits: f64, known: f64) {
    assert!(
        (value * 100.0 - known).abs() <= digits / 2.0 + 1e-9,
        "{} % for {known} %",
        value * 100.0
    );
}

/// Semi-implicit Euler after 2 s: coasting with the tutorial's rate, and a heavily damped body under a constant force.
#[test]
fn errors_of_the_models_at_four_rates() {
    let run = |model, hz: f64, rate, a: f64, v: f64| {
        let stepper = Stepper::real(Method::SemiImplicitEuler);
        let mut bare = stepper
            .bare(1.0 / hz)
            .with_damping(Damping { model, rate })
            .with_law(engine([SKEW * a]));
        bare.add([0.0; 3], (SKEW * v).to_array(), 1.0);
        stepper.run(&mut bare, (2.0 * hz).round() as u32);
        (position(&bare, 0).dot(SKEW), velocity(&bare, 0).dot(SKEW))
    };
    for (hz, coasting, tutorial, clamped, implicit) in [
        (30.0, (-0.54, 0.01), (1.7, 0.1), (-100.0, 1.0), (0.53, 0.01)),
        (60.0, (-0.27, 0.01), (0.85, 0.01), (-49.6, 0.1), (0.27, 0.01)),
        (120.0, (-0.13, 0.01), (0.42, 0.01), (-24.7, 0.1), (0.13, 0.01)),
        (240.0, (-0.07, 0.01), (0.21, 0.01), (-12.3, 0.1), (0.07, 0.01)),
    ] {
        let exact_v = (-0.8_f64).exp();
        for model in [DampingModel::Tutorial, DampingModel::Clamped] {
            let (_, v) = run(model, hz, 0.4, 0.0, 1.0);
            percent(v / exact_v - 1.0, coasting.1, coasting.0);
        }
        let (_, v) = run(DampingModel::Exact, hz, 0.4, 0.0, 1.0);
        assert!((v / exact_v - 1.0).abs() <= 2.0 * hz * f64::EPSILON);
        // x = (a / c)(t - (1 - e^-ct) / c)
        let exact_x = 800.0 / 30.0 * (2.0 + (-60.0_f64).exp_m1() / 30.0);
        let (x, _) = run(DampingModel::Tutorial, hz, 30.0, 800.0, 0.0);
        percent(x / exact_x - 1.0, tutorial.1, tutorial.0);
        let (x, _) = run(DampingModel::Clamped, hz, 30.0, 800.0, 0.0);
        percent(x / exact_x - 1.0, clamped.1, clamped.0);
        let (_, v) = run(DampingModel::Implicit, hz, 0.4, 0.0, 1.0);
        percent(v / exact_v - 1.0, implicit.1, implicit.0);
        // Once the terminal speed is reached, the sum of the steps is the exact one.
        let (x, _) = run(DampingModel::Implicit, hz, 30.0, 800.0, 0.0);
        assert!((x / exact_x - 1.0).abs() < 1e-9, "{hz} Hz: {x} m for {exact_x} m");
    }
}
