//! Sessions that go back in time.

use glam::DVec3;
use history::Bundle;
use motion::Gravity;
use sandbox::input::Input;
use sandbox::report::state_hash;

use crate::rigs::{Drive, H, change, mixed, push, tap, write_step_hz};

pub fn recording() -> Drive {
    Drive::of(mixed()).recording()
}

/// A tick a frame, with pushes and gravity now and then.
pub fn go(drive: &mut Drive, ticks: std::ops::Range<u32>) -> Vec<u64> {
    let tick = |tick: u32| {
        let mut inputs = Vec::new();
        if tick % 9 == 3 {
            inputs.push(push("ball", [2.0, 0.0, 1.0]));
        }
        if tick % 25 == 11 {
            inputs.extend(tap("G"));
        }
        drive.frame(1.0 / 60.0, inputs);
        state_hash(&drive.session.stage)
    };
    ticks.map(tick).collect()
}

/// A bundle of a run that a push breaks in tick 21, and the hashes after the ticks before it.
pub fn with_a_fault() -> (Bundle, Vec<u64>) {
    let mut drive = recording();
    let hashes = go(&mut drive, 0..20);
    drive.frame(1.0 / 60.0, [push("second", [f64::NAN, 0.0, 0.0])]);
    (drive.session.stage.bundle(None).unwrap(), hashes)
}

#[test]
fn a_comma_goes_one_tick_back_and_a_dot_forward_again() {
    let mut drive = recording();
    let hashes = go(&mut drive, 0..60);
    for tick in (40..60).rev() {
        drive.press(",");
        assert!(drive.session.stage.playback().paused());
        assert_eq!(drive.session.stage.sim().ticks(), tick);
        assert_eq!(drive.hash(), hashes[usize::try_from(tick).unwrap() - 1]);
    }
    drive.press(".").press(".");
    assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (42, hashes[41]));
    // That dropped what came after: there is nothing to go forward to.
    drive.session.seek(60);
    assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (42, hashes[41]));
}

#[test]
fn going_on_from_the_past_is_going_on_as_if_the_future_had_never_been() {
    let mut never = Drive::of(mixed());
    let expected = go(&mut never, 0..50);
    let mut drive = recording();
    go(&mut drive, 0..30);
    drive.frame(1.0 / 60.0, [push("second", [0.0, 50.0, 0.0])]).frames(20);
    drive.session.seek(30);
    assert_eq!(drive.hash(), expected[29]);
    drive.press("P");
    assert_eq!(go(&mut drive, 30..50), expected[30..]);
    assert_eq!(drive.session.stage.sim().evaluations(), never.session.stage.sim().evaluations());
}

#[test]
fn selection_and_ledger_go_along_and_a_reset_or_another_scene_restarts() {
    let mut drive = recording();
    drive.session.tools.keep_ledger(&drive.session.stage);
    drive.press("Q");
    let ball = drive.pixel(drive.x("ball"));
    assert_eq!(drive.select(ball).as_deref(), Some("ball"));
    go(&mut drive, 0..20);
    drive.session.seek(12);
    assert_eq!(drive.selected().as_deref(), Some("ball"));
    assert_eq!(drive.session.tools.ledger().unwrap().seconds(), 0.0);
    drive.press("P");
    go(&mut drive, 12..20);
    assert!(drive.session.tools.ledger().unwrap().seconds() > 0.1);
    drive.press("F1");
    let began = drive.session.stage.sim().ticks();
    drive.press(",");
    assert_eq!(drive.session.stage.sim().ticks(), began, "nothing is before a reset");
    drive.session.open(scene::load("oscillator").unwrap());
    drive.frames(3);
    let (ticks, hash) = (drive.session.stage.sim().ticks(), drive.hash());
    drive.frames(3);
    drive.session.seek(ticks);
    assert_eq!(drive.hash(), hash);
}

#[test]
fn ticks_are_asked_for_as_often_as_their_length_says_that_was_gone_back_to() {
    let mut drive = Drive::tutorial().recording();
    let in_a_second = |drive: &mut Drive| {
        let before = drive.session.stage.sim().ticks();
        drive.frames(60).session.stage.sim().ticks() - before
    };
    assert_eq!(in_a_second(&mut drive), 120);
    let _ = drive.session.controls();
    drive.press("Q").press("Tab").ticks(2);
    write_step_hz(&mut drive);
    drive.frame(H, [Input::Text("30".to_owned())]).frame(H, tap("Enter")).press("Tab").ticks(4);
    let later = drive.session.stage.sim().ticks();
    assert_eq!(drive.session.stage.playback().step_hz(), 30.0);
    assert_eq!(in_a_second(&mut drive), 30);
    for (tick, rate) in [(100, 120.0), (later + 10, 30.0), (50, 120.0)] {
        drive.session.seek(tick);
        assert_eq!(
            (drive.session.stage.sim().ticks(), drive.session.stage.playback().step_hz()),
            (tick, rate)
        );
    }
    drive.press("P");
    assert_eq!(in_a_second(&mut drive), 120);
}

