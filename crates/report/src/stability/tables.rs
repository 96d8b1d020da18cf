//! The survival matrix as text.

use motion::Method;

use crate::numbers::number;
use crate::palette::ink;
use crate::tables;
use lab::stability::{Cell, Class, Matrix};

/// Columns of `matrix.csv`.
const HEADER: &str = "case,row,precision,measure,ticks,method,class,number,bound,why";

/// The methods of a matrix, in the order of its cells.
pub(super) fn methods(matrix: &Matrix) -> Vec<Method> {
    Method::ALL.into_iter().filter(|m| matrix.rows.iter().any(|row| row.cell(*m).is_some())).collect()
}

/// The number of a cell in few digits; infinite ones as a sign, none for what was refused.
pub(super) fn digits(cell: &Cell) -> String {
    match cell.number {
        _ if cell.class == Class::Refused => String::new(),
        n if n.is_finite() => number(n, 2),
        n if n.is_nan() => "NaN".to_owned(),
        n if n > 0.0 => "∞".to_owned(),
        _ => "-∞".to_owned(),
    }
}

/// Rows of cells for a terminal, with a heading.
#[must_use]
pub fn table(matrix: &Matrix) -> Vec<Vec<String>> {
    let methods = methods(matrix);
    let heading = ["case", "measure"].into_iter().chain(methods.iter().map(|method| ink(*method).short));
    let rows = matrix.rows.iter().map(|row| {
        let cells = methods.iter().map(|method| {
            let cell = row.cell(*method);
            cell.map_or_else(String::new, |cell| format!("{} {}", cell.class.name(), digits(cell)))
        });
        [row.title(), row.measure.clone()].into_iter().chain(cells).collect()
    });
    std::iter::once(heading.map(str::to_owned).collect()).chain(rows).collect()
}

/// A line a cell, numbers with all their digits.
#[must_use]
pub fn csv(matrix: &Matrix) -> String {
    let cells = matrix.rows.iter().flat_map(|row| row.cells.iter().map(move |cell| (row, cell)));
    let rows = cells.map(|(row, cell)| {
        vec![
            row.case.clone(),
            row.label.clone(),
            row.precision.name().to_owned(),
            row.measure.clone(),
            row.ticks.to_string(),
            cell.method.name().to_owned(),
            cell.class.name().to_owned(),
            exact(cell.number),
            exact(cell.bound),
            cell.why.clone(),
        ]
    });
    tables::csv(HEADER, rows)
}

/// All digits of a number; empty for what is none.
pub(super) fn exact(number: f64) -> String {
    if number.is_nan() { String::new() } else { format!("{number:e}") }
}

/// The classes as a table in Markdown; the good ones stand out.
#[must_use]
pub fn markdown(matrix: &Matrix) -> String {
    let methods = methods(matrix);
    let mut text = "| case |".to_owned();
    for method in &methods {
        text += &format!(" {} |", ink(*method).short);
    }
    text += &format!("\n|{}\n", " --- |".repeat(methods.len() + 1));
    for row in &matrix.rows {
        text += &format!("| {} |", row.title());
        for method in &methods {
            let word = row.cell(*method).map_or("", |cell| cell.class.name());
            let good = matches!(word, "exact" | "bounded");
            text += &if good { format!(" **{word}** |") } else { format!(" {word} |") };
        }
        text.push('\n');
    }
    text
}
