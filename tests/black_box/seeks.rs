//! Going back where that takes more than a frame.

use std::ops::ControlFlow;

use history::{Simulation, TIMELINE_BYTES, Timeline};
use sandbox::Simulated;
use sandbox::input::Input;

use super::going_back::{go, recording};
use super::recording::{assert_outcome_at, outcome_at, recorded};
use crate::rigs::{Drive, mixed, push, tap};
use crate::snapshot::outcome;

/// A frame that looks away after every tick, and how many there were on the way to another tick.
fn short_frame(drive: &mut Drive, events: impl IntoIterator<Item = Input>) -> u32 {
    let time = drive.clock.advance_by(1.0 / 60.0).unwrap();
    let mut again = 0;
    drive.session.advance_watched(&events.into_iter().collect(), time, &mut |_, simulated| {
        again += u32::from(simulated == Simulated::Again);
        ControlFlow::Break(())
    });
    again
}

/// After 60 ticks, and a comma in a frame that did not suffice for it.
fn on_the_way() -> (Drive, Vec<u64>) {
    let mut drive = recording();
    let hashes = go(&mut drive, 0..60);
    short_frame(&mut drive, tap(","));
    (drive, hashes)
}

fn arrive(drive: &mut Drive) {
    for _ in 0..40 {
        short_frame(drive, []);
    }
}

#[test]
fn a_way_of_many_ticks_takes_frames_and_shows_the_present_until_it_is_there() {
    let (mut drive, hashes) = on_the_way();
    let mut frames = 0;
    while drive.session.stage.sim().ticks() == 60 {
        assert_eq!(drive.hash(), hashes[59]);
        assert!(drive.session.stage.playback().paused());
        assert!(short_frame(&mut drive, []) <= 2, "a frame continues after its look has broken");
        frames += 1;
        assert!(frames < 60, "it never arrives");
    }
    assert!(frames >= 8, "{frames}");
    assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (59, hashes[58]));
    assert_eq!(drive.session.stage.playback().dropped(), 0.0);
}

#[test]
fn what_is_asked_on_the_way_is_done_there() {
    // Two more commas are two more ticks, P plays from there, a dot is a tick forward from there.
    let (mut drive, hashes) = on_the_way();
    short_frame(&mut drive, tap(","));
    short_frame(&mut drive, tap(","));
    arrive(&mut drive);
    assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (57, hashes[56]));

    let (mut drive, hashes) = on_the_way();
    short_frame(&mut drive, tap("P"));
    while drive.session.stage.sim().ticks() == 60 {
        short_frame(&mut drive, []);
    }
    assert!(!drive.session.stage.playback().paused());
    assert!(
        (59..=60).contains(&drive.session.stage.sim().ticks()),
        "{}",
        drive.session.stage.sim().ticks()
    );
    let mut never = Drive::of(mixed());
    go(&mut never, 0..59);
    let ticks = drive.session.stage.sim().ticks();
    never.frames(u32::try_from(ticks).unwrap() - 59);
    assert_eq!(drive.hash(), never.hash());

    let (mut drive, _) = on_the_way();
    short_frame(&mut drive, tap("."));
    arrive(&mut drive);
    assert_eq!(drive.session.stage.sim().ticks(), 60);
    assert_eq!(drive.hash(), hashes[59]);
}

