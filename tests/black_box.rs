//! The last minute of a run: going back in it, and the file that repeats it elsewhere.

mod energy;
mod going_back;
mod opened;
mod program;
mod recording;
mod seeks;
mod unpacked;

pub use going_back::with_a_fault;
