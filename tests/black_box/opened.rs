//! Bundles that are opened as sessions.

use history::Bundle;
use motion::Substeps;
use sandbox::clock::FrameClock;
use sandbox::input::Input;
use sandbox::report::state_hash;
use sandbox::{Options, Repetition, Session};

use super::going_back::{go, recording, with_a_fault};
use crate::rigs::{Drive, push, tap};

/// A session of what `bundle` is when it was a file, at the end of its run.
fn reopened(bundle: &Bundle, interpolate: bool) -> (Drive, Repetition) {
    let bundle = Bundle::read(&bundle.write().unwrap()).unwrap();
    let options = Options { pictures: false, interpolate, ..Options::default() };
    let (session, repetition) =
        Session::of_bundle(&bundle, "box.zip", options, &mut |_| ()).unwrap();
    (Drive { session, clock: FrameClock::default() }, repetition)
}

/// A run of 60 ticks with pushes and gravity.
fn recorded() -> (Drive, Vec<u64>) {
    let mut drive = recording();
    let hashes = go(&mut drive, 0..60);
    (drive, hashes)
}

#[test]
fn an_opened_bundle_has_every_tick_of_its_run_and_repeats_it_until_its_end() {
    let (mut then, hashes) = recorded();
    let bundle = then.session.stage.bundle(None).unwrap();
    let later = go(&mut then, 60..90);
    for interpolate in [true, false] {
        let (mut drive, repetition) = reopened(&bundle, interpolate);
        assert!(repetition.same() && repetition.fault.is_none(), "{repetition:?}");
        assert!(drive.session.stage.playback().paused() && drive.session.stage.recorder().is_on());
        assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (60, hashes[59]));
        for tick in (50..60).rev() {
            drive.press(",");
            assert_eq!(
                (drive.session.stage.sim().ticks(), drive.hash()),
                (tick, hashes[tick as usize - 1])
            );
        }
        drive.session.seek(0);
        drive.press("P");
        for hash in &hashes {
            drive.frame(1.0 / 60.0, []);
            assert_eq!(drive.hash(), *hash, "tick {}", drive.session.stage.sim().ticks());
        }
        let again = drive.session.stage.bundle(None).unwrap();
        assert_eq!(
            (&again.manifest, &again.events),
            (&bundle.manifest, &bundle.events),
            "nothing is recorded again"
        );
        // From there on it is a run like any other.
        assert_eq!(go(&mut drive, 60..90), later);
        drive.session.seek(75);
        assert_eq!(drive.hash(), later[14]);
        let again = drive.session.stage.bundle(None).unwrap();
        assert_eq!((again.manifest.snapshot_tick, again.manifest.end_tick), (0, 90));
        assert!(reopened(&again, interpolate).1.same());
    }
}

#[test]
fn a_bundle_of_the_last_minute_of_a_longer_run_with_inputs_repeats_it() {
    let mut drive = recording();
    for tick in 0..65 * 60 {
        let along = if tick % 2 == 0 { 0.5 } else { -0.5 };
        drive.frame(1.0 / 60.0, [push("ball", [along, 0.0, 0.0])]);
    }
    let bundle = drive.session.stage.bundle(None).unwrap();
    assert!(bundle.manifest.snapshot_tick > 0, "nothing was dropped");
    let (again, repetition) = reopened(&bundle, false);
    assert!(repetition.same(), "{repetition:?}");
    assert_eq!(again.hash(), drive.hash());
}

#[test]
fn counts_of_evaluations_are_repeated_too() {
    let (then, _) = recorded();
    let (mut drive, _) = reopened(&then.session.stage.bundle(None).unwrap(), true);
    assert_eq!(drive.session.stage.sim().evaluations(), then.session.stage.sim().evaluations());
    drive.session.seek(10);
    drive.press("P").frames(50);
    assert_eq!(drive.session.stage.sim().evaluations(), then.session.stage.sim().evaluations());
}

#[test]
fn what_is_done_by_hand_drops_what_came_after() {
    let (then, hashes) = recorded();
    let (mut drive, _) = reopened(&then.session.stage.bundle(None).unwrap(), true);
    drive.session.seek(20);
    drive.press("P").frames(5);
    assert_eq!(drive.hash(), hashes[24]);
    drive.frame(1.0 / 60.0, [push("second", [0.0, 50.0, 0.0])]);
    assert_ne!(drive.hash(), hashes[25]);
    drive.session.seek(60);
    assert_eq!(drive.session.stage.sim().ticks(), 26, "the rest is gone");
    drive.session.seek(25);
    assert_eq!(drive.hash(), hashes[24]);

    // A change between two ticks, and another method.
    for key in ["G", "I"] {
        let (mut drive, _) = reopened(&then.session.stage.bundle(None).unwrap(), true);
        drive.session.seek(20);
        drive.press(key).press(".");
        drive.session.seek(60);
        assert_eq!(drive.session.stage.sim().ticks(), 21, "{key}");
        assert!(reopened(&drive.session.stage.bundle(None).unwrap(), true).1.same(), "{key}");
    }
}

