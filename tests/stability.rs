//! Survival: the committed matrix is what the program finds, and what theory says.

mod command;
mod committed;
mod theory;

use lab::stability::{Cell, Matrix};
use motion::Method;

use crate::rigs::root;

/// The matrix in the repository; `scripts/studies stability` makes it again.
pub fn committed() -> Matrix {
    let text = std::fs::read_to_string(root().join("docs/stability/matrix.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// The cell of a row, by its title, in the committed matrix.
#[track_caller]
fn cell(title: &str, method: Method) -> Cell {
    let matrix = committed();
    let row = matrix.rows.iter().find(|row| row.title() == title);
    row.unwrap_or_else(|| panic!("no row {title}")).cell(method).unwrap().clone()
}
