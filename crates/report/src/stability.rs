//! The survival matrix on paper: page, heat map and tables.

mod heat_map;
mod maps;
mod page;
mod tables;

use lab::limits::{Limit, Map};
use lab::stability::Matrix;

pub use maps::picture;
pub use tables::{limits_csv, markdown, matrix_csv, table};

/// Whether [`files`] may have a file of that name.
pub fn is_file(name: &str) -> bool {
    let texts = ["stability.html", "matrix.csv", "matrix.md", "matrix.json", "limits.csv"];
    texts.contains(&name) || name.ends_with(".svg")
}

/// The files of a report by their names: `stability.html` with everything in it, `matrix.svg`, `matrix.csv`, `matrix.md`
/// and `matrix.json`, which is read again; `limits.csv` and the maps where they were measured.
pub fn files(matrix: &Matrix, limits: &[Limit], maps: &[(&str, Map)]) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![
        // First: it tells the folder from one that a person filled.
        ("matrix.json".to_owned(), matrix.json()),
        ("stability.html".to_owned(), page::page(matrix, limits, maps)),
        ("matrix.svg".to_owned(), heat_map::drawing(matrix).document()),
        ("matrix.csv".to_owned(), matrix_csv(matrix)),
        ("matrix.md".to_owned(), markdown(matrix)),
    ];
    if !limits.is_empty() {
        files.push(("limits.csv".to_owned(), limits_csv(limits)));
    }
    files.extend(maps.iter().map(|(name, map)| (format!("{name}-map.svg"), picture(map).document())));
    files.into_iter().map(|(name, text)| (name, text.into_bytes())).collect()
}