#[test]
fn something_done_on_the_way_is_done_here_and_nobody_is_taken_away_from_it() {
    for events in [vec![push("second", [0.0, 50.0, 0.0])], tap("G").to_vec(), tap("I").to_vec()] {
        let (mut drive, _) = on_the_way();
        short_frame(&mut drive, tap("P"));
        short_frame(&mut drive, events.clone());
        arrive(&mut drive);
        assert!(
            drive.session.stage.sim().ticks() >= 61,
            "{events:?}: {}",
            drive.session.stage.sim().ticks()
        );
        let bundle = drive.session.stage.bundle(None).unwrap();
        assert_eq!(bundle.manifest.end_tick, drive.session.stage.sim().ticks(), "{events:?}");
    }
    // A reset and another scene have no such past.
    let (mut drive, _) = on_the_way();
    short_frame(&mut drive, tap("F1"));
    let began = drive.session.stage.sim().ticks();
    arrive(&mut drive);
    assert_eq!(drive.session.stage.sim().ticks(), began);
    let (mut drive, _) = on_the_way();
    drive.session.open(scene::load("oscillator").unwrap());
    arrive(&mut drive);
    assert_eq!(drive.session.stage.sim().scene.name, "oscillator");
}

#[test]
fn a_fault_is_gone_back_from_in_frames_too() {
    let mut drive = recording();
    let hashes = go(&mut drive, 0..60);
    short_frame(&mut drive, [push("second", [f64::NAN, 0.0, 0.0])]);
    assert_eq!(drive.session.stage.sim().ticks(), 61);
    arrive(&mut drive);
    assert_eq!((drive.session.stage.sim().ticks(), drive.hash()), (60, hashes[59]));
    assert_eq!(drive.selected().as_deref(), Some("second"));
    assert!(
        drive.session.stage.playback().paused()
            && drive.session.stage.quarantines().so_far().is_empty()
    );
}

#[test]
fn the_second_of_two_long_ways_to_the_same_place_is_short() {
    let mut run = Simulation::new(mixed());
    let (mut thin, outcomes) = recorded(&mut run, TIMELINE_BYTES, 2000);
    let cap = thin.bytes() / 7;
    let mut run = Simulation::new(mixed());
    let (mut sparse, _) = recorded(&mut run, cap, 2000);
    let last_but = |timeline: &Timeline, ticks: u64| {
        // The end of the longest way that there is.
        let keyframes: Vec<u64> =
            timeline.keyframes().map(|(tick, _)| tick).chain([2000]).collect();
        let ends = keyframes.windows(2).max_by_key(|pair| pair[1] - pair[0]).unwrap()[1];
        ends - ticks
    };
    let to = last_but(&sparse, 1);
    let way =
        |timeline: &Timeline, to: u64| timeline.begin_seek(&run.scene, to).unwrap().ticks_left();
    let long = way(&sparse, to);
    assert!(long > 100, "{long}: nothing was thinned out");
    let before = sparse.bytes();
    assert_outcome_at(&mut sparse, &run, to, &outcomes);
    assert!(sparse.bytes() <= cap);
    assert!(sparse.bytes() > before, "it takes what it is counted for");
    for back in (to - 32..to).rev() {
        assert!(way(&sparse, back) <= 32);
        assert_outcome_at(&mut sparse, &run, back, &outcomes);
    }
    // Where snapshots are dense anyway there is none more.
    let before = thin.bytes();
    outcome_at(&mut thin, &run, 1999);
    assert_eq!(thin.bytes(), before);
}

#[test]
fn a_way_is_turned_only_to_what_is_ahead_and_has_no_nearer_snapshot() {
    let mut run = Simulation::new(mixed());
    let (mut timeline, outcomes) = recorded(&mut run, TIMELINE_BYTES, 100);
    let mut seek = timeline.begin_seek(&run.scene, 50).unwrap();
    for _ in 0..10 {
        assert!(timeline.seek_tick(&mut seek));
    }
    // From the snapshot at 32 it is at 42 now.
    for (tick, turned) in [(41, false), (64, false), (99, false), (42, true), (63, true)] {
        assert_eq!(timeline.redirect(&mut seek, tick), turned, "{tick}");
    }
    assert_eq!((seek.to(), seek.ticks_left()), (63, 21));
    while timeline.seek_tick(&mut seek) {}
    let mut there = timeline.finish_seek(seek).simulation;
    assert_eq!(outcome(&mut there), outcomes[63]);
}
