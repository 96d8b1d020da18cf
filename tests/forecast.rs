//! Forecasts: margins beside the largest stable steps, and trials beside finer runs.

mod campaign;
mod lattices;
mod limits;
mod looking;
mod natural;
mod nets;
mod panel;
mod program;
