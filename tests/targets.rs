//! Promises that hold for every input, as functions of bytes that panic where one is broken.
//!
//! A fuzzer chooses the bytes by what they reach (`tests/fuzz`), property tests by chance (`tests/fuzzing.rs`).

#![allow(clippy::unwrap_used, reason = "a test panics where it fails")]

mod bundles;
mod numbers;
mod readers;
mod scenes;
mod session;
mod step;

pub use bundles::bundle;
pub use readers::{mutated_scene, scene, script};
pub use session::session;
pub use step::step;

/// A target.
pub type Target = fn(&[u8]);

/// Every target by name.
pub const TARGETS: &[(&str, Target)] = &[
    ("scene", scene),
    ("mutated_scene", mutated_scene),
    ("script", script),
    ("bundle", bundle),
    ("session", session),
    ("step", step),
];
