//! Snapshots that no world can produce are refused.

use motion::snapshot::Effects;
use motion::units::Vector;
use motion::{Cause, Iterations, Method, PreviousPosition};

use super::*;

const TEXT: &str = "(version: 1, step_hz: 100, mutual_gravity: (), bodies: [(name: \"a\"), (name: \"b\", position_m: (5, 0, 0))])";

fn scene() -> Scene {
    Scene::parse("test", TEXT).unwrap()
}

fn snapshot() -> Snapshot {
    let mut simulation = Simulation::new(scene());
    simulation.run(9);
    simulation.snapshot()
}

type State = snapshot::Snapshot<u32, IdRanges, Log>;

/// The error for the snapshot after `change`; `None` if it can be restored and simulates two ticks.
fn said(change: impl FnOnce(&mut State)) -> Option<&'static str> {
    let mut snapshot = snapshot();
    change(&mut snapshot.state);
    match Simulation::restore(scene(), &snapshot) {
        Ok(mut simulation) => {
            simulation.run(2);
            None
        }
        Err(BadSnapshot(what)) => Some(what),
    }
}

#[test]
fn one_of_a_world_is_taken() {
    assert_eq!(said(|_| {}), None);
}

#[test]
fn empty_runs_are_refused() {
    let things = Some("it has things that the scene lacks");
    assert_eq!(said(|s| s.things = IdRanges(vec![[1, 0], [0, 2]])), things);
    assert_eq!(said(|s| s.things = IdRanges(vec![[0, 2], [2, 0]])), things);
    let bodies = Some("it has bodies that the scene lacks");
    assert_eq!(said(|s| s.bodies = IdRanges(vec![[1, 1], [0, 0], [0, 1]])), bodies);
    // The ids are the same when they are split into other runs.
    assert_eq!(said(|s| s.things = IdRanges(vec![[0, 1], [1, 1]])), None);
}

#[test]
fn counts_near_overflow_are_refused() {
    let said = |accelerations, laws: [u64; 1], iterations| {
        let laws = laws.map(|count| ("mutual_gravity", count));
        said(move |s| s.evaluations = Evaluations::from_counts(accelerations, laws, iterations))
    };
    let [newton, cg, unconverged_steps] = [MOST_COUNTED + 1, u64::MAX, u64::MAX];
    let none = Iterations::default();
    let too_many = Some("its counts are too large");
    assert_eq!(said(u64::MAX, [1], none), too_many);
    assert_eq!(said(1, [u64::MAX - 1], none), too_many);
    assert_eq!(said(1, [1], Iterations { newton, ..none }), too_many);
    assert_eq!(said(1, [1], Iterations { cg, ..none }), too_many);
    assert_eq!(said(1, [1], Iterations { unconverged_steps, ..none }), too_many);
    assert_eq!(said(MOST_COUNTED, [1], none), None);
}

#[test]
fn impossible_clocks_are_refused() {
    let said =
        |clock: fn(&mut motion::clock::ClockState)| said(|snapshot| clock(&mut snapshot.clock));
    let invalid = Some("invalid clock");
    assert_eq!(said(|clock| clock.step = -0.01), invalid);
    assert_eq!(said(|clock| clock.step = f64::NAN), invalid);
    assert_eq!(said(|clock| clock.since_time = -1.0), invalid);
    assert_eq!(said(|clock| clock.since_time = f64::INFINITY), invalid);
    assert_eq!(said(|clock| clock.scene_began = -1.0), invalid);
    assert_eq!(said(|clock| clock.scene_began = 1.0), invalid);
    assert_eq!(said(|clock| clock.since_tick = 10), invalid);
    assert_eq!(said(|clock| clock.ticks = u64::MAX), invalid);
    assert_eq!(said(|clock| (clock.since_time, clock.scene_began) = (7.0, 7.0)), None);
    assert_eq!(said(|clock| (clock.step, clock.since_time) = (1e308, 1e308)), None);
}

#[test]
fn previous_positions_must_be_finite() {
    let at = |y| PreviousPosition(Vector::new(0.0, y, 2.0));
    let not_finite = Some("a place to draw from is not finite");
    assert_eq!(said(|s| s.previous_positions = vec![(0, at(0.0)), (1, at(f64::NAN))]), not_finite);
    assert_eq!(said(|s| s.previous_positions = vec![(0, at(f64::INFINITY))]), not_finite);
    assert_eq!(said(|s| s.previous_positions = vec![(1, at(1.0))]), None);
}

#[test]
fn records_name_things_of_the_scene() {
    let cause = Cause { system: "integrate", component: "Force", fault: Fault::Spring(u32::MAX) };
    let record = |body| QuarantineRecord { body, id: None, other_end: None, tick: 3, cause };
    let strange = Some("it has records of things that the scene lacks");
    assert_eq!(said(|s| s.records = vec![record(1), record(2)]), strange);
    assert_eq!(said(|s| s.records = vec![record(1)]), None);
}

#[test]
fn a_method_need_not_solve_what_is_off() {
    let unsolvable = Some("its method cannot solve the scene");
    assert_eq!(said(|s| s.method = Method::ImplicitEuler), unsolvable);
    let off = |snapshot: &mut State| {
        let mut world = Simulation::new(scene()).world;
        motion::effects::switch(&mut world, Effect::MutualGravity, false).unwrap();
        (snapshot.method, snapshot.effects) = (Method::ImplicitEuler, Effects::of(&world));
    };
    assert_eq!(said(off), None);
}

#[test]
fn particles_of_a_scene_with_mutual_gravity_may_have_any_method() {
    let text = "(version: 1, step_hz: 100, mutual_gravity: (), bodies: [(name: \"a\")],
        emitters: [(rate_per_s: 60, life_s: 1, speed_m_s: 2, method: implicit_euler)])";
    let scene = Scene::parse("test", text).unwrap();
    let scene = Arc::new(scene);
    let mut simulation = Simulation::new(Arc::clone(&scene));
    simulation.run(9);
    let mut snapshot = simulation.snapshot();
    assert!(snapshot.state.own_methods.iter().all(|(_, method)| *method == Method::ImplicitEuler));
    assert!(
        snapshot.state.own_methods.len() > 50
            && Simulation::restore(Arc::clone(&scene), &snapshot).is_ok()
    );
    snapshot.state.own_methods.push((0, Method::ImplicitEuler));
    assert!(Simulation::restore(scene, &snapshot).is_err());
}
