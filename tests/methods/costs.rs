//! Evaluations of the acceleration: as many as claimed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DMat3;
use motion::{BodyState, Jacobians, Method};

use super::problems;
use super::{SKEW, Stepper};
use crate::rigs::{Formula, pull};

/// An oscillator that counts, damped or not.
fn counted(calls: Arc<AtomicU64>, rate: f64) -> Formula {
    let acceleration = move |_, body: BodyState| {
        calls.fetch_add(1, Ordering::Relaxed);
        -body.position - body.velocity * rate
    };
    let jacobians = move |_: BodyState| Jacobians {
        position: -DMat3::IDENTITY,
        velocity: DMat3::IDENTITY * -rate,
    };
    Formula::new("counted", acceleration).with_jacobians(jacobians).of_velocity(rate > 0.0)
}

#[test]
fn evaluations_are_as_claimed() {
    const STEPS: u32 = 100;
    for stepper in Stepper::all() {
        let claims = stepper.claims();
        for (rate, claimed, start_up) in [
            (0.0, claims.evaluations, claims.start_up_evaluations),
            (0.4, claims.evaluations_with_velocity_laws, 0),
        ] {
            let calls = Arc::new(AtomicU64::new(0));
            let mut bare = stepper.bare(0.01).with_law(counted(Arc::clone(&calls), rate));
            bare.add(SKEW.to_array(), [0.0; 3], 0.5);
            stepper.run(&mut bare, STEPS);
            let (iterations, failed) = bare.newton();
            let expected = if stepper.method == Method::ImplicitEuler {
                // Every iteration but the last, which only corrects, evaluates once more.
                u64::from(STEPS * claimed) + iterations - u64::from(STEPS)
            } else {
                u64::from(STEPS * claimed + start_up)
            };
            assert_eq!(calls.load(Ordering::Relaxed), expected, "{}, rate {rate}", stepper.name);
            assert_eq!(failed, 0, "{}", stepper.name);
        }
    }
}

/// A solve that is given up would still look like order 1.
#[test]
fn every_implicit_step_converges() {
    let stepper = Stepper::real(Method::ImplicitEuler);
    for problem in problems::all() {
        let mut bare = problem.bare(&stepper, problem.span / 256.0);
        stepper.run(&mut bare, 256);
        let (iterations, failed) = bare.newton();
        assert_eq!(failed, 0, "{}", problem.name);
        // Newton's method doubles the digits: from a start that is right to h = 1/256, three times is 1e-19.
        assert!(iterations <= 4 * 256, "{}: {iterations}", problem.name);
    }
}

/// A body that hangs still: the tolerance has to be one of what rounding leaves, not of a velocity of 0.
#[test]
fn a_body_at_rest_converges() {
    let stepper = Stepper::real(Method::ImplicitEuler);
    let mut bare = stepper
        .bare(1.0 / 60.0)
        .with_law(super::laws::Spring(800.0))
        .with_law(pull(SKEW * 9.8))
        .with_law(motion::Drag::new(5.0, 0.0));
    bare.add(SKEW.to_array(), problems::ACROSS.to_array(), 0.5);
    stepper.run(&mut bare, 2000);
    let (iterations, failed) = bare.newton();
    assert_eq!(failed, 0);
    assert!(iterations <= 4 * 2000, "{iterations}");
}
