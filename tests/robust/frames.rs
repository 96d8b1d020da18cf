//! Frame times that no clock should give, through a session and through the command line.

use motion::{PhysicsBody, Transform};
use sandbox::clock::BadTime;

use crate::rigs::{Drive, folder, json, sandbox};

/// Lengths of frames, s: none, next to none, a hitch, a usual one.
const FRAMES: [f64; 9] = [1.0 / 60.0, 0.0, 1e-9, 1.0, 0.0, 1.0 / 60.0, 1e-300, 100.0, 1.0 / 60.0];

fn is_finite(drive: &Drive) -> bool {
    drive.session.stage.sim().world.iter_entities().all(|entity| {
        entity.get::<Transform>().is_none_or(|at| at.position.is_finite())
            && entity.get::<PhysicsBody>().is_none_or(|body| body.velocity.is_finite())
    })
}

#[test]
fn a_session_takes_any_frame_time_that_is_one() {
    let mut drive = Drive::tutorial();
    drive.press("G");
    let (mut dropped, mut ticks) = (0.0, drive.session.stage.sim().ticks());
    for length in FRAMES {
        let (before, hash) = (drive.session.stage.sim().ticks(), drive.hash());
        drive.frame(length, []);
        let due = drive.session.stage.sim().ticks() - before;
        ticks += due;
        // A quarter of a second at 120 Hz, and what it is not caught up with is told.
        assert!(due <= 30, "{length}: {due} ticks");
        if length < 1e-3 {
            assert_eq!((due, drive.hash()), (0, hash), "{length}");
        }
        if length >= 1.0 {
            dropped += length - 0.25;
            assert_eq!(due, 30, "{length}");
        }
        assert!(
            (drive.session.stage.playback().dropped() - dropped).abs() <= 1e-6,
            "{length}: {}",
            drive.session.stage.playback().dropped()
        );
    }
    // The state is that of as many ticks in a row.
    let mut plain = Drive::tutorial();
    plain.press("G");
    while plain.session.stage.sim().ticks() < ticks {
        plain.ticks(1);
    }
    assert_eq!(plain.hash(), drive.hash());
}

#[test]
fn a_bad_frame_time_is_refused_before_it_reaches_a_session() {
    let mut drive = Drive::tutorial();
    drive.frames(3);
    let hash = drive.hash();
    for length in [-1.0, -1e-300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let refused = drive.clock.advance_by(length);
        let negative = matches!(refused, Err(BadTime::Negative(_)));
        assert!(refused.is_err() && (negative || !length.is_finite()), "{length}: {refused:?}");
        drive.frame(0.0, []);
        assert_eq!(drive.hash(), hash, "{length}");
    }
    drive.frame(1.0 / 60.0, []);
    assert_eq!(drive.session.stage.sim().ticks(), 8);
}

/// None, next to none and a whole second are steps like others.
#[test]
fn a_step_a_frame_survives_every_length() {
    let mut drive = Drive::shipped("frame_step");
    drive.press("G");
    for length in FRAMES {
        let hash = drive.hash();
        drive.frame(length, []);
        if length == 0.0 {
            assert_eq!(drive.hash(), hash);
        }
        assert!(
            is_finite(&drive) && drive.session.stage.quarantines().so_far().is_empty(),
            "{length}"
        );
    }
}

#[test]
fn the_command_line_takes_the_same_frame_times() {
    let lines: Vec<_> = FRAMES.iter().map(|length| format!("{length:e}\n")).collect();
    let folder = folder([("odd.times", lines.concat())]);
    for scene in ["tutorial", "frame_step"] {
        let line = format!("run {scene} --frame-times odd.times --summary out.json --seconds 0.5");
        sandbox(&folder, &line).fine();
        let summary = json(folder.path().join("out.json"));
        assert_eq!(summary["quarantined"], serde_json::json!([]), "{line}");
        assert!(summary["simulated_s"].as_f64().is_some_and(f64::is_finite), "{line}");
    }
}
