//! Largest stable steps: measured, against closed forms, and foretold.

mod judged;
mod lattices;
mod limits;
mod nets;
mod panel;
mod program;
