//! The target `bundle` of `tests/targets.rs`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| acceptance::targets::bundle(bytes));
