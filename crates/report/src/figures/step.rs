//! Error against step: on logarithms a method of order p has slope p.

use lab::cost::{Accuracy, Cell, Cost, Study};

use super::curves::{draw, error_axis, error_words, in_sight, run_cells, tooltip};
use crate::chart::{Axis, Chart, Drawing};
use crate::numbers::duration;

pub(super) fn figure(study: &Study, accuracy: Accuracy) -> Drawing {
    let own_error = match accuracy {
        Accuracy::Relative => study.truth.own_error().0,
        Accuracy::Position | Accuracy::Velocity => study.truth.own_error().1,
    };
    let x = Axis::logarithmic(
        "step",
        run_cells(study).map(|cell| study.step_s(cell.setting)),
        |seconds| duration(1e9 * seconds, 1),
    );
    let floor = in_sight(study, accuracy, run_cells(study), own_error);
    let y = error_axis(study, accuracy, run_cells(study), floor);
    let mut chart = Chart::new(format!("{}: error against step", study.subject), x, y, 620);
    let mut failed = false;
    for method in study.methods() {
        let place = |cell: &Cell| Some(study.step_s(cell.setting));
        let words = |cell: &Cell| tooltip(study, cell, accuracy, Cost::Evaluations);
        failed |= draw(&mut chart, study, study.curve(method), accuracy, place, words);
        let order = study.order(method, accuracy).filter(|order| order.is_finite());
        let order = order.map_or_else(String::new, |order| format!(": {order:.2}"));
        chart.legend_method(method, &format!("{}{order}", method.claims().title));
    }
    // After the curves, so that the words keep off them.
    if let Some(floor) = floor {
        chart.level(
            floor,
            &format!("error of the reference itself, {}", error_words(accuracy, floor)),
            false,
        );
    }
    chart.legend_note("numbers are fitted orders");
    if own_error > 0.0 && floor.is_none() {
        chart.legend_note(&format!("reference's own error: {}", error_words(accuracy, own_error)));
    }
    if failed {
        chart.legend_gap();
        chart.legend_failure("failed run");
    }
    chart.finish()
}
