//! The targets of `tests/fuzz` on bytes by chance: a bounded number in every test run, more if `FUZZ_CASES` says so.
//!
//! The bytes are the same in every run, unless `FUZZ_SEED` is another number than 0. What once broke a promise is a
//! test of its own below.

use acceptance::targets::{TARGETS, Target};
use proptest::collection::vec;
use proptest::prelude::any;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

fn number(name: &str) -> Option<u32> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name}={text} is not a whole number")))
}

/// Runs the target `name` on `cases` inputs, or on as many as the environment says.
#[track_caller]
fn holds(name: &str, cases: u32) {
    let (_, target): &(&str, Target) = TARGETS.iter().find(|(other, _)| *other == name).unwrap();
    let config = Config {
        cases: number("FUZZ_CASES").unwrap_or(cases),
        failure_persistence: None,
        max_shrink_iters: 400,
        ..Config::default()
    };
    let mut seed = [0; 32];
    seed[..4].copy_from_slice(&number("FUZZ_SEED").unwrap_or(0).to_le_bytes());
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &seed));
    let result = runner.run(&vec(any::<u8>(), 0..1200), |bytes| {
        target(&bytes);
        Ok(())
    });
    if let Err(error) = result {
        panic!("{name}: {error}");
    }
}

#[test]
fn any_text_is_a_scene_or_refused() {
    holds("scene", 500);
}

#[test]
fn a_damaged_scene_is_read_or_refused() {
    holds("mutated_scene", 500);
}

#[test]
fn any_text_is_a_script_or_refused() {
    holds("script", 500);
}

#[test]
fn any_bytes_are_a_bundle_or_refused() {
    holds("bundle", 300);
}

#[test]
fn nothing_that_a_person_does_breaks_a_session() {
    holds("session", 200);
}

#[test]
fn nothing_that_is_asked_of_a_world_harms_another_body() {
    holds("step", 2000);
}
