//! Tables and lists of the page.

use crate::chart::escaped;
use crate::choice::answers;
use crate::figures::precision_methods;
use crate::numbers::{NONE, duration, fold, length, number, share};
use crate::ranking;
use crate::reading::{SEEN, failures as failed_runs};
use crate::tables::{ARRAYS, COLUMNS, listed, on_front, row};
use crate::words::{Topic, evaluations, setting, title, topics, tutorial_rounds};
use lab::cost::{Cell, Cost, Precision, RateRow, Report, Study};

/// A table with a row of headings.
pub(crate) fn table(class: &str, header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let cells = |tag: &str, row: &[String]| -> String {
        row.iter().map(|value| format!("<{tag}>{}</{tag}>", escaped(value))).collect()
    };
    let header: Vec<_> = header.iter().map(|&title| title.to_owned()).collect();
    let rows: String = rows.map(|row| format!("<tr>{}</tr>\n", cells("td", &row))).collect();
    format!(
        "<div class=\"wide\"><table class=\"{class}\">\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
        cells("th", &header)
    )
}

/// What was found in words, of the topics that are asked for.
pub(super) fn words(study: &Study, wanted: &[Topic]) -> String {
    let said = topics(study).into_iter().filter(|(topic, _)| wanted.contains(topic));
    let rows: String = said
        .map(|(topic, sentences)| {
            let text = if topic == Topic::Cheapest {
                cheapest(study)
            } else {
                sentences.iter().map(|sentence| format!("<p>{}</p>", escaped(sentence))).collect()
            };
            format!("<tr><th>{}</th><td>{text}</td></tr>\n", topic.title())
        })
        .collect();
    if rows.is_empty() { rows } else { format!("<table class=\"words\"><tbody>\n{rows}</tbody></table>\n") }
}

/// The cheapest setting for each error, as a table.
fn cheapest(study: &Study) -> String {
    let none = || NONE.to_owned();
    let of_cost = |cell, cost| study.cost(cell, cost);
    let rows = answers(study).into_iter().map(|answer| {
        let pick = answer.by_evaluations;
        let time = pick.time.as_ref().map_or_else(none, |time| duration(time.ns_per_body_step, 2));
        let part = of_cost(pick, Cost::RealTime).map_or_else(none, |part| share(part, 2));
        let next = answer
            .next
            .map_or_else(none, |(method, error)| format!("{}, below {}", title(method), length(error, 2)));
        vec![
            format!("below {}", length(answer.below_m, 2)),
            setting(study, pick),
            of_cost(pick, Cost::Evaluations).map_or_else(none, |cost| number(cost, 3)),
            time,
            part,
            next,
        ]
    });
    let header = [
        "error",
        "cheapest by evaluations",
        "evaluations per s",
        "time per body per step",
        "of real time",
        "becomes cheaper",
    ];
    table("numbers left", &header, rows)
}

/// Methods by the time of a step, and what each precision takes on arrays.
pub(super) fn times(study: &Study) -> String {
    let (ranked, arrays) = (ranking::rows(study), ranking::of_arrays(study));
    if ranked.is_empty() {
        return String::new();
    }
    let header = ranking::header(study);
    let header: Vec<_> = header.iter().map(String::as_str).collect();
    format!(
        "{}<p>= ties: the times differ by less than the spread of their rounds.</p>\n<details><summary>Times on plain \
         arrays</summary>\n{}</details>\n",
        table("numbers", &header, ranked.into_iter().map(Vec::from)),
        table("numbers", &ranking::ARRAYS, arrays.into_iter().map(Vec::from)),
    )
}

/// The tutorial's question, round by round.
pub(super) fn duel(study: &Study) -> String {
    let rounds = tutorial_rounds(study);
    if rounds.is_empty() {
        return String::new();
    }
    let error = |cell| study.error(cell, SEEN).map_or_else(|| "failed".to_owned(), |error| length(error, 2));
    let rows = rounds.iter().map(|round| {
        let verdict = match round.factor(study) {
            Some(factor) if factor >= 1.0 => format!("Runge-Kutta 4, {} times", fold(factor)),
            Some(factor) => format!("semi-implicit Euler, {} times", fold(factor.recip())),
            None => NONE.to_owned(),
        };
        vec![
            number(round.evaluations, 3),
            format!("x {}", round.first.setting.substeps),
            error(round.first),
            format!("x {}", round.second.setting.substeps),
            error(round.second),
            verdict,
        ]
    });
    let header =
        ["evaluations per s", "Runge-Kutta 4", "error", "semi-implicit Euler", "error", "smaller error"];
    format!(
        "<details><summary>The tutorial's question at every step: one step of Runge-Kutta 4, or four of semi-implicit \
         Euler</summary>\n{}</details>\n",
        table("numbers", &header, rows)
    )
}

