//! What `sandbox run` says and records of it.

use bevy_ecs::entity::Entity;
use motion::Method;
use motion::margin::{Cure, LimitingPart, Margin};
use report::ForecastRow;
use serde_json::Value;

use crate::rigs::{Said, command_lines, summarized};

/// A weight of 1 kg on a spring of `stiffness` N/m, its end of rest.
fn hung(stiffness: f64) -> String {
    format!(
        "(version: 1, step_hz: 60, bodies: [(name: \"anchor\", immovable: true),
          (name: \"weight\", position_m: (1.1, 0, 0), mass_kg: 1.0)],
          springs: [(between: (\"anchor\", \"weight\"), stiffness_n_m: {stiffness:?}, rest_length_m: 1.0)])"
    )
}

/// Six ticks of it.
fn run(stiffness: f64, flags: &str) -> (Said, Value) {
    run_scene(&hung(stiffness), flags)
}

fn run_scene(scene: &str, flags: &str) -> (Said, Value) {
    summarized([("hung.ron", scene)], &format!("run hung.ron --ticks 6 {flags}"))
}

/// Fails unless a run that refuses what is unstable ends with these words.
#[track_caller]
fn refused(scene: &str, flags: &str, words: &str) {
    let (said, _) = run_scene(scene, &format!("{flags} --refuse-unstable"));
    said.warns(1, words);
}

#[test]
fn a_stiff_spring_is_warned_of_and_recorded() {
    let (said, summary) = run(1e8, "");
    assert!(said.err.starts_with("hung is unstable: "), "{}", said.err);
    let [row] = &summary["forecast"].as_array().unwrap()[..] else { panic!("{summary}") };
    assert_eq!(row["element"], "spring anchor - weight");
    assert_eq!((&row["method"], &row["substeps"]), (&"semi_implicit_euler".into(), &1.into()));
    assert!((row["value"].as_f64().unwrap() - 1e4 / 60.0).abs() < 1e-6, "{row}");
    assert!((row["limit"].as_f64().unwrap() - 2.0).abs() < 1e-4, "{row}");
    assert_eq!(row["cure"], "needs 84 substeps, or implicit_euler");
    assert_eq!(run(1e8, "--substeps 84").1["forecast"], Value::Array(Vec::new()));
}

#[test]
fn warnings_begin_at_the_limit_and_are_the_end_of_a_run_that_refuses_them() {
    command_lines("forecast");
}

#[test]
fn what_is_near_the_limit_swings_too_far() {
    // The swing of semi-implicit Euler has up to 1 / sqrt(1 - r²) times the true size, and grows no more.
    let (near, _) = run((2.0 * 60.0 * 0.99_f64).powi(2), "--refuse-unstable");
    let words = "hung is wrong: weight: semi_implicit_euler swings 7.089 times too far";
    assert!(near.err.contains(words), "{}", near.err);
}

/// Runge-Kutta 2 at w h = 0.1 grows by 1.25e-5 a tick (numerics: G2 = 1 + z^4 / 4).
#[test]
fn what_grows_too_slowly_to_be_told_is_in_the_summary() {
    let (said, summary) = run(36.0, "--method runge_kutta_2_midpoint --refuse-unstable");
    said.says(0, "");
    let [row] = &summary["forecast"].as_array().unwrap()[..] else { panic!("{summary}") };
    let growth = row["growth_per_s"].as_f64().unwrap();
    assert!((growth.ln() / 60.0 - 1e-4 / 8.0).abs() < 1e-7, "{row}");
    assert_eq!(run(36.0, "").1["forecast"], Value::Array(Vec::new()));
}

/// A weight of 1 kg at a wall, from which twenty links of a gram hang that are faster than it is.
fn slow_and_links(of_scene: &str, of_slow: &str, of_links: &str, damping_n_s_m: f64) -> String {
    use std::fmt::Write as _;
    let mut bodies = format!(
        "(name: \"wall\", immovable: true), (name: \"slow\", position_m: (1.01, 0, 0), {of_slow}),"
    );
    let link =
        format!("stiffness_n_m: 0.144, damping_n_s_m: {damping_n_s_m:?}, rest_length_m: 1.0");
    let mut springs =
        "(between: (\"wall\", \"slow\"), stiffness_n_m: 1296.0, rest_length_m: 1.0),".to_owned();
    let mut last = "slow".to_owned();
    for i in 0..20 {
        let name = format!("b{i}");
        let x = f64::from(i) + 2.0;
        write!(
            bodies,
            "(name: \"{name}\", position_m: ({x:?}, 0, 0), mass_kg: 0.001, {of_links}),"
        )
        .unwrap();
        write!(springs, "(between: (\"{last}\", \"{name}\"), {link}),").unwrap();
        last = name;
    }
    format!("(version: 1, step_hz: 120, {of_scene}, bodies: [{bodies}], springs: [{springs}])")
}

/// Every fast link is damped, and the slow weight is not: explicit Euler blows it up.
#[test]
fn the_mode_with_too_little_damping_is_found_among_faster_ones() {
    let scene = slow_and_links("method: explicit_euler", "", "", 0.036);
    refused(&scene, "", "slow: explicit_euler throws it out within 0.225 s");
}

/// Damping acts once per tick and springs a hundred times: damping is the least stable.
#[test]
fn damping_of_ticks_is_weighed_by_ticks() {
    let damped = "damping: (model: tutorial, rate_per_s: 0.0)";
    let scene = slow_and_links(
        &format!("method: velocity_verlet, substeps: 100, {damped}"),
        "damping_per_s: 300.0",
        "damping_per_s: 0.0",
        0.0,
    );
    refused(&scene, "", "damping of slow: c h");
}

/// Explicit Euler turns a speed v that only drag k v slows down into v (1 - k v h): it grows from k v h = 2 on.
#[test]
fn drag_that_turns_a_body_back_and_slows_it_down_is_stable() {
    for (drag, unstable) in [(19.8, false), (20.2, true)] {
        let scene = format!(
            "(version: 1, step_hz: 10, method: explicit_euler, drag: (quadratic_per_m: {drag:?}),
              bodies: [(name: \"a\", velocity_m_s: (1, 0, 0))])"
        );
        run_scene(&scene, "--refuse-unstable").0.ends(i32::from(unstable));
    }
}

#[test]
fn at_most_three_lines_are_said() {
    let pair = |i: u32| {
        format!(
            "(name: \"a{i}\", position_m: ({i}, 0, 0), mass_kg: 1.0), (name: \"b{i}\", position_m: ({i}, 1, 0), mass_kg: 1.0),"
        )
    };
    let spring = |i: u32| {
        format!(
            "(between: (\"a{i}\", \"b{i}\"), stiffness_n_m: {:?}, rest_length_m: 1.0),",
            1e6 * f64::from(i + 1)
        )
    };
    let (pairs, springs): (String, String) =
        ((0..5).map(pair).collect(), (0..5).map(spring).collect());
    let (said, summary) =
        run_scene(&format!("(version: 1, bodies: [{pairs}], springs: [{springs}])"), "");
    let lines: Vec<_> = said.err.lines().filter(|line| line.contains("unstable")).collect();
    assert_eq!(lines.len(), 4, "{}", said.err);
    assert!(
        lines[0].contains("spring a4 - b4") && lines[3].contains("2 more are unstable"),
        "{lines:?}"
    );
    assert_eq!(summary["forecast"].as_array().unwrap().len(), 5);
}

/// A net so large that its value is known to 0.3 % only.
#[test]
fn what_cannot_be_decided_says_so() {
    let margin = Margin {
        part: LimitingPart::Damping(Entity::PLACEHOLDER),
        bodies: 1_000_000,
        method: Method::SemiImplicitEuler,
        substeps: 1,
        value: 1.996,
        at_most: 2.004,
        limit: 2.0,
        is_linear: true,
        growth_per_s: 1.0,
        growth_per_tick: 1.0,
        cure: Cure { substeps: Some(2), error: None, method: None },
    };
    assert!(margin.may_be_unstable());
    let row = ForecastRow::of_margin(margin, |_| "lattice".to_owned());
    let line = "damping of lattice: c h = 1.996 to 2.004, within 0.3 % of the limit of semi_implicit_euler, 2; needs 2 substeps";
    assert_eq!((row.verdict(), row.line().as_str()), ("at its limit", line));
}
