//! Frame times, ticks due, hitches and pushes at any frame rate.

use std::ops::ControlFlow;

use motion::clock::StepClock;
use motion::units::Vector;
use sandbox::clock::{BadTime, FrameClock, TickClock};

use sandbox::input::InputFrame;
use sandbox::{Options, Session};

use crate::rigs::{Lab, scene_of};

/// Ticks of each frame when frames end at `ends`.
fn ticks(rate: f64, ends: impl Iterator<Item = f64>) -> Vec<u64> {
    let mut frames = FrameClock::default();
    let mut clock = TickClock::new(rate, 0.25).unwrap();
    ends.map(|end| clock.due(frames.advance_to(end).unwrap()).ticks).collect()
}

#[test]
fn ticks_due_come_from_total_time_and_never_drift() {
    assert_eq!(ticks(120.0, (1..=6).map(|i| f64::from(i) / 60.0)), [2; 6]);
    let uneven = ticks(120.0, (1..=144).map(|i| f64::from(i) / 144.0));
    assert_eq!(uneven.iter().sum::<u64>(), 120);
    assert!(uneven.iter().all(|ticks| *ticks <= 1));
    // After hours, too, every frame has its two ticks.
    let even = ticks(120.0, (1..=1_000_000).map(|i| f64::from(i) / 60.0));
    assert!(even.iter().all(|ticks| *ticks == 2));
    // A million frames of 1/144 s into steps of 1/60 s.
    let total: u64 = ticks(60.0, (1..=1_000_000).map(|i| f64::from(i) / 144.0)).iter().sum();
    assert_eq!(total, 416_666);
    // The same from frame lengths that are added up: the sum is compensated.
    let (mut frames, mut clock) = (FrameClock::default(), TickClock::new(60.0, 0.25).unwrap());
    let total: u64 =
        (0..1_000_000).map(|_| clock.due(frames.advance_by(1.0 / 144.0).unwrap()).ticks).sum();
    assert_eq!(total, 416_666);
}

#[test]
fn a_hitch_is_capped_and_its_dropped_time_is_reported() {
    let mut frames = FrameClock::default();
    let mut clock = TickClock::new(120.0, 0.25).unwrap();
    assert_eq!(clock.due(frames.advance_by(1.0 / 60.0).unwrap()).ticks, 2);
    let due = clock.due(frames.advance_by(1.0).unwrap());
    assert_eq!((due.ticks, due.dropped), (30, 0.75));
    assert_eq!(clock.due(frames.advance_by(1.0 / 60.0).unwrap()).ticks, 2);
    // A tick longer than the limit still happens.
    let mut slow = TickClock::new(1.0, 0.25).unwrap();
    let mut frames = FrameClock::default();
    assert_eq!(slow.due(frames.advance_by(1.0).unwrap()).ticks, 1);
}

#[test]
fn a_frame_of_zero_seconds_changes_nothing() {
    let mut frames = FrameClock::default();
    let mut clock = TickClock::new(120.0, 0.25).unwrap();
    clock.due(frames.advance_by(0.012).unwrap());
    let before = clock.fraction();
    for _ in 0..3 {
        let due = clock.due(frames.advance_by(0.0).unwrap());
        assert_eq!((due.ticks, due.dropped, clock.fraction()), (0, 0.0, before));
    }
}

#[test]
fn negative_and_non_finite_frame_times_are_refused_and_leave_the_clock_alone() {
    let mut frames = FrameClock::default();
    frames.advance_by(0.5).unwrap();
    assert_eq!(frames.advance_by(-0.1), Err(BadTime::Negative(-0.1)));
    assert!(matches!(frames.advance_by(f64::NAN), Err(BadTime::NotFinite(_))));
    assert!(matches!(frames.advance_to(f64::INFINITY), Err(BadTime::NotFinite(_))));
    assert!(matches!(frames.advance_to(0.4), Err(BadTime::Negative(_))));
    assert_eq!(frames.now(), 0.5);
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(TickClock::new(rate, 0.25).is_err());
    }
}

#[test]
fn a_changed_pace_keeps_the_tick_and_a_pause_owes_nothing() {
    let mut frames = FrameClock::default();
    let mut clock = TickClock::new(120.0, 0.25).unwrap();
    let mut run = |clock: &mut TickClock, n: u32| -> u64 {
        (0..n).map(|_| clock.due(frames.advance_by(1.0 / 60.0).unwrap()).ticks).sum()
    };
    assert_eq!(run(&mut clock, 60), 120);
    clock.set_pace(0.25).unwrap();
    assert_eq!(run(&mut clock, 60), 30);
    clock.set_pace(4.0).unwrap();
    assert_eq!(run(&mut clock, 60), 480);
    clock.set_pace(1.0).unwrap();
    let mut later = FrameClock::default();
    clock.pause(later.advance_by(100.0).unwrap());
    assert_eq!(clock.due(later.advance_by(1.0 / 60.0).unwrap()).ticks, 2);
}

