//! Every cell as rows: comma-separated values for other programs, and columns of text for a terminal.

use super::numbers::{NONE, duration, length, number};
use super::ranking;
use super::reading::{SEEN, ran};
use lab::cost::{Accuracy, Cell, Cost, Outcome, Precision, Report, Study, Time};

/// The columns of `cells.csv`, one row a cell: lengths in m, times as their names say, empty where nothing was
/// measured.
pub const CELLS_HEADER: &str = "subject,method,substeps,precision,step_s,relative_error,position_error_m,\
    velocity_error_m_s,outcome,evaluations_per_body_s,ns_per_body_step,arrays_ns_per_body_step,real_time_factor,\
    yardsticks,bytes_per_body_step,instructions_per_tick,timed_bodies";

const DRIFT_HEADER: &str = "subject,method,substeps,precision,long,time_s,relative_residual";

const RATES_HEADER: &str = "subject,frame_hz,step,damping,push,ticks,moved_m,off_m";

/// A field as RFC 4180 has it.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// In full precision; empty for what is no number.
fn plain(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map(|value| format!("{value:e}")).unwrap_or_default()
}

/// Rows under a header, as RFC 4180 has them.
pub(crate) fn csv(header: &str, rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut text = header.to_owned() + "\n";
    for row in rows {
        text += &row.iter().map(|value| field(value)).collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

/// `cells.csv`.
pub(crate) fn cells_csv(report: &Report) -> String {
    let rows =
        report.studies.iter().flat_map(|study| study.cells.iter().map(move |cell| cell_row(study, cell)));
    csv(CELLS_HEADER, rows)
}

fn cell_row(study: &Study, cell: &Cell) -> Vec<String> {
    let time = |of: fn(&Time) -> f64| plain(cell.time.as_ref().map(of));
    let error = |accuracy| plain(study.error(cell, accuracy));
    vec![
        study.subject.clone(),
        cell.setting.method.name().to_owned(),
        cell.setting.substeps.to_string(),
        cell.setting.precision.name().to_owned(),
        plain(Some(study.step_s(cell.setting))),
        error(Accuracy::Relative),
        error(Accuracy::Position),
        error(Accuracy::Velocity),
        outcome(cell),
        plain(study.cost(cell, Cost::Evaluations)),
        time(|time| time.ns_per_body_step),
        plain(cell.arrays_time.as_ref().map(|time| time.ns_per_body_step)),
        time(|time| time.real_time_factor),
        time(|time| time.yardsticks),
        plain(cell.bytes_per_body_step),
        plain(cell.instructions_per_tick),
        study.size().to_string(),
    ]
}

/// `finished`, or why not.
pub(crate) fn outcome(cell: &Cell) -> String {
    match &cell.outcome {
        Outcome::Finished(_) => "finished".to_owned(),
        Outcome::Failed(failure) => failure.to_string(),
    }
}

/// `drift.csv`: one row a sample.
pub(crate) fn drift_csv(report: &Report) -> String {
    let drifts = report.studies.iter().flat_map(|study| study.drifts.iter().map(move |drift| (study, drift)));
    let rows = drifts.flat_map(|(study, drift)| {
        drift.series.iter().map(move |(time_s, residual)| {
            vec![
                study.subject.clone(),
                drift.setting.method.name().to_owned(),
                drift.setting.substeps.to_string(),
                drift.setting.precision.name().to_owned(),
                drift.long.to_string(),
                plain(Some(*time_s)),
                plain(Some(*residual)),
            ]
        })
    });
    csv(DRIFT_HEADER, rows)
}

/// `rates.csv`: one row a frame rate and way of stepping.
pub(crate) fn rates_csv(report: &Report) -> String {
    let rates = report.studies.iter().flat_map(|study| study.rates.iter().map(move |rate| (study, rate)));
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

/// Titles of the columns of a table of cells.
pub(crate) const COLUMNS: [&str; 9] = [
    "method",
    "substeps",
    "precision",
    "step",
    "error, relative",
    "error",
    "evaluations per body per s",
    "per body per step",
    "times real time",
];

/// A cell in few digits, under [`COLUMNS`]; a failed one has its reason for an error.
pub(crate) fn row(study: &Study, cell: &Cell) -> [String; 9] {
    let time = match cell.setting.precision {
        Precision::F64 => cell.time.as_ref(),
        _ => cell.arrays_time.as_ref(),
    };
    let error = |accuracy| study.error(cell, accuracy);
    [
        cell.setting.method.claims().title.to_owned(),
        cell.setting.substeps.to_string(),
        cell.setting.precision.name().to_owned(),
        duration(1e9 * study.step_s(cell.setting), 3),
        error(Accuracy::Relative).map_or_else(|| outcome(cell), |error| number(error, 2)),
        error(SEEN).map_or_else(|| NONE.to_owned(), |error| length(error, 2)),
        study.cost(cell, Cost::Evaluations).map_or_else(|| NONE.to_owned(), |cost| number(cost, 3)),
        time.map_or_else(|| NONE.to_owned(), |time| duration(time.ns_per_body_step, 2)),
        time.map_or_else(|| NONE.to_owned(), |time| number(time.real_time_factor, 2)),
    ]
}

/// The cells that were run, by method, precision and substeps.
pub(crate) fn listed(study: &Study) -> Vec<&Cell> {
    let mut cells: Vec<_> = study.cells.iter().filter(|cell| ran(cell)).collect();
    cells.sort_by_key(|cell| (cell.setting.method, cell.setting.precision, cell.setting.substeps));
    cells
}

/// What a table of cells does not say itself.
pub(crate) const ARRAYS: &str =
    "Times in f64 are of the world of entities, those in single precision of plain arrays.";

/// Whether a cell is on the front of positions, by evaluations or by time.
pub(crate) fn on_front(study: &Study, cell: &Cell) -> bool {
    let on = |cost| study.front(SEEN, cost).iter().any(|other| other.setting == cell.setting);
    on(Cost::Evaluations) || on(Cost::Time)
}

/// Methods by the time of a step, then every cell that was run, with a star on those of the front; columns line up.
#[must_use]
pub fn table(study: &Study) -> String {
    let marked = |cell| {
        let mut row = row(study, cell);
        row[0] = format!("{} {}", if on_front(study, cell) { "*" } else { " " }, row[0]);
        row
    };
    let mut header = COLUMNS.map(str::to_owned);
    header[0] = format!("  {}", header[0]);
    let rows: Vec<_> = [header].into_iter().chain(listed(study).into_iter().map(marked)).collect();
    let ranked = ranking::rows(study);
    let mut text = String::new();
    if !ranked.is_empty() {
        let rows: Vec<_> = [ranking::header(study)].into_iter().chain(ranked).collect();
        text += &aligned(&rows);
        text += "= ties with the first of its rank: the times differ by less than the spread of their rounds.\n\n";
    }
    text += &aligned(&rows);
    text + "* on the front: nothing is both cheaper and more accurate. " + ARRAYS + "\n"
}

/// Lines whose columns line up: words to the left, numbers to the right.
fn aligned<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<_> = (0..N).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let padded = row.iter().zip(&widths).enumerate().map(|(column, (value, width))| {
            if column == 0 { format!("{value:<width$}") } else { format!("{value:>width$}") }
        });
        text += padded.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
    }
    text
}