#[test]
fn a_fault_is_met_again_and_gone_through_to_the_same_end() {
    let (bundle, hashes) = with_a_fault();
    let (mut drive, repetition) = reopened(&bundle, true);
    assert!(repetition.same(), "{repetition:?}");
    assert_eq!(repetition.fault, bundle.manifest.fault);
    let fault = drive.session.stage.recorder().fault().unwrap().clone();
    assert_eq!(Some(fault.named(&drive.session.stage.sim().scene.names)), bundle.manifest.fault);
    assert_eq!(drive.session.stage.quarantines().so_far().len(), 1);
    drive.session.rewind_before_fault();
    for _ in 0..2 {
        assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (20, hashes[19]));
        assert!(
            drive.session.stage.playback().paused()
                && drive.session.stage.quarantines().so_far().is_empty()
        );
        assert_eq!(drive.selected().as_deref(), Some("second"));
        // It is met once; after that it is known.
        drive.press("P").frame(1.0 / 60.0, []);
    }
    assert_eq!(drive.session.stage.sim().ticks(), 21);
    assert_eq!(format!("{:016x}", drive.hash()), bundle.manifest.end_state_hash);
    assert_eq!(drive.session.stage.quarantines().so_far()[0].body, "second");
    assert_eq!(drive.session.stage.recorder().fault(), Some(&fault));
    drive.press(",").press(",");
    assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (19, hashes[18]));
}

#[test]
fn energy_out_of_nowhere_stops_a_session_at_the_last_good_tick_and_its_bundle_meets_it_again() {
    let mut drive = Drive::text(super::program::STIFF).recording();
    let start = drive.hash();
    drive.run(10, 0.01);
    assert!(drive.session.stage.playback().paused() && drive.session.tools.ledger().is_none());
    let fault = drive.session.stage.recorder().fault().unwrap().clone();
    assert_eq!((drive.session.stage.sim().ticks(), fault.tick, drive.hash()), (0, 1, start));
    assert_eq!(drive.selected().as_deref(), Some("ball"));
    let (mut again, repetition) = reopened(&drive.session.stage.bundle(None).unwrap(), true);
    assert!(repetition.same(), "{repetition:?}");
    again.session.rewind_before_fault();
    again.press("P").run(10, 0.01);
    assert_eq!(
        (again.session.stage.sim().ticks(), again.session.stage.recorder().fault()),
        (0, Some(&fault))
    );
    // Going on goes through it, and it stays known.
    again.press("P").run(10, 0.01);
    assert_eq!(
        (again.session.stage.sim().ticks(), again.session.stage.recorder().fault()),
        (10, Some(&fault))
    );
}

#[test]
fn a_fault_in_the_same_tick_after_something_else_was_done_is_another_one() {
    let mut drive = Drive::text(super::program::STIFF).recording();
    drive.run(10, 0.01);
    assert_eq!(drive.session.stage.sim().ticks(), 0);
    // Another method that explodes, and a push.
    for events in [tap("Shift+I").to_vec(), vec![push("ball", [0.0, 1.0, 0.0])]] {
        drive.give(events).press("P").run(10, 0.01);
        assert!(drive.session.stage.playback().paused());
        assert_eq!(
            (
                drive.session.stage.sim().ticks(),
                drive.session.stage.recorder().fault().unwrap().tick
            ),
            (0, 1)
        );
    }
    drive.press("P").run(10, 0.01);
    assert_eq!(drive.session.stage.sim().ticks(), 10);
}

#[test]
fn a_fault_writes_nothing_unasked() {
    let mut drive = Drive::text(super::program::STIFF).recording();
    assert!(drive.run(10, 0.01).session.stage.playback().paused());
    assert_eq!(drive.session.stage.take_orders(), []);
    drive.press("Ctrl+S");
    assert_eq!(drive.session.stage.take_orders(), [sandbox::Order::Bundle]);
    let bundle = drive.session.stage.bundle(None).unwrap();
    assert_eq!(bundle.manifest.fault.as_ref().unwrap().tick, 1);
}

