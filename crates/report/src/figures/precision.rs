//! Error against substeps in double, single and compensated single precision.

use lab::cost::{Accuracy, Cell, Cost, Precision, Study};
use motion::Method;

use super::curves::{draw, error_axis, error_words, in_sight, tooltip};
use crate::chart::{Axis, Chart, Drawing};
use crate::numbers::number;

/// More curves than three precisions of these are a tangle.
const MOST: usize = 4;

/// Those that have runs in single precision; of many, the ones that say most.
fn shown(study: &Study) -> Vec<Method> {
    let single = |method: &Method| {
        [Precision::F32, Precision::CompensatedF32]
            .into_iter()
            .any(|precision| study.methods(precision).contains(method))
    };
    let telling = [Method::SemiImplicitEuler, Method::VelocityVerlet, Method::RungeKutta4, study.own.method];
    let mut shown: Vec<_> = Method::ALL.into_iter().filter(single).collect();
    if shown.len() > MOST {
        shown.retain(|method| telling.contains(method));
    }
    shown
}

pub(super) fn figure(study: &Study) -> Option<Drawing> {
    let accuracy = Accuracy::Position;
    let shown = shown(study);
    let cells = || study.cells.iter().filter(|cell| shown.contains(&cell.setting.method) && cell.is_run());
    cells().next()?;
    let mut rungs: Vec<u32> = cells().map(|cell| cell.setting.substeps).collect();
    rungs.sort_unstable();
    rungs.dedup();
    let rungs: Vec<_> =
        rungs.into_iter().map(|substeps| (f64::from(substeps), format!("x {substeps}"))).collect();
    let x = Axis::rungs(format!("steps a tick, of {} ticks a second", number(study.step_hz, 3)), &rungs);
    let round_off = 0.5 * f64::from(f32::EPSILON) * study.position_scale_m;
    let floor = in_sight(study, accuracy, cells(), round_off);
    let y = error_axis(study, accuracy, cells(), floor);
    let mut chart = Chart::new(format!("{}: error against steps, by precision", study.subject), x, y, 620);
    let mut failed = false;
    let place = |cell: &Cell| Some(f64::from(cell.setting.substeps));
    let words = |cell: &Cell| {
        format!("{}, {}", tooltip(study, cell, accuracy, Cost::Evaluations), cell.setting.precision.name())
    };
    for method in &shown {
        for precision in Precision::ALL {
            failed |= draw(&mut chart, study, (*method, precision), accuracy, place, words);
        }
        chart.legend_method(*method, method.claims().title);
    }
    // After the curves, so that the words keep off them.
    let words = format!("one rounding of the farthest position to f32, {}", error_words(accuracy, round_off));
    if let Some(floor) = floor {
        chart.level(floor, &words, true);
    }
    chart.legend_gap();
    chart.legend_precision(Precision::F64, "double precision, f64");
    chart.legend_precision(Precision::F32, "single precision, f32");
    chart.legend_precision(Precision::CompensatedF32, "f32 with compensated sums");
    if failed {
        chart.legend_failure("failed run");
    }
    Some(chart.finish())
}
