//! S9: an engine that comes on inside a step.

use glam::DVec3;
use motion::{Curve, EvaluationTime, Law, Thrust};

use super::laws::Spring;
use super::orders::errors;
use super::problems::{ACROSS, Problem};
use super::{Check, SKEW, Stepper, all_pass, within};
use crate::rigs::Formula;

/// An engine that nobody was told about: no step is split where it comes on, and it is on wherever a stage lies
/// beyond.
fn unannounced(engine: Thrust) -> Formula {
    Formula::new("unannounced", move |at, body| {
        engine.acceleration(EvaluationTime { within_step: at.time, ..at }, body)
    })
}

/// An oscillator, w = 2, whose engine comes on at a third of the span: never at the end of one of 2^k steps, and
/// at the same part of a step, or what is left of it, when steps are quartered.
fn late_engine(announced: bool) -> Problem {
    let (w, span, push) = (2.0_f64, 3.0, ACROSS * 5.0);
    let swing = move |x: DVec3, v: DVec3, t: f64| {
        let (sin, cos) = (w * t).sin_cos();
        (x * cos + v * (sin / w), v * cos - x * (w * sin))
    };
    Problem::new(
        if announced { "announced engine" } else { "unannounced engine" },
        span,
        move |bare| {
            let engine =
                Thrust::new(Curve::Polynomial(vec![push / 0.5]), span / 3.0, f64::INFINITY);
            let bare = bare.with_law(Spring(2.0 * w * w));
            if announced { bare.with_law(engine) } else { bare.with_law(unannounced(engine)) }
        },
        move |t| {
            let on = span / 3.0;
            let (x, v) = swing(SKEW, ACROSS * 0.5, t.min(on));
            let centre = push / (w * w);
            let (x, v) = if t > on { swing(x - centre, v, t - on) } else { (x - centre, v) };
            (x + centre, v)
        },
    )
}

/// log4 of the errors of `steps` steps and of four times as many.
fn orders(stepper: &Stepper, announced: bool, steps: u32) -> [f64; 2] {
    let problem = late_engine(announced);
    let (coarse, fine) = (errors(stepper, &problem, steps), errors(stepper, &problem, 4 * steps));
    [0, 1].map(|column| (coarse[column] / fine[column]).log2() / 2.0)
}

/// A step that is split where the engine comes on keeps the claimed order.
pub fn check_split(stepper: &Stepper) -> Check {
    let claims = stepper.claims();
    let steps = if claims.position_order == 4 { 128 } else { 1024 };
    let fitted = orders(stepper, true, steps);
    for (fitted, claimed) in fitted.into_iter().zip([claims.position_order, claims.velocity_order])
    {
        within(|| format!("order {fitted:.3}"), (fitted - f64::from(claimed)).abs(), 0.05)?;
    }
    Ok(())
}

#[test]
fn a_split_step_keeps_the_order() {
    all_pass(check_split);
}

#[test]
fn a_step_over_the_jump_leaves_order_1() {
    for stepper in Stepper::all() {
        for fitted in orders(&stepper, false, 4096) {
            assert!((fitted - 1.0).abs() <= 0.05, "{}: {fitted:.3}", stepper.name);
        }
    }
}
