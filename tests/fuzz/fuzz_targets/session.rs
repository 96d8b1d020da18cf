//! The target `session` of `tests/targets.rs`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| acceptance::targets::session(bytes));
