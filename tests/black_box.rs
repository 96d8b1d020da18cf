//! The last minute of a run: going back in it, and the file that repeats it elsewhere.

mod going_back;
mod program;
mod recording;
