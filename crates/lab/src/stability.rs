//! The survival matrix: every method on every hard case, each cell with its class, the number that decided it, and
//! the bound on that number.

mod class;
mod matrix;
mod metric;
mod record;
mod row_run;
mod run;

pub use class::Class;
pub use matrix::StabilityRun;
pub use record::{CaseRow, Cell, FORMAT, Matrix, PREFIX, Prefix};
