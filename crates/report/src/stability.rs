//! Presents the survival matrix: page, heat map and tables.

mod heat_map;
mod page;
mod tables;

use lab::stability::Matrix;

pub use tables::{markdown, matrix_csv, table};

/// Whether [`files`] may have a file of that name.
pub fn is_file(name: &str) -> bool {
    let texts = ["stability.html", "matrix.csv", "matrix.md", "matrix.json"];
    texts.contains(&name) || name.ends_with(".svg")
}

/// The files of a report by their names: `stability.html` with everything in it, `matrix.svg`, `matrix.csv`, `matrix.md`
/// and `matrix.json`, which is read again.
pub fn files(matrix: &Matrix) -> Vec<(String, Vec<u8>)> {
    let files = [
        // First, because this file distinguishes the folder from one that a person filled.
        ("matrix.json".to_owned(), matrix.json()),
        ("stability.html".to_owned(), page::page(matrix)),
        ("matrix.svg".to_owned(), heat_map::drawing(matrix).document()),
        ("matrix.csv".to_owned(), matrix_csv(matrix)),
        ("matrix.md".to_owned(), markdown(matrix)),
    ];
    files.into_iter().map(|(name, text)| (name, text.into_bytes())).collect()
}
