//! The survival matrix on paper: page, heat map and tables.

mod heat_map;
mod limits;
mod maps;
mod page;
mod tables;

use lab::stability::Matrix;

pub use limits::{limits_csv, sections};
pub use maps::picture;
pub use page::Section;
pub use tables::{csv, markdown, table};

/// The files of a report by their names: `stability.html` with everything in it and `more` behind the matrix,
/// `matrix.svg`, `matrix.csv`, `matrix.md` and `matrix.json`, which is read again.
#[must_use]
pub fn files(matrix: &Matrix, more: &[Section]) -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("stability.html", page::page(matrix, more).into_bytes()),
        ("matrix.svg", heat_map::drawing(matrix).document().into_bytes()),
        ("matrix.csv", csv(matrix).into_bytes()),
        ("matrix.md", markdown(matrix).into_bytes()),
        ("matrix.json", matrix.json().into_bytes()),
    ]
}
