//! What a plan has time for: rungs and length of a study, from a trial.

use motion::Method;

use super::bench::REFERENCE;
use super::plan::Plan;
use super::record::{Precision, Setting};
use super::subject::Subject;
use super::timing::Clock;

/// Rungs below which none are left out, however long they take.
const AT_LEAST: usize = 3;

/// Rungs that are not given up for a longer run.
const ENOUGH: usize = 5;

/// A run of a scene is made no shorter to save time, s.
const SHORTEST: f64 = 0.75;

/// Why a run was made shorter.
const LONG: &str = "more would have taken too long for this plan";

/// The rungs that can be run in the plan's time, by a trial of some ticks. Long runs are shortened before the
/// ladder gets too short to show a slope; what is left out is noted.
pub(super) fn affordable(subject: &mut Subject, plan: &Plan, clock: &Clock) -> Vec<u32> {
    let mut rungs = plan.rungs_of(subject);
    let evaluation = evaluation(subject, rungs[0], clock);
    let before = rungs.len();
    #[expect(clippy::cast_precision_loss, reason = "a count of ticks")]
    let price = |subject: &Subject, rungs: &[u32]| {
        evaluation * subject.ticks as f64 * evaluations(subject, plan, rungs)
    };
    while price(subject, &rungs) > plan.patience {
        if rungs.len() > ENOUGH || rungs.len() > AT_LEAST && !subject.yields {
            rungs.pop();
        } else if subject.seconds() < SHORTEST || !subject.halve(LONG) {
            if rungs.len() <= AT_LEAST {
                break;
            }
            rungs.pop();
        }
    }
    if rungs.len() < before {
        let finest = rungs.last().copied().unwrap_or(1);
        subject.notes.push(format!("more than {finest} substeps would have taken too long for this plan"));
    }
    rungs
}

/// Thread CPU time of one evaluation of all bodies, s, about.
fn evaluation(subject: &Subject, substeps: u32, clock: &Clock) -> f64 {
    let probe = Setting { method: REFERENCE, substeps, precision: Precision::F64 };
    let mut run = subject.run(probe);
    run.tick();
    let (start, mut ticks) = (clock(), 0.0);
    while ticks < 8.0 && clock() - start < 0.02 {
        run.tick();
        ticks += 1.0;
    }
    (clock() - start) / ticks / (4.0 * f64::from(substeps))
}

/// Evaluations of a tick that all errors of a plan take together, about.
fn evaluations(subject: &Subject, plan: &Plan, rungs: &[u32]) -> f64 {
    let steps: f64 = rungs.iter().map(|rung| f64::from(*rung)).sum();
    let of = |method: &Method| {
        let solves = if *method == Method::ImplicitEuler { 10.0 } else { 1.0 };
        let precisions = if plan.single.contains(method) { 4.0 } else { 1.0 };
        f64::from(method.claims().evaluations_with_velocity_laws) * solves * precisions
    };
    let finest = f64::from(rungs.last().copied().unwrap_or(1));
    let reference = if subject.exact.is_some() { 0.0 } else { 6.0 * finest * f64::from(plan.finer) };
    steps * plan.methods.iter().map(of).sum::<f64>() + reference
}
