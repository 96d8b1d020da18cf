//! The files of a study for other programs: every cell, every sample of energy, every frame rate.

use lab::cost::{Accuracy, Cell, Cost, Report, Setting, Study, Time};

use super::table::csv;
use super::tables::outcome;

/// The columns of `cells.csv`, one row per cell: lengths in m, times as their names say, empty where nothing was
/// measured.
pub const CELLS_HEADER: &str = "subject,method,substeps,step_s,relative_error,position_error_m,\
    velocity_error_m_s,outcome,evaluations_per_body_s,ns_per_body_step,real_time_factor,\
    yardsticks,timed_bodies,position_rms_m,arithmetic_ns_per_body_step";

const DRIFT_HEADER: &str = "subject,method,substeps,long,time_s,relative_residual";

const RATES_HEADER: &str = "subject,frame_hz,step,damping,push,ticks,moved_m,off_m";

/// A number in full precision; empty if it is not finite.
fn plain(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map(|value| format!("{value:e}")).unwrap_or_default()
}

/// Subject, method and substeps.
fn named(study: &Study, setting: Setting) -> Vec<String> {
    let Setting { method, substeps } = setting;
    vec![study.subject.clone(), method.name().to_owned(), substeps.to_string()]
}

/// `cells.csv`.
pub(crate) fn cells(report: &Report) -> String {
    let row = |study: &Study, cell: &Cell| {
        let time = |of: fn(&Time) -> f64| plain(cell.time.as_ref().map(of));
        let error = |accuracy| plain(study.error(cell, accuracy));
        let mut row = named(study, cell.setting);
        row.extend([
            plain(Some(study.mean_step_s(cell))),
            error(Accuracy::Relative),
            error(Accuracy::Position),
            error(Accuracy::Velocity),
            outcome(cell),
            plain(study.cost(cell, Cost::Evaluations)),
            time(|time| time.ns_per_body_step),
            time(|time| time.real_time_factor),
            time(|time| time.yardsticks),
            study.size().to_string(),
            plain(cell.errors().map(|errors| errors.position_rms_m)),
            plain(cell.arithmetic_time.as_ref().map(|time| time.ns_per_body_step)),
        ]);
        row
    };
    let rows = report
        .studies
        .iter()
        .flat_map(|study| study.cells.iter().map(move |cell| row(study, cell)));
    csv(CELLS_HEADER, rows)
}

/// `drift.csv`: one row per sample.
pub(crate) fn drift(report: &Report) -> String {
    let drifts = report
        .studies
        .iter()
        .flat_map(|study| study.drifts.iter().map(move |drift| (study, drift)));
    let rows = drifts.flat_map(|(study, drift)| {
        drift.series.iter().map(move |(time_s, residual)| {
            let mut row = named(study, drift.setting);
            row.extend([drift.long.to_string(), plain(Some(*time_s)), plain(Some(*residual))]);
            row
        })
    });
    csv(DRIFT_HEADER, rows)
}

/// `rates.csv`: one row per frame rate and way of stepping.
pub(crate) fn rates(report: &Report) -> String {
    let rates =
        report.studies.iter().flat_map(|study| study.rates.iter().map(move |rate| (study, rate)));
    let rows = rates.map(|(study, rate)| {
        vec![
            study.subject.clone(),
            plain(Some(rate.frame_hz)),
            rate.step.clone(),
            rate.damping.clone(),
            rate.push.clone(),
            rate.ticks.to_string(),
            plain(rate.moved_m),
            plain(rate.off_m),
        ]
    });
    csv(RATES_HEADER, rows)
}
