//! Presents the survival matrix: page, heat map and tables.

mod heat_map;
mod page;
mod tables;

use lab::stability::Matrix;

pub use tables::{markdown, matrix_csv, table};

/// What makes each of the [`files`]. `matrix.json` is the first, because it distinguishes the folder from one that a person filled.
const FILES: [(&str, fn(&Matrix) -> String); 5] = [
    ("matrix.json", Matrix::json),
    ("stability.html", page::page),
    ("matrix.svg", |matrix| heat_map::drawing(matrix).document()),
    ("matrix.csv", matrix_csv),
    ("matrix.md", markdown),
];

/// Whether [`files`] may have a file of that name, or had it in an earlier version, which wrote maps too.
pub fn is_file(name: &str) -> bool {
    FILES.iter().any(|(known, _)| *known == name) || name.ends_with(".svg")
}

/// The files of a report by their names: `stability.html` with everything in it, `matrix.svg`, `matrix.csv`, `matrix.md`
/// and `matrix.json`, which is read again.
pub fn files(matrix: &Matrix) -> Vec<(String, Vec<u8>)> {
    FILES.iter().map(|(name, make)| ((*name).to_owned(), make(matrix).into_bytes())).collect()
}
