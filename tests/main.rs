//! Acceptance tests: what the program promises, through public names, offscreen and without sleeping.
#![allow(clippy::unwrap_used, reason = "a test panics where it fails")]
#![allow(clippy::float_cmp, reason = "equal bits are what these tests ask for")]
#![allow(
    clippy::wildcard_enum_match_arm,
    clippy::match_wildcard_for_single_variants,
    reason = "a test is of some of them"
)]
#![allow(clippy::cast_precision_loss, reason = "counts of ticks are small")]

mod bad_input;
mod black_box;
mod bounds;
mod choosing;
mod cockpit;
mod contract;
mod controls;
mod cost;
mod cost_report;
mod damping;
mod determinism;
mod documents;
mod editor;
mod effects;
mod embed;
mod first_screen;
mod forces;
mod forecast;
mod fuzzing;
mod ghosts;
mod graphs;
mod groups;
mod hands;
mod ledger;
mod lessons;
mod looks;
mod methods;
mod moves;
mod newton;
mod outputs;
mod panels;
mod picking;
mod pixels;
mod plans;
mod quarantine;
mod recommend;
mod rigs;
mod robust;
mod scripts;
#[cfg(unix)]
mod setup;
mod snapshot;
mod soft;
mod soft_picking;
mod soft_pixels;
mod soft_scenes;
mod stability;
mod states;
mod swarms;
mod sweep;
mod tidy;
mod time;
mod transcription;
mod tutorial;
mod window;
