//! What `recommend` promises is what a person gets: the scene with the chosen settings keeps the error in every tick,
//! against a closed form.

use std::f64::consts::TAU;

use glam::DVec3;
use history::Simulation;
use lab::cost::{Bench, Plan, Subject};
use lab::recommend::{Goal, recommend};
use motion::Method;
use scene::Scene;

use crate::methods::problems::kepler_state;
use crate::rigs::{Dice, scene_of};

/// Recommends for the scene of one body, applies that to its text, and returns the largest distance of the body from
/// `exact` after any tick of the run that was measured.
fn largest_error(text: &str, error: f64, exact: impl Fn(f64) -> DVec3) -> f64 {
    let scene = scene_of(text);
    let parts = scene.parts();
    let [part] = &parts[..] else { panic!("one body is one part") };
    let plan =
        Plan { rungs: vec![1, 2, 4, 8, 16], passes: 0, longer: 0, rates: false, ..Plan::full() };
    let mut bench = Bench::new(Subject::of_scene(part.scene.clone(), None), plan);
    assert!(bench.work(f64::INFINITY));
    let study = bench.study();
    let found = recommend(&[(&part.name, study)], Goal::Error(error))
        .unwrap_or_else(|why| panic!("{why}: {text}"));
    let pick = found.rows[0].pick;
    let settings = [(part, pick.setting)];
    let (common, own) = scene.methods_of_parts(&settings);
    let applied = scene.with_methods("test", common, &own).unwrap();
    let mut run = Simulation::new(Scene::parse("applied", &applied).unwrap());
    let mut largest = 0.0_f64;
    for tick in 1..=study.ticks {
        run.tick();
        let (_, x, _) = run.states().last().unwrap();
        largest = largest.max(x.distance(exact(tick as f64 / study.step_hz)));
    }
    // The study knows it, too: no promise is kept by chance.
    let promised = pick.error_m + found.rows[0].reference_error_m;
    assert!(
        largest <= promised * (1.0 + 1e-9) + 1e-12,
        "{largest:e} m, but {promised:e} m was measured of {}",
        pick.setting
    );
    assert!(promised <= error, "{promised:e}");
    largest
}

/// A mass on a spring along x, pulled out by `amplitude` m and `phase` rad into its swing.
#[track_caller]
fn check_spring(hz: f64, step_hz: f64, method: Method, (amplitude, phase): (f64, f64), error: f64) {
    let (w, rest) = (TAU * hz, 3.0);
    let state = |t: f64| {
        let (sin, cos) = (w * t + phase).sin_cos();
        (DVec3::X * (rest + amplitude * cos), -w * amplitude * sin)
    };
    let (x, v) = state(0.0);
    let text = format!(
        "(version: 1, step_hz: {step_hz:?}, method: {}, bodies: [(name: \"post\", immovable: true),
          (name: \"mass\", position_m: ({:?}, 0, 0), velocity_m_s: ({v:?}, 0, 0))],
          springs: [(between: (\"post\", \"mass\"), stiffness_n_m: {:?}, rest_length_m: {rest:?})])",
        method.name(),
        x.x,
        w * w
    );
    let largest = largest_error(&text, error, |t| state(t).0);
    assert!(largest <= error, "{hz} Hz in steps of 1/{step_hz} s: {largest:e} m for {error:e} m");
}

/// The eight times of a run of ten seconds at 2 Hz and 0.8 Hz are turning points, where an error of phase vanishes.
#[test]
fn a_frequency_whose_turning_points_are_round_times_is_measured_between_them() {
    check_spring(2.0, 240.0, Method::VelocityVerlet, (1.0, 0.0), 1e-3);
    check_spring(0.8, 240.0, Method::VelocityVerlet, (1.0, 0.0), 1e-5);
}

#[test]
fn springs_of_random_frequencies_keep_the_promise_in_every_tick() {
    let mut dice = Dice(28);
    for i in 0..10 {
        let hz = 1.1 + 0.9 * dice.number();
        let step_hz = [60.0, 90.0, 144.0, 240.0][dice.below(4)];
        let swing = (0.8 + 0.6 * dice.number(), TAU * dice.number());
        let error = 10.0_f64.powf(-2.5 + dice.number());
        check_spring(hz, step_hz, Method::ALL[i % Method::ALL.len()], swing, error);
    }
}

#[test]
fn random_orbits_keep_the_promise_in_every_tick() {
    let mut dice = Dice(29);
    for i in 0..20 {
        let e = 0.3 + 0.3 * dice.number();
        // The closed form is of a strength of 1: other periods are other units of time.
        let rate = 1.5 + dice.number();
        let step_hz = [60.0, 90.0, 144.0][dice.below(3)];
        let error = 10.0_f64.powf(-2.5 + dice.number());
        let (x, v) = kepler_state(e, 0.0);
        let vector = |v: DVec3| format!("({:?}, {:?}, {:?})", v.x, v.y, v.z);
        let text = format!(
            "(version: 1, step_hz: {step_hz:?}, method: {}, wells: [(strength_m3_s2: {:?})], bodies: [
              (name: \"planet\", position_m: {}, velocity_m_s: {})])",
            Method::ALL[i % Method::ALL.len()].name(),
            rate * rate,
            vector(x),
            vector(v * rate)
        );
        let largest = largest_error(&text, error, |t| kepler_state(e, rate * t).0);
        assert!(largest <= error, "e = {e}, {rate} rad/s: {largest:e} m for {error:e} m");
    }
}
