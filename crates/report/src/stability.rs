//! Presents the survival matrix: page, heat map and tables.

mod heat_map;
mod page;
mod tables;

use lab::stability::Matrix;

pub use tables::{markdown, matrix_csv, table};

/// The names of [`files`]. `matrix.json` is the first, because it distinguishes the folder from one that a person filled.
const NAMES: [&str; 5] = ["matrix.json", "stability.html", "matrix.svg", "matrix.csv", "matrix.md"];

/// Whether [`files`] may have a file of that name, or had it in an earlier version, which wrote maps too.
pub fn is_file(name: &str) -> bool {
    NAMES.contains(&name) || name.ends_with(".svg")
}

/// The files of a report by their names: `stability.html` with everything in it, `matrix.svg`, `matrix.csv`, `matrix.md`
/// and `matrix.json`, which is read again.
pub fn files(matrix: &Matrix) -> Vec<(String, Vec<u8>)> {
    let texts = [
        matrix.json(),
        page::page(matrix),
        heat_map::drawing(matrix).document(),
        matrix_csv(matrix),
        markdown(matrix),
    ];
    NAMES.map(str::to_owned).into_iter().zip(texts.map(String::into_bytes)).collect()
}