#[test]
fn a_fast_pace_is_no_hitch() {
    let mut frames = FrameClock::default();
    let mut clock = TickClock::new(120.0, 0.25).unwrap();
    clock.set_pace(16.0).unwrap();
    for i in 1..=600 {
        let due = clock.due(frames.advance_to(f64::from(i) / 60.0).unwrap());
        assert_eq!((due.ticks, due.dropped), (32, 0.0));
    }
}

#[test]
fn simulated_time_survives_a_change_of_step() {
    let mut clock = StepClock::default();
    (0..120).for_each(|_| clock.count(1.0 / 120.0));
    (0..60).for_each(|_| clock.count(1.0 / 60.0));
    assert_eq!((clock.ticks(), clock.seconds()), (180, 2.0));
}

#[test]
fn the_same_clicks_push_alike_at_every_frame_rate() {
    let clicks = [0.1034, 0.25, 0.5, 0.5001, 0.9];
    let jitter = |i: u32| {
        1.0 / 60.0 * (0.6 + 0.8 * f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65_536.0)
    };
    let frames: [(&str, Box<dyn Fn(u32) -> f64>); 5] = [
        ("30", Box::new(|_| 1.0 / 30.0)),
        ("60", Box::new(|_| 1.0 / 60.0)),
        ("144", Box::new(|_| 1.0 / 144.0)),
        ("1000", Box::new(|_| 1e-3)),
        ("jitter", Box::new(jitter)),
    ];
    for (name, length) in frames {
        let mut lab = Lab::tutorial();
        lab.world.remove_resource::<motion::Damping>();
        lab.world.remove_resource::<motion::Gravity>();
        let body = lab.body(10.0, Vector::ZERO);
        let (mut frames, mut clock) = (FrameClock::default(), TickClock::new(120.0, 0.25).unwrap());
        let mut next = 0;
        for i in 0.. {
            let frame = frames.advance_by(length(i)).unwrap();
            if frame.total() > 1.2 {
                break;
            }
            while next < clicks.len() && clicks[next] <= frame.total() {
                lab.push(body, Vector::X * 10.0);
                next += 1;
            }
            lab.run(clock.due(frame).ticks);
        }
        // Five clicks, each for one tick: neither lost in a frame without a tick nor doubled in one with four.
        let expected = 5.0 * 10.0 * 10.0 / 120.0;
        assert!(
            (lab.v(body).x - expected).abs() <= 1e-14,
            "{name} frames a second: {}",
            lab.v(body).x
        );
    }
}

#[test]
fn ticks_that_take_longer_than_they_simulate_end_in_a_steady_frame_and_not_in_a_spiral() {
    const STEP: f64 = 1.0 / 120.0;
    // What a tick takes, s of a clock that only this test has; the last is a scene of far too many ticks a second.
    for (hz, cost, patience) in
        [(120.0, 1.5 * STEP, f64::INFINITY), (120.0, 1.5 * STEP, 0.25), (1e9, 1e-3, 0.25)]
    {
        let text =
            format!("(version: 1, step_hz: {hz:?}, bodies: [(velocity_m_s: (1.0, 0.0, 0.0))])");
        let scene = scene_of(&text);
        let options = Options { pictures: false, ..Options::default() };
        let mut session = Session::new(scene, options);
        let (mut frames, mut length, mut lengths) = (FrameClock::default(), 1.0 / 60.0, Vec::new());
        for _ in 0..40 {
            let mut spent = 0.0;
            let (before, dropped) =
                (session.stage.sim().ticks(), session.stage.playback().dropped());
            let time = frames.advance_by(length).unwrap();
            session.advance_watched(&InputFrame::NOTHING, time, &mut |_, _| {
                spent += cost;
                if spent > patience { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            // Nothing is lost in silence.
            let simulated = (session.stage.sim().ticks() - before) as f64 / hz;
            let told = session.stage.playback().dropped() - dropped;
            assert!(
                (simulated + told - length).abs() <= 2.0 / hz + 1e-9,
                "{simulated} {told} {length}"
            );
            length = spent.max(1.0 / 60.0);
            lengths.push(length);
        }
        // What a frame catches up with is limited, by the time that it owes or by the patience.
        let most = (0.25 * hz * cost).min(patience + cost).max(1.0 / 60.0);
        assert!(lengths.iter().all(|length| *length <= most + 1e-9), "{hz}: {lengths:?}");
        assert_eq!(lengths[38], lengths[39], "{hz}: not steady");
        assert!(session.stage.sim().ticks() >= 40, "{hz}: it stands still");
    }
}
