//! Error against cost: the lower left is best.

use lab::cost::{Accuracy, Cell, Cost, Study};

use super::curves::{draw, error_axis, run_cells, tooltip};
use crate::chart::{Axis, Chart, Drawing};
use crate::numbers::{duration, fold, number, share};
use crate::palette::ink;
use crate::words;

/// Ratio of the budget to the highest cost from which on the budget is drawn at the edge: an axis that reached it
/// would crowd the points into a corner.
const FAR: f64 = 300.0;

pub(super) fn figure(study: &Study, accuracy: Accuracy, cost: Cost) -> Drawing {
    let placed = |cell: &Cell| study.cost_or_claim(cell, cost);
    let costs = || run_cells(study).filter_map(placed).filter(|cost| *cost > 0.0);
    let highest = costs().fold(0.0, f64::max);
    let budget = study.budget(cost).filter(|_| highest > 0.0);
    let near = budget.filter(|at| *at < FAR * highest);
    let x = Axis::logarithmic(title(cost), costs().chain(near), label(cost));
    let y = error_axis(study, accuracy, run_cells(study), None);
    let mut chart = Chart::new(format!("{}: error against cost", study.subject), x, y, 620);
    let front = study.front(accuracy, cost);
    let point = |cell| Some((study.cost(cell, cost)?, study.error(cell, accuracy)?));
    let line: Vec<_> = front.iter().copied().filter_map(point).collect();
    chart.front(&line);
    if let Some(at) = budget {
        let times = match near {
            Some(_) => String::new(),
            None => format!(", {} times further right", fold(at / highest)),
        };
        chart.budget(at, &format!("budget: all of a frame at 60 a second{times}"));
    }
    let mut failed = false;
    for method in study.methods() {
        let words = |cell: &Cell| tooltip(study, cell, accuracy, cost);
        failed |= draw(&mut chart, study, study.curve(method), accuracy, placed, words);
        failed |= draw(&mut chart, study, study.chosen(method), accuracy, placed, words);
        chart.legend_method(method, method.claims().title);
    }
    if study.methods().into_iter().any(|method| study.chosen(method).any(Cell::is_run)) {
        chart.legend_note("dashed: substeps are chosen");
    }
    chart.legend_gap();
    chart.legend_front("front: none cheaper and better");
    if failed {
        chart.legend_failure("failed run, at its cost");
    }
    let unpriced = run_cells(study).filter(|cell| placed(cell).is_none()).count();
    if unpriced > 0 {
        let runs = if unpriced == 1 { "run" } else { "runs" };
        chart.legend_note(&format!("{unpriced} {runs} without this cost"));
    }
    for cell in &front {
        if let Some((x, y)) = point(cell) {
            chart.name(x, y, &short(cell));
        }
    }
    let own = run_cells(study).find(|cell| cell.setting == study.own);
    if let Some((x, y)) = own.and_then(point) {
        let words = own.map(|cell| words::setting(study, cell)).unwrap_or_default();
        chart.ring(x, y, &format!("as the scene is set: {words}"));
        chart.legend_ring("as the scene is set");
    }
    if budget.is_some() {
        chart.legend_budget("budget of 60 frames a second");
    }
    chart.finish()
}

/// A short name of a setting, as "VV x4".
fn short(cell: &Cell) -> String {
    format!("{} {}", ink(cell.setting.method).short, words::times(cell.setting.substeps))
}

const fn title(cost: Cost) -> &'static str {
    match cost {
        Cost::Evaluations => "evaluations of a body's acceleration per simulated second",
        Cost::Time => "thread CPU time per body per simulated second",
        Cost::Arithmetic => "thread CPU time of the arithmetic alone per body per simulated second",
        Cost::RealTime => "thread CPU time of the whole, as a part of the time that it simulates",
    }
}

const fn label(cost: Cost) -> fn(f64) -> String {
    match cost {
        Cost::Evaluations => |value| number(value, 1),
        Cost::Time | Cost::Arithmetic => |value| duration(value, 1),
        Cost::RealTime => |value| share(value, 1),
    }
}
