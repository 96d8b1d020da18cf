//! The matrix as a picture: a colored field per cell, with its class as a word and its number.

use lab::stability::{CaseRow, Cell, Class, Matrix};

use super::tables::{digits, methods};
use crate::chart::{Anchor, Drawing, Rgb, Shape, WIDTH};
use crate::palette::ink;

/// Width of the names of rows, pixels.
const LEFT: f64 = 268.0;
/// Height of the names of methods, pixels.
const TOP: f64 = 70.0;
/// Height of a row, pixels.
const ROW: f64 = 34.0;
/// Gap between the rows of two cases, pixels.
const GAP: f64 = 8.0;

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
    let width = ((f64::from(WIDTH) - LEFT - 10.0) / methods.len().max(6) as f64).floor();
    let columns = || std::iter::successors(Some(LEFT), |x| Some(x + width)).zip(&methods);
    let mut shapes = Vec::new();
    for (x, class) in std::iter::successors(Some(10.0), |x| Some(x + 130.0)).zip(Class::ALL) {
        shapes.push(Shape::rectangles([[x, 8.0, 22.0, 16.0]]).fill(fill(class)));
        shapes.push(Shape::words(class.name()).at(x + 30.0, 21.0));
    }
    for (x, method) in columns() {
        shapes.push(
            middle(ink(*method).short).class("ink").sized(12.0).at(x + 0.5 * width, TOP - 10.0),
        );
    }
    let mut y = TOP;
    let mut last = None;
    for row in &matrix.rows {
        if last.is_some_and(|last| last != &row.case) {
            y += GAP;
        }
        last = Some(&row.case);
        shapes.push(
            Shape::words(row.title()).anchored(Anchor::End).at(LEFT - 10.0, y + 0.5 * ROW + 5.0),
        );
        for (x, method) in columns() {
            if let Some(cell) = row.cell(*method) {
                let field = Shape::rectangles([[x + 1.0, y + 1.0, width - 2.0, ROW - 2.0]]);
                shapes.push(field.fill(fill(cell.class)).tip(&tip(row, cell)));
                shapes.push(middle(cell.class.name()).at(x + 0.5 * width, y + 15.0));
                shapes.push(middle(&digits(cell)).sized(11.0).at(x + 0.5 * width, y + 28.0));
            }
        }
        y += ROW;
    }
    let height = y as u32 + 10;
    Drawing { title: "Survival: methods by hard cases".to_owned(), height, shapes }
}

/// Words in a field, which keep their color on dark pages as fields do.
fn middle(words: &str) -> Shape {
    Shape::words(words).class("").anchored(Anchor::Middle)
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
