//! Two methods at equal cost.

use motion::Method;

use super::{error_of, evaluations, title};
use crate::numbers::{capital, fold, length, number};
use crate::reading::{Round, best_round, exact, ran, rounds, turn, usable};
use lab::cost::{Cell, Cost, Study};

const PLAIN: Method = Method::SemiImplicitEuler;
const FOURTH: Method = Method::RungeKutta4;

/// Errors that differ by less than this part are alike.
const ALIKE: f64 = 0.05;

/// Rounds of the tutorial's question: Runge-Kutta 4 at h, semi-implicit Euler at h / 4.
pub(crate) fn tutorial_rounds(study: &Study) -> Vec<Round<'_>> {
    rounds(study, FOURTH, PLAIN)
}

pub(super) fn tutorial(study: &Study) -> Vec<String> {
    let rounds = tutorial_rounds(study);
    let of_use = |round: &&Round<'_>| usable(study, round.first) || usable(study, round.second);
    let factors: Vec<_> =
        rounds.iter().filter(of_use).filter_map(|round| Some((round, round.factor(study)?))).collect();
    let wins = factors.iter().filter(|(_, factor)| *factor > 1.0).count();
    let mut said = Vec::new();
    match wins {
        _ if factors.is_empty() => {}
        0 => said.push(one_sided(study, PLAIN, FOURTH, &factors)),
        _ if wins == factors.len() => said.push(one_sided(study, FOURTH, PLAIN, &factors)),
        _ => said.push(turning(study, &factors)),
    }
    said.extend(rounds.iter().filter_map(|round| only_one_lasts(study, round)));
    said
}

/// How many times smaller the error of `better` is in a round whose factor is that of Runge-Kutta 4.
fn by(better: Method, factor: f64) -> String {
    fold(if better == FOURTH { factor } else { factor.recip() })
}

fn one_sided(study: &Study, better: Method, worse: Method, factors: &[(&Round<'_>, f64)]) -> String {
    let [(coarse, first), ..] = factors else { return String::new() };
    if exact(study, better) {
        let other = if coarse.first.setting.method == worse { coarse.first } else { coarse.second };
        return format!(
            "{} is exact here; {} has an error of {} at {}.",
            capital(&title(better)),
            title(worse),
            error_of(study, other),
            evaluations(study, coarse.evaluations),
        );
    }
    let mut text = format!(
        "At equal evaluations {} is more accurate than {} at every useful step: its error is {} times smaller at {}",
        title(better),
        title(worse),
        by(better, *first),
        evaluations(study, coarse.evaluations),
    );
    if let [_, .., (fine, last)] = factors {
        text += &format!(", {} times at {}", by(better, *last), number(fine.evaluations, 3));
    }
    text.push('.');
    if let Some((cost, error)) = turn(study, better, worse, Cost::Evaluations) {
        text += &format!(
            " Below {}, where both have errors above {}, it is the other way round.",
            evaluations(study, cost),
            length(error, 2),
        );
    }
    text
}

fn turning(study: &Study, factors: &[(&Round<'_>, f64)]) -> String {
    let [(coarse, first), .., (fine, last)] = factors else { return String::new() };
    let winner = |factor: f64| if factor > 1.0 { (FOURTH, "h") } else { (PLAIN, "h / 4") };
    let how = |round: &Round<'_>, factor: f64| {
        let (method, step) = winner(factor);
        let times = by(method, factor);
        (
            format!("{} at {step}", title(method)),
            format!("{times} times at {}", evaluations(study, round.evaluations)),
        )
    };
    let ((who_coarse, much_coarse), (who_fine, much_fine)) = (how(coarse, *first), how(fine, *last));
    let mut text = format!(
        "At equal evaluations {who_coarse} has the smaller error with coarse steps, {much_coarse}, and {who_fine} with \
         fine ones, {much_fine}."
    );
    let (after, before) = (winner(*last).0, winner(*first).0);
    if let Some((cost, error)) = turn(study, after, before, Cost::Evaluations) {
        text += &format!(
            " It turns at {}, where both have an error of {}.",
            evaluations(study, cost),
            length(error, 2)
        );
    }
    text
}

/// At a cost at which the one fails and the other does not.
fn only_one_lasts(study: &Study, round: &Round<'_>) -> Option<String> {
    if !ran(round.first) || !ran(round.second) {
        return None;
    }
    let (lasts, fails): (&Cell, &Cell) = match (round.first.errors(), round.second.errors()) {
        (Some(_), None) => (round.first, round.second),
        (None, Some(_)) => (round.second, round.first),
        _ => return None,
    };
    Some(format!(
        "At {} only {} goes through, with an error of {}; {} does not.",
        evaluations(study, round.evaluations),
        title(lasts.setting.method),
        error_of(study, lasts),
        title(fails.setting.method),
    ))
}

pub(super) fn verlet(study: &Study) -> Vec<String> {
    let verlet = Method::VelocityVerlet;
    let against = |other| -> Option<String> {
        let rounds = rounds(study, other, verlet);
        let (round, factor) = best_round(study, &rounds)?;
        if (factor - 1.0).abs() < ALIKE {
            let at = evaluations(study, round.evaluations);
            let error = error_of(study, round.second);
            return Some(format!(
                "{} and {} have equal errors: {error} at {at}.",
                capital(&title(verlet)),
                title(other)
            ));
        }
        let (better, worse) =
            if factor < 1.0 { (round.second, round.first) } else { (round.first, round.second) };
        Some(format!(
            "At equal evaluations the error of {} is {} times smaller than that of {}: {} against {} at {}{}.",
            title(better.setting.method),
            fold(factor.max(factor.recip())),
            title(worse.setting.method),
            error_of(study, better),
            error_of(study, worse),
            evaluations(study, round.evaluations),
            why(study, round),
        ))
    };
    let mut said: Vec<_> =
        [Method::RungeKutta2Midpoint, Method::RungeKutta2Heun].into_iter().filter_map(against).collect();
    if let Some((cost, error)) = turn(study, FOURTH, verlet, Cost::Evaluations) {
        said.push(format!(
            "{} overtakes {} at {}: for errors below {} it is the cheaper of the two.",
            capital(&title(FOURTH)),
            title(verlet),
            evaluations(study, cost),
            length(error, 2),
        ));
    }
    said
}

/// What of the factor the longer step makes, and what is left at equal steps.
fn why(study: &Study, round: &Round<'_>) -> String {
    let (other, verlet) = (round.first, round.second);
    let steps = f64::from(verlet.setting.substeps) / f64::from(other.setting.substeps);
    let same_step = study
        .curve(verlet.setting.method, verlet.setting.precision)
        .find(|cell| cell.setting.substeps == other.setting.substeps);
    let left =
        same_step.and_then(|same| Some(study.error(other, super::SEEN)? / study.error(same, super::SEEN)?));
    match left {
        Some(left) if steps > 1.0 && left.is_finite() && left > 0.0 => format!(
            " (its steps are {} times as short for the same evaluations; at equal steps its error is {} times {})",
            number(steps, 2),
            fold(left.max(left.recip())),
            if left >= 1.0 { "smaller" } else { "larger" },
        ),
        _ => String::new(),
    }
}