/// A thrown ball, one tick per frame.
fn thrown() -> Drive {
    Drive::text(
        "(version: 1, step: frame, gravity: (), bodies: [(name: \"ball\", velocity_m_s: (3, 8, 0))])",
    )
}

#[test]
fn steps_of_frames_are_repeated_with_their_own_lengths() {
    let length = |frame: u32| 0.01 + 0.001 * f64::from(frame % 7);
    let mut then = thrown().recording();
    (0..40).for_each(|frame| {
        then.frame(length(frame), []);
    });
    let mut steady = thrown();
    assert_ne!(steady.run(40, 0.02).hash(), then.hash(), "the lengths of steps change nothing");
    let (mut drive, repetition) = reopened(&then.session.stage.bundle(None).unwrap(), true);
    assert!(repetition.same(), "{repetition:?}");
    drive.session.seek(5);
    drive.press("P").run(35, 0.02);
    assert_eq!(
        (drive.session.stage.sim().ticks(), state_hash(&drive.session.stage)),
        (40, then.hash())
    );
}

/// The last step before and the first step after going back have the same length, which differs from that in between.
#[test]
fn a_bundle_made_after_going_back_repeats_the_steps_that_were_taken_then() {
    let mut drive = thrown().recording();
    drive.run(3, 0.01).frame(0.02, []);
    drive.session.seek(3);
    drive.press("P").frame(0.02, []);
    let (again, repetition) = reopened(&drive.session.stage.bundle(None).unwrap(), false);
    assert!(repetition.same(), "{repetition:?}");
    assert_eq!(
        (again.session.stage.sim().ticks(), again.hash()),
        (drive.session.stage.sim().ticks(), drive.hash())
    );
    let mut straight = thrown();
    straight.run(3, 0.01).run(u32::try_from(drive.session.stage.sim().ticks()).unwrap() - 3, 0.02);
    assert_eq!(drive.hash(), straight.hash());
}

#[test]
fn going_back_brings_back_the_substeps_of_then() {
    let substeps =
        |count| Input::Change(scene::ChangeAction::SetSubsteps(scene::Substepping::Fixed(count)));
    let mut drive = recording();
    let mut hashes = go(&mut drive, 0..20);
    drive.give([substeps(7)]);
    hashes.extend(go(&mut drive, 20..40));
    for tick in [10, 20, 30, 40] {
        drive.session.seek(tick);
        let sim = drive.session.stage.sim();
        let now = sim.world.resource::<Substeps>().0;
        assert_eq!(sim.scene.substeps.fixed(), Some(now), "ghosts and a reset begin with them");
        assert_eq!((now == 7, drive.hash()), (tick > 20, hashes[tick as usize - 1]), "tick {tick}");
    }
    // And from there on.
    drive.session.seek(10);
    drive.press("P");
    let mut never = recording();
    let expected = go(&mut never, 0..30);
    assert_eq!(go(&mut drive, 10..30), expected[10..]);
    assert_ne!(expected[20..], hashes[20..30], "substeps change nothing");
}

#[test]
fn a_reset_of_an_opened_bundle_is_its_scene_from_the_start() {
    let (mut then, hashes) = recorded();
    let (mut drive, _) = reopened(&then.session.stage.bundle(None).unwrap(), true);
    then.press("F1");
    drive.press("F1").press("P");
    assert_ne!(drive.hash(), hashes[59]);
    assert_eq!(go(&mut drive, 0..10), go(&mut then, 0..10));
    assert_eq!(drive.session.stage.sim().ticks(), 70);
    drive.session.seek(0);
    assert_eq!(drive.session.stage.sim().ticks(), 60, "its timeline is a new one");
}

#[test]
fn what_comes_out_otherwise_is_said() {
    let (then, _) = recorded();
    let mut bundle = then.session.stage.bundle(None).unwrap();
    bundle.manifest.keyframes[1].state_hash = "0".repeat(16);
    bundle.manifest.fault =
        Some(history::FaultEntry { tick: 9, body: None, what: "something else".to_owned() });
    let (_, repetition) = reopened(&bundle, false);
    assert!(!repetition.same());
    let expected =
        ["the state differs from tick 32 on", "no fault instead of tick 9: something else"];
    assert_eq!(repetition.differences(&bundle.manifest), expected);
    bundle.manifest.end_tick = 0;
    bundle.manifest.snapshot_tick = 1;
    let Err(error) = Session::of_bundle(&bundle, "box.zip", Options::default(), &mut |_| ()) else {
        panic!("opened")
    };
    let error = error.to_string();
    assert!(error.starts_with("box.zip: the ticks of the bundle contradict each other"), "{error}");
}
