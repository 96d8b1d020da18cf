//! A grid: cells of color in rows and columns, with the names of both.

use super::{Anchor, Drawing, Rgb, Shape, WIDTH};

/// Width of the names of rows, pixels.
const LEFT: f64 = 300.0;
/// Top of the legend, pixels.
const LEGEND: f64 = 44.0;
/// Top of the first row, pixels.
const TOP: f64 = 92.0;
/// Gap between rows, pixels.
const GAP: f64 = 8.0;
/// Most columns that are named.
const MOST_NAMES: usize = 10;
/// Fewest columns that fill the width.
const FEWEST: usize = 6;

/// A cell of a grid.
pub(crate) struct Cell {
    pub color: Rgb,
    /// Words under the pointer.
    pub tip: String,
    /// Words in it, one below the other.
    pub words: Option<[String; 2]>,
}

/// Cells side by side; `None` where there is none.
pub(crate) struct Row {
    pub name: String,
    /// Whether a gap is above it.
    pub is_apart: bool,
    pub cells: Vec<Option<Cell>>,
}

/// Cells of color in rows and columns.
pub(crate) struct Grid {
    pub title: String,
    pub legend: Vec<Shape>,
    /// Name of what differs from column to column, and the names of the columns.
    pub columns: (String, Vec<String>),
    pub rows: Vec<Row>,
    /// A note below the rows.
    pub note: Option<String>,
}

impl Grid {
    /// An entry of the legend at `x`.
    pub(crate) fn legend_entry(x: f64, color: Rgb, words: &str) -> [Shape; 2] {
        let field = Shape::rectangles([[x, LEGEND, 18.0, 14.0]]).fill(color);
        [field, Self::legend_words(x + 26.0, words)]
    }

    /// Words in the legend at `x`.
    pub(crate) fn legend_words(x: f64, words: &str) -> Shape {
        Shape::words(words).sized(12.0).at(x, LEGEND + 12.0)
    }

    /// A scale in the legend, from `x` on, of colors at positions from 0 to 1.
    pub(crate) fn legend_scale(x: f64, color: impl Fn(f64) -> Rgb) -> impl Iterator<Item = Shape> {
        (0..64_u8).map(move |step| {
            let part = f64::from(step) / 64.0;
            Shape::rectangles([[x + 256.0 * part, LEGEND, 4.2, 14.0]]).fill(color(part))
        })
    }

    pub(crate) fn drawing(self) -> Drawing {
        let Self { title, legend, columns: (what, columns), rows, note } = self;
        let width = (f64::from(WIDTH) - LEFT - 20.0) / columns.len().max(FEWEST) as f64;
        let has_words =
            rows.iter().flat_map(|row| row.cells.iter().flatten()).any(|cell| cell.words.is_some());
        let low = if rows.len() > 24 { 12.0 } else { 22.0 };
        let height = if has_words { 34.0 } else { low };
        let x_of = |column: usize| LEFT + column as f64 * width;
        let middle = |words: &str, column: usize, y: f64| {
            let words = Shape::words(words).anchored(Anchor::Middle).sized(11.0);
            words.at(x_of(column) + 0.5 * width, y)
        };
        let mut shapes = vec![Shape::words(&title).sized(17.0).at(16.0, 28.0)];
        shapes.extend(legend);
        let every = columns.len().div_ceil(MOST_NAMES).max(1);
        for (column, name) in columns.iter().enumerate().step_by(every) {
            shapes.push(middle(name, column, TOP - 10.0));
        }
        let mut y = TOP;
        for (number, Row { name, is_apart, cells }) in rows.into_iter().enumerate() {
            y += if is_apart && number > 0 { GAP } else { 0.0 };
            let name = Shape::words(&name).anchored(Anchor::End).sized(12.0);
            shapes.push(name.at(LEFT - 8.0, y + 0.5 * height + 4.0));
            for (column, cell) in cells.into_iter().enumerate() {
                let Some(Cell { color, tip, words }) = cell else { continue };
                let place = [x_of(column), y, width - 0.5, height - 0.5];
                shapes.push(Shape::rectangles([place]).fill(color).tip(&tip));
                // Words in a cell keep their color on dark pages, as cells do.
                let lines = words.iter().flatten().zip([15.0, 28.0]);
                shapes.extend(lines.map(|(words, at)| middle(words, column, y + at).class("")));
            }
            y += height;
        }
        if !what.is_empty() {
            y += 20.0;
            let middle = 0.5 * (LEFT + x_of(columns.len()));
            shapes.push(Shape::words(&what).anchored(Anchor::Middle).at(middle, y));
        }
        if let Some(note) = note {
            y += 20.0;
            shapes.push(Shape::soft_words(note).at(16.0, y));
        }
        Drawing { title, height: y as u32 + 16, shapes }
    }
}
