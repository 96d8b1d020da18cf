//! A tick: the systems that integrate single bodies over the tables of the world, and the quarantine of bodies that
//! fail.

pub(crate) mod columns;
pub(crate) mod diagnosis;
pub(crate) mod environment;
pub(crate) mod integrate;
pub(crate) mod quarantine;
