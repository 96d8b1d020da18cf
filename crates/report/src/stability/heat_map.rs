//! The matrix as a picture: a colored field per cell, with its class as a word and its number.

use lab::stability::{CaseRow, Cell, Class, Matrix};

use super::tables::{digits, methods};
use crate::chart::{Cell as Colored, Drawing, Grid, Rgb, Row};
use crate::palette::ink;

/// The color of a class: light enough for dark text, and of its own lightness for people who do not see colors.
const fn fill(class: Class) -> Rgb {
    match class {
        Class::Exact => [0x7c, 0xc4, 0xa0],
        Class::Bounded => [0xcd, 0xeb, 0xd3],
        Class::Drifts => [0xf7, 0xe6, 0xa4],
        Class::Decays => [0xf0, 0xbd, 0x7c],
        Class::Explodes => [0xe0, 0x89, 0x7b],
        Class::Refused => [0xc8, 0xcc, 0xd2],
    }
}

/// The picture of `matrix`.
pub(super) fn drawing(matrix: &Matrix) -> Drawing {
    let methods = methods(matrix);
    let colored = |row: &CaseRow, cell: &Cell| Colored {
        color: fill(cell.class),
        tip: tip(row, cell),
        words: Some([cell.class.name().to_owned(), digits(cell)]),
    };
    let mut last = None;
    let rows = matrix.rows.iter().map(|row| Row {
        name: row.title(),
        is_apart: last.replace(&row.case) != Some(&row.case),
        cells: methods.iter().map(|method| Some(colored(row, row.cell(*method)?))).collect(),
    });
    let places = std::iter::successors(Some(16.0), |x| Some(x + 130.0));
    let entries = places.zip(Class::ALL);
    Grid {
        title: "Survival: methods by hard cases".to_owned(),
        rows: rows.collect(),
        legend: entries
            .flat_map(|(x, class)| Grid::legend_entry(x, fill(class), class.name()))
            .collect(),
        columns: (String::new(), methods.iter().map(|m| ink(*m).short.to_owned()).collect()),
        note: None,
    }
    .drawing()
}

/// The text that is shown under the pointer.
fn tip(row: &CaseRow, cell: &Cell) -> String {
    let method = cell.method.claims().title;
    let mut tip = format!("{}, {method}: {}", row.title(), cell.class.name());
    if cell.class != Class::Refused {
        tip += &format!(", {} {}, held to {:e}", row.measure, digits(cell), cell.bound);
    }
    if cell.why.is_empty() { tip } else { format!("{tip}; {}", cell.why) }
}
