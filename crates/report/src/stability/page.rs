//! The matrix as one page that needs nothing beside it.

use scene::Measure;

use super::heat_map::drawing;
use super::tables::{digits, methods};
use crate::chart::escaped;
use crate::page::{STYLE, table};
use lab::stability::{Cell, Class, Matrix, Row};

/// A part of the page behind the matrix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// Its heading, plain text.
    pub title: String,
    /// HTML: tables, figures, paragraphs.
    pub body: String,
}

/// The page.
pub(super) fn page(matrix: &Matrix, more: &[Section]) -> String {
    let title = "What survives what";
    let more: String = more.iter().map(|part| section(&escaped(&part.title), &part.body)).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n\
         <p class=\"lead\">Every method of integration on every hard case: what became of the run, the number that says so, and \
         the bound that it is held to.</p>\n</header>\n<main>\n{}{more}</main>\n</body>\n</html>\n",
        section("Matrix", &body(matrix))
    )
}

fn section(title: &str, body: &str) -> String {
    format!("<section>\n<h2>{title}</h2>\n{body}</section>\n")
}

fn body(matrix: &Matrix) -> String {
    [
        counts(matrix),
        format!(
            "<figure>\n{}<figcaption>A field a run, with its class and its number; under the pointer it says why.\
             </figcaption>\n</figure>\n",
            drawing(matrix).inline()
        ),
        reading(),
        cases(matrix),
        details(matrix),
    ]
    .concat()
}

/// How many rows each method survives.
fn counts(matrix: &Matrix) -> String {
    let header: Vec<_> = std::iter::once("method").chain(Class::ALL.map(Class::name)).collect();
    let rows = methods(matrix).into_iter().map(|method| {
        let of = |class| {
            let cells = matrix.rows.iter().filter_map(|row| row.cell(method));
            cells.filter(|cell| cell.class == class).count().to_string()
        };
        std::iter::once(method.claims().title.to_owned()).chain(Class::ALL.map(of)).collect()
    });
    table("numbers", &header, rows)
}

/// What classes and measures mean.
fn reading() -> String {
    let class = |class: Class| match class {
        Class::Exact => "as exact as rounding lets it be, all the way",
        Class::Bounded => "within its bound, all the way: of use",
        Class::Drifts => "beyond its bound at some time",
        Class::Decays => "what was to be kept is lost at the end, by more than the bound",
        Class::Explodes => "beyond all bounds, or not finite: the run was given up, or a body frozen",
        Class::Refused => "the method cannot solve what the scene declares, and says so",
    };
    let measure = |measure: Measure| match measure {
        Measure::Energy => {
            "energy that the method invented (positive) or lost, relative to that at the start"
        }
        Measure::Reference => {
            "farthest that a body is from where a fine run has it, relative to the longest way"
        }
        Measure::Origin => "the same from where the method itself has it at the origin in double precision",
        Measure::Rest => "kinetic energy of what should be at rest, relative to m g L",
        Measure::Stretch => "largest strain of a spring",
        Measure::TerminalSpeed => {
            "speed at the end relative to the terminal one, minus 1: -1 stands, below -1 rises"
        }
    };
    let classes = Class::ALL.map(|it| (it.name(), class(it)));
    let measures = Measure::ALL.map(|it| (it.name(), measure(it)));
    let rows = classes.into_iter().chain(measures);
    let rows: String =
        rows.map(|(word, what)| format!("<dt>{word}</dt><dd>{}</dd>\n", escaped(what))).collect();
    format!("<h3>How to read it</h3>\n<dl>\n{rows}</dl>\n")
}

/// What every case is.
fn cases(matrix: &Matrix) -> String {
    let mut rows: Vec<&Row> = matrix.rows.iter().collect();
    rows.dedup_by(|row, before| row.case == before.case);
    let rows =
        rows.into_iter().map(|row| vec![row.case.clone(), row.description.clone(), row.measure.clone()]);
    format!("<h3>The cases</h3>\n{}", table("plain", &["case", "what it is", "measure"], rows))
}

/// Every cell with its bound and why.
fn details(matrix: &Matrix) -> String {
    let cells = matrix.rows.iter().flat_map(|row| row.cells.iter().map(move |cell| (row, cell)));
    let rows = cells.map(|(row, cell): (&Row, &Cell)| {
        let bound = if cell.bound.is_nan() { String::new() } else { format!("{:e}", cell.bound) };
        vec![
            row.title(),
            cell.method.name().to_owned(),
            cell.class.name().to_owned(),
            digits(cell),
            bound,
            row.ticks.to_string(),
            cell.why.clone(),
        ]
    });
    let header = ["case", "method", "class", "number", "held to", "ticks", "why"];
    format!("<details><summary>Every run in numbers</summary>\n{}</details>\n", table("plain", &header, rows))
}
