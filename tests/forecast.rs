//! Largest stable steps: measured, against closed forms, and foretold.

mod judged;
mod lattices;
mod limits;
mod natural;
mod nets;
mod panel;
mod program;
