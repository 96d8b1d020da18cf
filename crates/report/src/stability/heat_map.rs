//! The matrix as a picture: a colored field a cell, with its class as a word and its number.

use crate::chart::{Drawing, WIDTH, escaped};
use crate::palette::ink;
use lab::stability::{Cell, Class, Matrix, Row};

use super::tables::{digits, methods};

/// Room of the names of rows, pixels.
const LEFT: u32 = 268;
/// Of the names of methods.
const TOP: u32 = 70;
/// Height of a row, and the gap between the rows of two cases.
const ROW: u32 = 34;
const GAP: u32 = 8;
/// What text stands on in a field; fields keep their colors on dark pages.
const INK: &str = "#1c2127";

/// The field of a class: light enough for dark text, of its own lightness for those who do not see colors.
const fn fill(class: Class) -> &'static str {
    match class {
        Class::Exact => "#7cc4a0",
        Class::Bounded => "#cdebd3",
        Class::Drifts => "#f7e6a4",
        Class::Decays => "#f0bd7c",
        Class::Explodes => "#e0897b",
        Class::Refused => "#c8ccd2",
    }
}

/// The picture of `matrix`.
pub(super) fn drawing(matrix: &Matrix) -> Drawing {
    let methods = methods(matrix);
    let columns = u32::try_from(methods.len()).unwrap_or(u32::MAX).max(1);
    let width = (WIDTH - LEFT - 10) / columns.max(6);
    let mut svg = legend();
    for (x, method) in (0..).map(|i| LEFT + i * width).zip(&methods) {
        svg += &format!(
            "<text class=\"ink\" x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-weight=\"600\" font-size=\"12\" fill=\"{INK}\">{}</text>\n",
            x + width / 2,
            TOP - 10,
            ink(*method).short
        );
    }
    let mut y = TOP;
    let mut last = None;
    for row in &matrix.rows {
        if last.is_some_and(|last| last != &row.case) {
            y += GAP;
        }
        last = Some(&row.case);
        svg += &format!(
            "<text class=\"ink\" x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"{INK}\">{}</text>\n",
            LEFT - 10,
            y + ROW / 2 + 5,
            escaped(&row.title())
        );
        for (x, method) in (0..).map(|i| LEFT + i * width).zip(&methods) {
            if let Some(cell) = row.cell(*method) {
                svg += &field(row, cell, (x, y, width));
            }
        }
        y += ROW;
    }
    Drawing::new(svg, y + 10, "What survives what: methods by hard cases".to_owned())
}

/// The classes and their fields, in a line.
fn legend() -> String {
    let item = |(i, class): (u32, Class)| {
        let x = 10 + i * 130;
        format!(
            "<rect x=\"{x}\" y=\"8\" width=\"22\" height=\"16\" rx=\"3\" fill=\"{}\"/>\
             <text class=\"ink\" x=\"{}\" y=\"21\" fill=\"{INK}\">{}</text>\n",
            fill(class),
            x + 30,
            class.name()
        )
    };
    (0..).zip(Class::ALL).map(item).collect()
}

fn field(row: &Row, cell: &Cell, (x, y, width): (u32, u32, u32)) -> String {
    let middle = x + width / 2;
    format!(
        "<g><title>{}</title><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"4\" fill=\"{}\"/>\
         <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\" font-weight=\"600\" fill=\"{INK}\">{}</text>\
         <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11\" fill=\"{INK}\">{}</text></g>\n",
        escaped(&told(row, cell)),
        x + 1,
        y + 1,
        width - 2,
        ROW - 2,
        fill(cell.class),
        y + 15,
        cell.class.name(),
        y + 28,
        digits(cell),
    )
}

/// What shows under the pointer.
fn told(row: &Row, cell: &Cell) -> String {
    let method = cell.method.claims().title;
    let mut told = format!("{}, {method}: {}", row.title(), cell.class.name());
    if cell.class != Class::Refused {
        told += &format!(", {} {}, held to {:e}", row.measure, digits(cell), cell.bound);
    }
    if cell.why.is_empty() { told } else { format!("{told}; {}", cell.why) }
}
