//! What figures of errors share: their cells, their axis of errors, and the words at their points.

use lab::cost::{Accuracy, Cell, Cost, Study};

use crate::chart::{Axis, Chart};
use crate::numbers::{duration, length, number, power, share};

/// The cells that were run.
pub(super) fn run_cells(study: &Study) -> impl Iterator<Item = &Cell> {
    study.cells.iter().filter(|cell| cell.is_run())
}

/// An error in the unit of its axis.
pub(super) fn error_words(accuracy: Accuracy, error: f64) -> String {
    match accuracy {
        Accuracy::Relative => number(error, 2),
        Accuracy::Position => length(error, 2),
        Accuracy::Velocity => format!("{}/s", length(error, 2)),
    }
}

fn cost_words(cost: Cost, value: f64) -> String {
    match cost {
        Cost::Evaluations => format!("{} evaluations per body per s", number(value, 3)),
        Cost::Time | Cost::Arithmetic => format!("{} per body per s", duration(value, 2)),
        Cost::RealTime => format!("{} of real time", share(value, 2)),
    }
}

/// What shows under the pointer at a point.
pub(super) fn tooltip(study: &Study, cell: &Cell, accuracy: Accuracy, cost: Cost) -> String {
    let error = study
        .error(cell, accuracy)
        .map_or_else(|| "failed".to_owned(), |error| error_words(accuracy, error));
    let price = study
        .cost(cell, cost)
        .map_or_else(String::new, |price| format!(", {}", cost_words(cost, price)));
    let step = duration(1e9 * study.mean_step_s(cell), 3);
    let title = cell.setting.method.claims().title;
    format!("{title} x {:#} (steps of {step}): {error}{price}", cell.setting.substeps)
}

/// `floor` if the errors come near it; one far below would squeeze the curves.
pub(super) fn in_sight<'a>(
    study: &Study,
    accuracy: Accuracy,
    cells: impl Iterator<Item = &'a Cell>,
    floor: f64,
) -> Option<f64> {
    let errors = cells.filter_map(|cell| study.error(cell, accuracy)).filter(|error| *error > 0.0);
    let least = errors.fold(f64::INFINITY, f64::min);
    (floor > 0.0 && floor > 1e-3 * least).then_some(floor)
}

/// The axis of errors and of `floor`, with room for failures at its top. An error of 0 is drawn at its foot.
pub(super) fn error_axis<'a>(
    study: &Study,
    accuracy: Accuracy,
    cells: impl Iterator<Item = &'a Cell>,
    floor: Option<f64>,
) -> Axis {
    let errors: Vec<_> = cells.map(|cell| study.error(cell, accuracy)).collect();
    let room = if errors.contains(&None) { 0.1 } else { 0.02 };
    let (title, label): (_, fn(f64) -> String) = match accuracy {
        Accuracy::Relative => ("error, relative to the motion", power),
        Accuracy::Position => ("error of positions", |value| length(value, 1)),
        Accuracy::Velocity => ("error of velocities", |value| format!("{}/s", length(value, 1))),
    };
    Axis::logarithmic(title, errors.into_iter().flatten().chain(floor), label).with_room(room)
}

/// Draws a curve of cells of a method, dashed where they choose their substeps; `place` gives the x of a cell, `words` its tooltip.
/// Returns whether any run of it failed.
pub(super) fn draw<'a>(
    chart: &mut Chart,
    study: &Study,
    cells: impl Iterator<Item = &'a Cell>,
    accuracy: Accuracy,
    place: impl Fn(&Cell) -> Option<f64>,
    words: impl Fn(&Cell) -> String,
) -> bool {
    let cells = cells.filter(|cell| cell.is_run());
    let points: Vec<_> =
        cells.filter_map(|cell| Some((cell, place(cell)?, study.error(cell, accuracy)))).collect();
    // A line does not pass over a failure.
    for part in points.split(|(.., error)| error.is_none()).filter(|part| part.len() > 1) {
        let line: Vec<_> = part.iter().filter_map(|(_, x, error)| Some((*x, (*error)?))).collect();
        let is_fixed = part[0].0.setting.substeps.fixed().is_some();
        let dash: &[f64] = if is_fixed { &[] } else { &[5.0, 4.0] };
        chart.curve(part[0].0.setting.method, dash, &line);
    }
    for (cell, x, error) in &points {
        match error {
            Some(error) => chart.point(cell.setting.method, *x, *error, &words(cell)),
            None => chart.failure(cell.setting.method, *x, &words(cell)),
        }
    }
    points.iter().any(|(.., error)| error.is_none())
}
