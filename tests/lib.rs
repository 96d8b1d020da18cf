//! The acceptance tests are the modules of `main.rs`; this crate has nothing else.
