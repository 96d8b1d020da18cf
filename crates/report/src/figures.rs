//! The figures of a study.

mod cost;
mod drift;
mod precision;
mod step;
use lab::cost::{Accuracy, Cell, Cost, Precision, Study};
use motion::Method;

use super::chart::{Axis, Chart, Drawing};
use super::numbers::{duration, length, number, power, share};
use crate::palette::ink;

/// What a figure shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Error against step.
    Step(Accuracy),
    /// Error against cost.
    Cost(Accuracy, Cost),
    /// Error against substeps in every precision.
    Precision,
    /// Energy over time; whether of the long runs.
    Drift(bool),
}

impl Kind {
    /// Name of the file without the subject and the ending.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Step(accuracy) => format!("error-step-{}", accuracy_name(accuracy)),
            Self::Cost(accuracy, cost) => {
                format!("error-cost-{}-{}", cost_name(cost), accuracy_name(accuracy))
            }
            Self::Precision => "precision".to_owned(),
            Self::Drift(long) => format!("energy-{}", if long { "long" } else { "short" }),
        }
    }
}

/// The two that are drawn: what one sees, and what methods are usually compared by.
pub(crate) const ACCURACIES: [Accuracy; 2] = [Accuracy::Position, Accuracy::Relative];

/// Costs of which a study has any.
pub(crate) fn costs(study: &Study) -> Vec<Cost> {
    let measured = |cost: &Cost| curves(study).any(|cell| study.cost(cell, *cost).is_some());
    Cost::ALL.into_iter().filter(measured).collect()
}

/// All figures of a study that have anything to show.
pub(crate) fn figures(study: &Study) -> Vec<(Kind, Drawing)> {
    let mut kinds = Vec::new();
    if curves(study).next().is_some() {
        kinds.extend(ACCURACIES.map(Kind::Step));
        for cost in costs(study) {
            kinds.extend(ACCURACIES.map(|accuracy| Kind::Cost(accuracy, cost)));
        }
    }
    kinds.extend([Kind::Precision, Kind::Drift(false), Kind::Drift(true)]);
    let drawing = |kind| match kind {
        Kind::Step(accuracy) => Some(step::figure(study, accuracy)),
        Kind::Cost(accuracy, cost) => Some(cost::figure(study, accuracy, cost)),
        Kind::Precision => precision::figure(study),
        Kind::Drift(long) => drift::figure(study, long),
    };
    kinds.into_iter().filter_map(|kind| Some((kind, drawing(kind)?))).collect()
}

/// The cells of double precision, of which most figures are.
fn curves(study: &Study) -> impl Iterator<Item = &Cell> {
    study.in_double().filter(|cell| cell.is_run())
}

/// Part of the name of a file, and class of a figure on a page.
pub(crate) const fn accuracy_name(accuracy: Accuracy) -> &'static str {
    match accuracy {
        Accuracy::Relative => "relative",
        Accuracy::Position => "position",
        Accuracy::Velocity => "velocity",
    }
}

/// Part of the name of a file, and class of a figure on a page.
pub(crate) const fn cost_name(cost: Cost) -> &'static str {
    match cost {
        Cost::Evaluations => "evaluations",
        Cost::Time => "time",
        Cost::RealTime => "real-time",
        Cost::Instructions => "instructions",
    }
}

/// "VV x4".
fn short(cell: &Cell) -> String {
    format!("{} x{}", ink(cell.setting.method).short, cell.setting.substeps)
}

/// An error in the unit of its axis.
fn error_words(accuracy: Accuracy, error: f64) -> String {
    match accuracy {
        Accuracy::Relative => number(error, 2),
        Accuracy::Position => length(error, 2),
        Accuracy::Velocity => format!("{}/s", length(error, 2)),
    }
}

fn cost_words(cost: Cost, value: f64) -> String {
    match cost {
        Cost::Evaluations => format!("{} evaluations per body per s", number(value, 3)),
        Cost::Time => format!("{} per body per s", duration(value, 2)),
        Cost::RealTime => format!("{} of real time", share(value, 2)),
        Cost::Instructions => format!("{} instructions per s", number(value, 3)),
    }
}

/// What shows under the pointer at a point.
fn tooltip(study: &Study, cell: &Cell, accuracy: Accuracy, cost: Cost) -> String {
    let error =
        study.error(cell, accuracy).map_or_else(|| "failed".to_owned(), |error| error_words(accuracy, error));
    let price =
        study.cost(cell, cost).map_or_else(String::new, |price| format!(", {}", cost_words(cost, price)));
    let step = duration(1e9 * study.step_s(cell.setting), 3);
    let title = cell.setting.method.claims().title;
    format!("{title} x {} (steps of {step}): {error}{price}", cell.setting.substeps)
}

/// A floor that errors come near; one that is far below them would take the room of the curves.
fn in_sight<'a>(
    study: &Study,
    accuracy: Accuracy,
    cells: impl Iterator<Item = &'a Cell>,
    floor: f64,
) -> Option<f64> {
    let errors = cells.filter_map(|cell| study.error(cell, accuracy)).filter(|error| *error > 0.0);
    let least = errors.fold(f64::INFINITY, f64::min);
    (floor > 0.0 && floor > 1e-3 * least).then_some(floor)
}

/// The axis of errors, with room for failures at its top. An error of 0 stands at its foot.
fn error_axis<'a>(
    study: &Study,
    accuracy: Accuracy,
    cells: impl Iterator<Item = &'a Cell>,
    also: Option<f64>,
) -> Axis {
    let errors: Vec<_> = cells.map(|cell| study.error(cell, accuracy)).collect();
    let room = if errors.contains(&None) { 0.1 } else { 0.02 };
    let (title, label): (_, fn(f64) -> String) = match accuracy {
        Accuracy::Relative => ("error, relative to the motion", power),
        Accuracy::Position => ("error of positions", |value| length(value, 1)),
        Accuracy::Velocity => ("error of velocities", |value| format!("{}/s", length(value, 1))),
    };
    Axis::logarithmic(title, errors.into_iter().flatten().chain(also), label).with_room(room)
}

/// Draws a curve whose cells stand at `place`, with `words` under the pointer; whether any run of it failed.
fn draw(
    chart: &mut Chart,
    study: &Study,
    (method, precision): (Method, Precision),
    accuracy: Accuracy,
    place: impl Fn(&Cell) -> Option<f64>,
    words: impl Fn(&Cell) -> String,
) -> bool {
    let cells = study.curve(method, precision).filter(|cell| cell.is_run());
    let points: Vec<_> =
        cells.filter_map(|cell| Some((cell, place(cell)?, study.error(cell, accuracy)))).collect();
    // A line does not pass over a failure.
    for part in points.split(|(.., error)| error.is_none()).filter(|part| part.len() > 1) {
        let line: Vec<_> = part.iter().filter_map(|(_, x, error)| Some((*x, (*error)?))).collect();
        chart.curve(method, precision, &line);
    }
    for (cell, x, error) in &points {
        match error {
            Some(error) => chart.point(method, *x, *error, &words(cell)),
            None => chart.failure(method, *x, &words(cell)),
        }
    }
    points.iter().any(|(.., error)| error.is_none())
}
