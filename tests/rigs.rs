//! What tests build on: worlds made by hand, sessions that are driven, pictures, and the program.

mod dice;
mod drive;
mod environment;
mod film;
pub mod net;
mod program;

pub use dice::Dice;
pub use drive::*;
pub use environment::*;
pub use film::*;
pub use net::{Net, State, chain, elastic, extrapolated, pendulum, ring, tetrahedron};
pub use program::*;
