//! Timelines of worlds: what they can go back to, and what they take.

use glam::DVec3;
use history::{Change, EnergyState, Simulation, Timeline};
use motion::effects::Effect;
use motion::{Method, Request};

use crate::rigs::{mixed, scene_of};
use crate::snapshot::{Outcome, outcome};

/// Nothing is known of its energy.
const UNWATCHED: EnergyState = EnergyState {
    largest_j: 0.0,
    looked_tick: 0,
    looked_j: 0.0,
    total_j: None,
    last_j: None,
    grew_tick: None,
    changed_tick: 0,
    growth: None,
    look: None,
};

/// Changes of `run` before tick number `tick`, noted in `timeline`.
fn change(run: &mut Simulation, timeline: &mut Timeline, tick: u64) {
    let id = |name: &str| run.scene.names.find(name).unwrap();
    let (ball, second, spare) = (id("ball"), id("second"), id("spare"));
    let requests = match tick % 40 {
        5 => vec![Request::Switch(Effect::Gravity, true)],
        9 => vec![Request::Impulse(second, DVec3::X), Request::Switch(Effect::Drag, false)],
        20 => vec![Request::Switch(Effect::Gravity, false), Request::Switch(Effect::Drag, true)],
        33 if tick > 40 => vec![Request::Remove(spare)],
        _ => Vec::new(),
    };
    let mut changes = Vec::new();
    changes.extend((!requests.is_empty()).then_some(Change::Requests(requests)));
    changes.extend((tick == 60).then_some(Change::Method(Method::VelocityVerlet)));
    changes.extend(tick.is_multiple_of(7).then(|| Change::Push(ball, DVec3::new(1.0, 2.0, -1.0))));
    changes.extend((tick % 50 < 10).then_some(Change::Push(second, DVec3::Y)));
    for change in changes {
        timeline.note(run, change.clone());
        run.give(&change);
    }
}

/// `ticks` ticks of a run with a timeline of at most `cap` bytes, and its outcomes after every tick.
pub fn recorded(run: &mut Simulation, cap: usize, ticks: u64) -> (Timeline, Vec<Outcome>) {
    let mut timeline = Timeline::new(run, cap, UNWATCHED).unwrap();
    let mut outcomes = vec![outcome(run)];
    for tick in 0..ticks {
        change(run, &mut timeline, tick);
        run.tick();
        timeline.after_tick(run, UNWATCHED);
        assert!(timeline.bytes() <= cap, "{} bytes", timeline.bytes());
        outcomes.push(outcome(run));
    }
    (timeline, outcomes)
}

/// The run at the end of a tick, simulated again.
fn seek(timeline: &mut Timeline, run: &Simulation, tick: u64) -> Simulation {
    let mut seek = timeline.begin_seek(&run.scene, tick).unwrap();
    while timeline.seek_tick(&mut seek) {}
    timeline.finish_seek(seek).simulation
}

pub fn outcome_at(timeline: &mut Timeline, run: &Simulation, tick: u64) -> Outcome {
    outcome(&mut seek(timeline, run, tick))
}

/// Goes back to a tick of a run with these outcomes: the way may have been restored from a snapshot of another way, and
/// each time cached accelerations are evaluated once more.
pub fn assert_outcome_at(
    timeline: &mut Timeline,
    run: &Simulation,
    tick: u64,
    outcomes: &[Outcome],
) {
    let again = 2 * run.bodies.len() as u64;
    let there = outcome_at(timeline, run, tick);
    there.assert_restored(&outcomes[usize::try_from(tick).unwrap()], again, &tick.to_string());
}

#[test]
fn each_of_the_last_200_ticks_is_what_it_was_bit_for_bit_but_for_what_was_cached_evaluation_for_evaluation()
 {
    let mut run = Simulation::new(mixed());
    let (mut timeline, outcomes) = recorded(&mut run, history::TIMELINE_BYTES, 240);
    assert_eq!(timeline.range(), 0..=240);
    for tick in 41..=240 {
        assert_outcome_at(&mut timeline, &run, tick, &outcomes);
    }
    let keyframes: Vec<_> = timeline.keyframes().collect();
    assert!(keyframes.len() > 5);
    for (tick, hash) in keyframes {
        assert_eq!(hash, outcomes[usize::try_from(tick).unwrap()].hash);
    }
}

#[test]
fn at_its_bytes_snapshots_get_sparser_then_the_oldest_go_and_what_is_left_is_exact() {
    let mut whole = Simulation::new(mixed());
    let (timeline, _) = recorded(&mut whole, usize::MAX, 300);
    let all = timeline.bytes();
    let mut run = Simulation::new(mixed());
    let (mut sparser, outcomes) = recorded(&mut run, all / 2, 300);
    let count = |timeline: &Timeline| timeline.keyframes().count();
    assert!(count(&sparser) < count(&timeline) && *sparser.range().start() == 0);
    let mut run = Simulation::new(mixed());
    let (mut shorter, _) = recorded(&mut run, all / 4, 300);
    assert!(*shorter.range().start() > 0, "{:?}", shorter.range());
    for timeline in [&mut sparser, &mut shorter] {
        for tick in [*timeline.range().start(), 299, 300] {
            assert_outcome_at(timeline, &run, tick, &outcomes);
        }
    }
    let run = Simulation::new(mixed());
    assert!(Timeline::new(&run, 1000, UNWATCHED).is_none());
}

#[test]
fn more_than_a_minute_is_not_kept() {
    let mut run = Simulation::new(scene::load("oscillator").unwrap());
    let mut timeline = Timeline::new(&run, history::TIMELINE_BYTES, UNWATCHED).unwrap();
    let minute = (60.0 * run.scene.step_hz) as u64;
    for _ in 0..minute + 500 {
        run.tick();
        timeline.after_tick(&run, UNWATCHED);
    }
    let first = *timeline.range().start();
    assert!((400..=500).contains(&first), "{first}");
}

#[test]
fn every_tick_is_sought_with_the_length_that_it_had() {
    let scene = "(version: 1, gravity: (), bodies: [(name: \"ball\", velocity_m_s: (3, 8, 0))])";
    let mut run = Simulation::new(scene_of(scene));
    let mut timeline = Timeline::new(&run, 1 << 20, UNWATCHED).unwrap();
    let mut hashes = vec![run.hash()];
    for tick in 0..80_u32 {
        let step = Change::Step(0.01 + 0.001 * f64::from(tick / 3 % 7));
        timeline.note(&run, step.clone());
        run.give(&step);
        run.tick();
        timeline.after_tick(&run, UNWATCHED);
        hashes.push(run.hash());
    }
    for (tick, hash) in (0..).zip(&hashes) {
        assert_eq!(seek(&mut timeline, &run, tick).hash(), *hash, "tick {tick}");
    }
}