/// Error, time and memory by precision.
pub(super) fn precision_table(study: &Study) -> String {
    let shown = precision_methods(study);
    let cells: Vec<_> =
        listed(study).into_iter().filter(|cell| shown.contains(&cell.setting.method)).collect();
    if cells.is_empty() {
        return String::new();
    }
    let rows = cells.iter().map(|cell| {
        let [method, substeps, precision, step, relative, error, ..] = row(study, cell);
        let time = cell
            .arrays_time
            .as_ref()
            .map_or_else(|| NONE.to_owned(), |time| duration(time.ns_per_body_step, 2));
        let bytes = cell.bytes_per_body_step.map_or_else(|| NONE.to_owned(), |bytes| number(bytes, 3));
        vec![method, substeps, precision, step, relative, error, time, bytes]
    });
    let header = [
        "method",
        "substeps",
        "precision",
        "step",
        "error, relative",
        "error",
        "time per body per step, on arrays",
        "bytes per body per step",
    ];
    format!(
        "<details><summary>Precision in numbers</summary>\n{}</details>\n",
        table("numbers", &header, rows)
    )
}

/// The same second at several frame rates.
pub(super) fn rates(study: &Study) -> String {
    if study.rates.is_empty() {
        return String::new();
    }
    let cells = |rate: &RateRow| {
        vec![
            number(rate.frame_hz, 3),
            rate.step.clone(),
            rate.damping.clone(),
            rate.push.clone(),
            rate.ticks.to_string(),
            rate.moved_m.map_or_else(|| "lost".to_owned(), |moved| length(moved, 3)),
            rate.off_m.map_or_else(|| "-".to_owned(), |off| length(off, 2)),
        ]
    };
    let header = ["frames a second", "step", "damping", "push", "ticks", "moved", "off"];
    format!(
        "<h3>The same second at several frame rates</h3>\n<p>A body pushed in the first frame: how far it comes, and how \
         far that is from where finer and finer steps have it.</p>\n{}",
        table("numbers", &header, study.rates.iter().map(cells))
    )
}

/// Runs that are crosses and no points.
pub(super) fn failures(study: &Study) -> String {
    let failed = failed_runs(study);
    if failed.is_empty() {
        return String::new();
    }
    let rows = failed.iter().map(|group| {
        let title = group.method.claims().title.to_owned();
        vec![title, group.precision.name().to_owned(), group.substeps().join(", "), group.why()]
    });
    let header = ["method", "precision", "substeps", "why"];
    format!("<h3>Runs that failed</h3>\n{}", table("plain", &header, rows))
}

/// Every cell that was run.
pub(super) fn details(study: &Study) -> String {
    let cells = |cell: &Cell| {
        let mut row = row(study, cell).to_vec();
        row.push(if cell.setting.precision == Precision::F64 && on_front(study, cell) {
            "front".to_owned()
        } else {
            String::new()
        });
        row
    };
    let header: Vec<_> = COLUMNS.into_iter().chain([""]).collect();
    format!(
        "<details><summary>Every run in numbers</summary>\n{}<p>{ARRAYS}</p></details>\n",
        table("numbers", &header, listed(study).into_iter().map(cells))
    )
}

/// What a reader has to know.
pub(super) fn notes(study: &Study) -> String {
    let own = study.cells.iter().find(|cell| cell.setting == study.own);
    let own = own.map(|cell| {
        let cost = study.cost(cell, Cost::Evaluations).unwrap_or(f64::NAN);
        format!("As the scene is set: {}, {}.", setting(study, cell), evaluations(study, cost))
    });
    let items: String =
        own.iter().chain(&study.notes).map(|note| format!("<li>{}</li>\n", escaped(note))).collect();
    if items.is_empty() { items } else { format!("<ul class=\"notes\">\n{items}</ul>\n") }
}

/// Where it was measured, and how.
pub(super) fn machine(report: &Report) -> String {
    let machine = &report.machine;
    let rows = [
        ("Processor", format!("{} ({} cores)", machine.processor, machine.cores)),
        ("System", machine.system.clone()),
        ("Vector instructions", machine.instructions.clone()),
        ("Version", machine.version.clone()),
        ("Compiler", machine.compiler.clone()),
        ("Command", report.command.clone()),
    ];
    let rows: String =
        rows.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>\n", escaped(value))).collect();
    format!(
        "<footer>\n<h2>Measured on</h2>\n<dl>\n{rows}</dl>\n<p>Error and time are measured in runs of their own: the one \
         is compared with the truth at eight times and looks at no clock, the other is timed in thread CPU time, block by \
         block, the least of several, in turns with a fixed yardstick. Relative errors are the largest over bodies and \
         times of the distances in position and velocity together, each in units of the motion's own scale; a run that \
         blew up, was quarantined or did not converge is a cross and never a point.</p>\n</footer>\n"
    )
}
