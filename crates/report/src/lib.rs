//! Presents the results of studies: pages, figures, tables, files for other programs, and a few sentences.
//!
//! Everything here is a function of the data; nothing is measured or decided, and no file is written.
//!
//! - [`files`]: all files of a report of accuracy and cost. `page` is the one in HTML, `csv` has those for other programs.
//! - [`summary`](brief): a study as Markdown and for a terminal; `tables` has its tables, `words` its sentences, and `reading` what
//!   both are taken from.
//! - `figures`: the figures of a study; `chart` draws one, with axes, marks and a legend, as SVG ([`Drawing`]).
//! - `forecast`: the rows of a forecast ([`ForecastRow`]).
//! - [`stability`]: the survival matrix as page, picture and tables, and the maps of stable steps.
//! - [`sweep`]: the runs of a sweep as CSV and as a figure.
//! - [`Table`]: a table in HTML, Markdown, CSV or for a terminal. [`numbers`]: numbers as people read them.
//! - [`INKS`]: the color and the short name of each method. `escape`: text of files, so that no part of it is interpreted.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test"))]

mod chart;
mod csv;
mod escape;
mod figures;
mod forecast;
mod handout;
pub mod numbers;
mod page;
mod palette;
pub mod stability;
mod summary;
pub mod sweep;
mod table;
mod tables;
mod words;

use figures::figures;
use lab::cost::{Report, Study};
use page::slugs;

pub use chart::Drawing;
pub use csv::CELLS_HEADER;
pub use escape::terminal;
pub use forecast::{ForecastRow, Instrument, growth, tried_in_words};
pub use handout::{Handout, HandoutStep, answers, handout, index};
pub use palette::{INKS, Ink, REFERENCE_INK, ink};
pub use summary::{brief, markdown, table, text};
pub use table::{Table, aligned, csv, csv_line};
pub use tables::{prices, tables};
pub use words::{time_words, words};

const TEXTS: [(&str, fn(&Report) -> String); 6] = [
    ("report.html", page::page),
    ("report.json", json),
    ("summary.md", summary),
    ("cells.csv", csv::cells),
    ("drift.csv", csv::drift),
    ("rates.csv", csv::rates),
];

/// Whether [`files`] may have a file of that name: one of its texts, or any picture.
pub fn is_file(name: &str) -> bool {
    TEXTS.iter().any(|(text, _)| *text == name) || name.ends_with(PICTURE)
}

/// Suffix of the file names of figures.
const PICTURE: &str = ".svg";

/// The files of a report by their names, none of which has a folder: `report.html` with everything in it, `report.json`
/// as [`Report`] is read again, `summary.md`, `cells.csv`, `drift.csv`, `rates.csv`, and each figure as SVG.
/// Each file is made when the iterator reaches it.
pub fn files(report: &Report) -> impl Iterator<Item = (String, Vec<u8>)> {
    let texts = TEXTS.into_iter().map(|(name, text)| (name.to_owned(), text(report).into_bytes()));
    let figures =
        drawn(report).map(|(name, figure)| (name + PICTURE, figure.document().into_bytes()));
    texts.chain(figures)
}

/// The report as JSON, which is read again.
pub fn json(report: &Report) -> String {
    serde_json::to_string_pretty(report).expect("a report is plain data") + "\n"
}

/// The results of every study, as Markdown.
fn summary(report: &Report) -> String {
    let part = |study: &Study| {
        format!("## {}\n\n{}", escape::markdown(&study.subject), markdown(study, &report.machine))
    };
    report.studies.iter().map(part).collect::<Vec<_>>().join("\n")
}

/// Figures by their names without an ending.
fn drawn(report: &Report) -> impl Iterator<Item = (String, Drawing)> {
    report.studies.iter().zip(slugs(&report.studies)).flat_map(|(study, slug)| {
        figures(study, &report.machine)
            .into_iter()
            .map(move |(kind, drawing)| (format!("{slug}-{}", kind.name()), drawing))
    })
}