#[test]
fn ghosts_start_where_the_run_has_gone_back_to() {
    let mut drive = recording();
    go(&mut drive, 0..20);
    drive.press("T");
    go(&mut drive, 20..30);
    drive.session.seek(15);
    assert!(
        drive
            .session
            .tools
            .ghosts(&drive.session.stage)
            .iter()
            .all(|row| row.rms.is_none_or(|rms| rms < 1e-12))
    );
}

#[test]
fn a_fault_goes_back_to_the_last_good_tick_pauses_and_selects_and_going_on_goes_through() {
    let mut drive = recording();
    go(&mut drive, 0..20);
    let good = drive.hash();
    drive.frame(1.0 / 60.0, [push("second", [f64::NAN, 0.0, 0.0])]);
    assert!(drive.session.stage.playback().paused());
    assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (20, good));
    assert_eq!(drive.selected().as_deref(), Some("second"));
    assert_eq!(drive.session.stage.quarantines().so_far(), []);
    let fault = drive.session.stage.recorder().fault().unwrap().clone();
    assert_eq!(fault.tick, 21);
    // Looking ahead shows it; the bundle holds it.
    let bundle = drive.session.stage.bundle(None).unwrap();
    assert_eq!(bundle.manifest.fault.as_ref().unwrap().body.as_deref(), Some("second"));
    assert_eq!((bundle.manifest.snapshot_tick, bundle.manifest.end_tick), (0, 21));
    assert_eq!(Bundle::read(&bundle.write().unwrap()).unwrap().manifest, bundle.manifest);
    drive.session.seek(21);
    assert!(
        drive
            .session
            .stage
            .sim()
            .world
            .get::<motion::Quarantined>(drive.entity("second"))
            .is_some()
    );
    drive.session.seek(20);
    // Going on drops the push, and with it the fault.
    drive.press("P").frames(5);
    assert!(
        drive.session.stage.recorder().fault().is_none()
            && drive.session.stage.quarantines().so_far().is_empty()
    );
    assert_eq!(drive.session.stage.sim().ticks(), 25);
}

#[test]
fn who_is_quarantined_between_two_ticks_is_so_at_once_and_gone_back_from_after_the_next() {
    let nan = change("ball", scene::ChangeAction::SetVelocity, [f64::NAN, 0.0, 0.0]);
    let quarantined = |drive: &Drive| -> Vec<(String, u64)> {
        drive
            .session
            .stage
            .quarantines()
            .so_far()
            .iter()
            .map(|quarantined| (quarantined.body.clone(), quarantined.tick))
            .collect()
    };
    let ball = [("ball".to_owned(), 21)];
    for records in [false, true] {
        let mut drive = if records { recording() } else { Drive::of(mixed()) };
        go(&mut drive, 0..20);
        drive.press("P").give([nan.clone()]);
        assert_eq!(quarantined(&drive), ball);
        drive.press("P").frames(5);
        if records {
            assert!(
                drive.session.stage.playback().paused()
                    && drive.session.stage.sim().ticks() == 20
                    && quarantined(&drive).is_empty()
            );
            assert_eq!(drive.session.stage.quarantines().all().len(), 1);
            drive.press("P").frames(5);
            assert!(drive.session.stage.quarantines().all().is_empty());
        } else {
            assert_eq!(quarantined(&drive), ball);
        }
    }
}

#[test]
fn a_session_that_records_is_the_same_session() {
    let (mut plain, mut recorded) = (Drive::of(mixed()), recording());
    assert_eq!(go(&mut plain, 0..40), go(&mut recorded, 0..40));
    assert_eq!(plain.session.stage.sim().evaluations(), recorded.session.stage.sim().evaluations());
    let gravity = |drive: &Drive| drive.session.stage.sim().world.resource::<Gravity>().on;
    assert_eq!(gravity(&plain), gravity(&recorded));
    assert_eq!(plain.x("ball") - recorded.x("ball"), DVec3::ZERO);
    // Without a timeline there is nothing to go back to.
    let hash = plain.hash();
    plain.press(",");
    assert_eq!((plain.hash(), plain.session.stage.recorder().fault()), (hash, None));
}
