//! The cheapest for an error, what never pays, what single precision leaves, and whether orders are as claimed.

use motion::Method;

use super::{bodies, evaluations, setting, title};
use crate::choice::{Answer, answers, leads, never_best, tie};
use crate::numbers::{capital, duration, length, list, number, share};
use crate::reading::{self, floor, methods};
use lab::cost::{Cell, Cost, Precision, Study, Truth};

/// Time of a setting: of a step of a body, and of the whole.
fn time(study: &Study, cell: &Cell) -> Option<String> {
    let time = cell.time.as_ref()?;
    let part = share(study.cost(cell, Cost::RealTime)?, 2);
    let ns = duration(time.ns_per_body_step, 2);
    Some(format!("{ns} per body per step, {part} of real time with {}", bodies(study.size())))
}

pub(super) fn cheapest(study: &Study) -> Vec<String> {
    answers(study).iter().map(|answer| sentence(study, answer)).collect()
}

fn sentence(study: &Study, answer: &Answer<'_>) -> String {
    let pick = answer.by_evaluations;
    let cost = study.cost(pick, Cost::Evaluations).unwrap_or(f64::NAN);
    let mut text = format!(
        "For an error below {} within {} s, {} is the cheapest: {}",
        length(answer.below_m, 2),
        number(study.simulated_s, 3),
        setting(study, pick),
        evaluations(study, cost),
    );
    if let Some(time) = time(study, pick) {
        text += &format!(", {time}");
    }
    if let Some((next, error)) = answer.next {
        text += &format!("; {} becomes cheaper below {}", title(next), length(error, 2));
    }
    text += ".";
    let of_time = |cell: &Cell| study.cost(cell, Cost::Time).unwrap_or(f64::INFINITY);
    let slower = |quick: &&Cell| {
        let tie = tie(study, Cost::Time, [quick.setting.method, pick.setting.method]);
        of_time(quick) * (1.0 + tie) < of_time(pick)
    };
    if let Some(quick) = answer.by_time.filter(slower)
        && let Some(time) = time(study, quick)
    {
        text += &format!(" By time it is {}: {time}.", setting(study, quick));
    }
    text
}

pub(super) fn never(study: &Study) -> Vec<String> {
    let by = |cost, name: &str| {
        let titles: Vec<_> = never_best(study, cost).into_iter().map(title).collect();
        let are = if titles.len() == 1 { "is" } else { "are" };
        (!titles.is_empty())
            .then(|| (name.to_owned(), format!("{} {are} never the best choice", list(&titles))))
    };
    let mut said: Vec<(String, String)> = Vec::new();
    for (cost, name) in [(Cost::Evaluations, "evaluations"), (Cost::Time, "time")] {
        if leads(study, cost).is_empty() {
            continue;
        }
        match (by(cost, name), said.last_mut()) {
            (Some((_, same)), Some(before)) if before.1 == same => before.0 += " and by time",
            (Some(other), _) => said.push(other),
            (None, _) => {}
        }
    }
    said.into_iter().map(|(name, whom)| format!("By {name}, {whom}.")).collect()
}

pub(super) fn single_precision(study: &Study) -> Vec<String> {
    let mut said = Vec::new();
    let mut same = Vec::new();
    let went_through =
        |method: &Method| study.curve(*method, Precision::F32).any(|cell| cell.errors().is_some());
    for method in methods(study, Precision::F32).into_iter().filter(went_through) {
        match of_single(study, method) {
            Some(text) => said.push(text),
            None => same.push(title(method)),
        }
    }
    if !same.is_empty() {
        said.push(format!("For {} single precision is as good at every step that was run.", list(&same)));
    }
    said
}

/// Where single precision stops short of double; `None` if it does not.
fn of_single(study: &Study, method: Method) -> Option<String> {
    let (best, least, worse) = floor(study, method, Precision::F32)?;
    let double = floor(study, method, Precision::F64).map(|(_, least, _)| least);
    if !worse && double.is_some_and(|double| least <= 1.5 * double) {
        return None;
    }
    let hz = study.step_hz * f64::from(best.setting.substeps);
    let of_a_period = |period| format!(", {} per period", number(hz * period, 3));
    let per_period = study.period_s.map(of_a_period).unwrap_or_default();
    let mut text = format!(
        "In single precision {} is most accurate at {} steps per second (x {}{per_period}), with an error of {}",
        title(method),
        number(hz, 3),
        best.setting.substeps,
        length(least, 2),
    );
    if worse {
        text += ", and finer steps make it worse";
    }
    if let Some((_, least, _)) = floor(study, method, Precision::CompensatedF32) {
        text += &format!("; compensated sums reach {}", length(least, 2));
    }
    if let Some(least) = double {
        text += &format!("; double precision reaches {}", length(least, 2));
    }
    Some(text + ".")
}

pub(super) fn orders(study: &Study) -> Vec<String> {
    let mut said = Vec::new();
    let exact: Vec<_> = methods(study, Precision::F64)
        .into_iter()
        .filter(|method| reading::exact(study, *method))
        .map(title)
        .collect();
    if !exact.is_empty() {
        let told = if study.truth.own_error().1 > 0.0 {
            "cannot be told from the reference at any step that was run"
        } else if exact.len() == 1 {
            "is exact here: its error is round-off at every step"
        } else {
            "are exact here: their errors are round-off at every step"
        };
        said.push(format!("{} {told}.", capital(&list(&exact))));
    }
    let odd = reading::odd_orders(study);
    let capped = odd.iter().filter(|odd| odd.shows < f64::from(odd.claimed)).count();
    said.extend(odd.iter().map(|odd| {
        format!(
            "{} shows order {:.1}; the table says {}.",
            capital(&title(odd.method)),
            odd.shows,
            odd.claimed
        )
    }));
    if capped > 1 {
        said.push(cap(study));
    }
    if odd.is_empty()
        && methods(study, Precision::F64)
            .into_iter()
            .any(|method| study.order(method, reading::SEEN).is_some())
    {
        said.push(
            "Every order that could be measured is within 0.25 of what the method's table says.".to_owned(),
        );
    }
    said
}

/// What keeps several methods at once from their orders.
fn cap(study: &Study) -> String {
    if matches!(study.truth, Truth::Reference { exact_damping: true, .. }) {
        let errors = study
            .curve(Method::RungeKutta4, Precision::F64)
            .filter_map(|cell| study.error(cell, reading::SEEN));
        let left = errors.fold(f64::INFINITY, f64::min);
        return format!(
            "What is left, {} with {}, is what damping that multiplies once a tick is away from the law that it stands \
             for: no method and no substep takes it away, but the exact model of damping does.",
            length(left, 2),
            title(Method::RungeKutta4),
        );
    }
    "Orders that fall short in several methods at once are what a law with a jump or a bend inside of steps leaves of \
     them; in one method alone they are a fault of that method."
        .to_owned()
}
