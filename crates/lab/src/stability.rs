//! Survival: every method on every hard case, each cell with the number that says so and the bound it is
//! held to.

mod class;
mod gauge;
mod host;
mod matrix;
mod record;
mod run;

pub use class::Class;
pub use matrix::Survey;
pub use record::{CaseRow, Cell, FORMAT, Matrix, PREFIX, Prefix};
