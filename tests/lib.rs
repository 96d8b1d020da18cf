//! What the acceptance tests, which are the modules of `main.rs`, share with the fuzz targets of `fuzz/` and the program
//! `mutants`.

pub mod mutants;
pub mod targets;

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
