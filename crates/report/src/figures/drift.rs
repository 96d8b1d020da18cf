//! Energy that methods invent or lose, over time.

use lab::cost::{Drift, Study};

use crate::chart::{Axis, Chart, Drawing};
use crate::numbers::{number, power};
use crate::words::{fate, short_fate, times};

/// Smaller residuals are drawn at this one, the round-off of one sum, because a logarithm has no zero.
const FOOT: f64 = 1e-17;

pub(super) fn figure(study: &Study, long: bool) -> Option<Drawing> {
    let drifts: Vec<_> = study.drifts.iter().filter(|drift| drift.long == long).collect();
    let simulated_s = drifts.iter().map(|drift| drift.simulated_s).reduce(f64::max)?;
    let lines: Vec<_> = drifts.iter().map(|drift| largest_so_far(drift)).collect();
    let x = Axis::linear("simulated time, s", simulated_s, |value| number(value, 3));
    let residuals = lines.iter().flatten().map(|(_, residual)| *residual);
    let y = Axis::logarithmic("energy invented or lost so far, as a part of it", residuals, power);
    let run = if long { "a long run" } else { "a short run" };
    let title = format!("{}: energy over {run}", study.subject);
    let mut chart = Chart::new(title, x, y, 540);
    for (drift, line) in drifts.iter().zip(&lines) {
        let method = drift.setting.method;
        let name = format!("{} {}", method.claims().title, times(drift.setting.substeps));
        let words = format!("{name}: {}", fate(drift));
        chart.curve(method, &[], line);
        if let Some((time, residual)) = line.last() {
            chart.point(method, *time, *residual, &words);
        }
        if drift.largest.is_none() {
            chart.failure(method, line.last().map_or(0.0, |(time, _)| *time), &words);
        }
        chart.legend_method(method, &name);
        chart.legend_note(&short_fate(drift));
    }
    Some(chart.finish())
}

/// Times, s, and the largest residual until then, because a residual that swings through zero is not better there.
fn largest_so_far(drift: &Drift) -> Vec<(f64, f64)> {
    let finite = drift.series.iter().take_while(|(_, residual)| residual.is_finite());
    let mut largest = FOOT;
    finite
        .map(|(time, residual)| {
            largest = largest.max(residual.abs());
            (*time, largest)
        })
        .collect()
}
