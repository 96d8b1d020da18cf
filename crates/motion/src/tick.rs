//! A tick of single bodies: the systems that integrate the tables of a world, and the quarantine of bodies that fail.

pub(crate) mod body_filter;
pub(crate) mod columns;
pub(crate) mod diagnosis;
pub(crate) mod environment;
pub(crate) mod follow_motion;
pub(crate) mod integrate;
pub(crate) mod quarantine;
