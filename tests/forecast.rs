//! Largest stable steps: measured, against closed forms, and foretold.

mod limits;
mod nets;
mod panel;
mod program;
