//! The survival matrix as text.

use lab::stability::{CaseRow, Cell, Class, Matrix};
use motion::Method;

use crate::numbers::number;
use crate::palette::ink;
use crate::table::{Table, csv};

/// Columns of `matrix.csv`.
const HEADER: &str = "case,row,measure,ticks,method,class,number,bound,why";

/// The methods of a matrix, in the order of its cells.
pub(super) fn methods(matrix: &Matrix) -> Vec<Method> {
    Method::ALL
        .into_iter()
        .filter(|m| matrix.rows.iter().any(|row| row.cell(*m).is_some()))
        .collect()
}

/// The number of a cell in few digits; a sign if it is infinite, empty if the method was refused.
pub(super) fn digits(cell: &Cell) -> String {
    match cell.number {
        _ if cell.class == Class::Refused => String::new(),
        n if n.is_finite() => number(n, 2),
        n if n.is_nan() => "NaN".to_owned(),
        n if n > 0.0 => "∞".to_owned(),
        _ => "-∞".to_owned(),
    }
}

/// One row per case, one column per method, with the short names of methods.
fn by_method(matrix: &Matrix, columns: &[&str], cell: impl Fn(&Cell) -> String) -> Table {
    let methods = methods(matrix);
    let header = columns.iter().copied().chain(methods.iter().map(|method| ink(*method).short));
    let rows = matrix.rows.iter().map(|row| {
        let words = [row.title(), row.measure.clone()].into_iter().take(columns.len());
        words
            .chain(methods.iter().map(|method| row.cell(*method).map_or_else(String::new, &cell)))
            .collect()
    });
    Table::words("Matrix", header, rows)
}

/// Classes and numbers, for a terminal.
pub fn table(matrix: &Matrix) -> Table {
    by_method(matrix, &["case", "measure"], |cell| {
        format!("{} {}", cell.class.name(), digits(cell))
    })
}

/// The classes as a table in Markdown; the good ones stand out.
pub fn markdown(matrix: &Matrix) -> String {
    let word = |cell: &Cell| match (cell.class.name(), cell.class) {
        (word, Class::Exact | Class::Bounded) => format!("**{word}**"),
        (word, _) => word.to_owned(),
    };
    by_method(matrix, &["case"], word).markdown()
}

/// How many rows each method survives.
pub(super) fn counts(matrix: &Matrix) -> Table {
    let rows = methods(matrix).into_iter().map(|method| {
        let of = |class| {
            let cells = matrix.rows.iter().filter_map(|row| row.cell(method));
            cells.filter(|cell| cell.class == class).count().to_string()
        };
        std::iter::once(method.claims().title.to_owned()).chain(Class::ALL.map(of)).collect()
    });
    Table::numbers(
        "Rows by class",
        std::iter::once("method").chain(Class::ALL.map(Class::name)),
        rows,
    )
}

/// The description of every case.
pub(super) fn cases(matrix: &Matrix) -> Table {
    let mut rows: Vec<_> = matrix.rows.iter().collect();
    rows.dedup_by(|row, before| row.case == before.case);
    let rows = rows
        .into_iter()
        .map(|row| vec![row.case.clone(), row.description.clone(), row.measure.clone()]);
    Table::words("The cases", ["case", "what it is", "measure"], rows)
}

/// Every cell with its row.
fn cells(matrix: &Matrix) -> impl Iterator<Item = (&CaseRow, &Cell)> {
    matrix.rows.iter().flat_map(|row| row.cells.iter().map(move |cell| (row, cell)))
}

/// Every cell with its bound and its note.
pub(super) fn details(matrix: &Matrix) -> Table {
    let rows = cells(matrix).map(|(row, cell)| {
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
    Table::words("Every run in numbers", header, rows)
}

/// One line per cell, numbers with all their digits.
pub fn matrix_csv(matrix: &Matrix) -> String {
    let rows = cells(matrix).map(|(row, cell)| {
        vec![
            row.case.clone(),
            row.label.clone(),
            row.measure.clone(),
            row.ticks.to_string(),
            cell.method.name().to_owned(),
            cell.class.name().to_owned(),
            exact(cell.number),
            exact(cell.bound),
            cell.why.clone(),
        ]
    });
    csv(HEADER, rows)
}

/// All digits of a number; empty for NaN.
fn exact(number: f64) -> String {
    if number.is_nan() { String::new() } else { format!("{number:e}") }
}
