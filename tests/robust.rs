//! Numbers and times that a careless simulation breaks on.

mod damping;
mod extremes;
mod fall;
mod far;
mod frames;
mod subnormal;
