//! What `sandbox run` says and records of it.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::harness::sandbox;

struct Said {
    code: i32,
    errors: String,
    summary: Value,
    files: Vec<String>,
}

/// A weight of 1 kg on a spring of `stiffness` N/m, its end of rest, run for a tenth of a second.
fn run(stiffness: f64, flags: &str) -> Said {
    let scene = format!(
        "(version: 1, step_hz: 60, bodies: [(name: \"anchor\", immovable: true),
          (name: \"weight\", position_m: (1.1, 0, 0), mass_kg: 1.0)],
          springs: [(between: (\"anchor\", \"weight\"), stiffness_n_m: {stiffness:?}, rest_length_m: 1.0)])"
    );
    run_scene(&scene, flags)
}

fn run_scene(scene: &str, flags: &str) -> Said {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("hung.ron"), scene).unwrap();
    let line = format!("run hung.ron --seconds 0.1 --summary out/summary.json --state out/state.csv {flags}");
    let said = sandbox(folder.path(), &line);
    let summary = fs::read(folder.path().join("out/summary.json")).unwrap_or_default();
    let files = fs::read_dir(&folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
    let mut files: Vec<_> = files.collect();
    files.sort();
    Said {
        code: said.code,
        errors: said.err.replace("made the folder out\n", ""),
        summary: serde_json::from_slice(&summary).unwrap_or(Value::Null),
        files,
    }
}

#[test]
fn a_stiff_spring_is_warned_of_and_recorded() {
    let said = run(1e8, "");
    let line = "hung is unstable: spring anchor - weight: w h = 166.7, the limit of semi_implicit_euler is 2; \
                needs 84 substeps, or implicit_euler\n";
    assert!(said.errors.starts_with(line), "{}", said.errors);
    let [row] = &said.summary["forecast"].as_array().unwrap()[..] else { panic!("{}", said.summary) };
    assert_eq!(row["element"], "spring anchor - weight");
    assert_eq!((&row["method"], &row["substeps"]), (&"semi_implicit_euler".into(), &1.into()));
    assert!((row["value"].as_f64().unwrap() - 1e4 / 60.0).abs() < 1e-6, "{row}");
    assert!((row["limit"].as_f64().unwrap() - 2.0).abs() < 1e-4, "{row}");
    assert_eq!(row["cure"], "needs 84 substeps, or implicit_euler");
    let calm = run(1e8, "--substeps 84");
    assert!(calm.errors.is_empty() && calm.code == 0, "{}", calm.errors);
    assert_eq!(calm.summary["forecast"], Value::Array(Vec::new()));
    assert!(run(1e8, "--method implicit_euler --refuse-unstable").errors.is_empty());
}

#[test]
fn the_limit_is_where_warnings_begin() {
    let at = |part: f64| (2.0 * 60.0 * part).powi(2);
    assert!(run(at(0.99), "--refuse-unstable").errors.is_empty());
    assert!(run(at(1.01), "").errors.contains("needs 2 substeps, or implicit_euler"));
}

/// A weight on a spring of 1 rad/s, at one tick a frame.
const FRAMES: &str = "(version: 1, step: frame, bodies: [(name: \"anchor\", immovable: true),
    (name: \"weight\", position_m: (1.1, 0, 0), mass_kg: 1.0)],
    springs: [(between: (\"anchor\", \"weight\"), stiffness_n_m: 1.0, rest_length_m: 1.0)])";

#[test]
fn a_step_of_frames_is_as_long_as_the_longest_frame() {
    let said = run_scene(FRAMES, "--fps 0.4 --refuse-unstable");
    assert!(said.code == 1 && said.errors.contains("w h = 2.5, the limit"), "{}", said.errors);
    let calm = run_scene(FRAMES, "--fps 0.6 --refuse-unstable");
    assert!(calm.code == 0 && calm.errors.is_empty(), "{}", calm.errors);
}

#[test]
fn what_grows_slowly_in_a_second_and_fast_in_a_tick_is_told() {
    let scene = FRAMES.replace("step: frame", "step_hz: 0.001").replace("1.0, rest", "4.4e-6, rest");
    let said = run_scene(&scene, "--refuse-unstable");
    assert!(said.code == 1 && said.errors.contains("w h = 2.098, the limit"), "{}", said.errors);
}

/// Runge-Kutta 2 at w h = 0.1 grows by 1.25e-5 a tick (numerics: G2 = 1 + z^4 / 4).
#[test]
fn what_grows_too_slowly_to_be_told_is_in_the_summary() {
    let said = run(36.0, "--method runge_kutta_2_midpoint --refuse-unstable");
    assert!(said.code == 0 && said.errors.is_empty(), "{}", said.errors);
    let [row] = &said.summary["forecast"].as_array().unwrap()[..] else { panic!("{}", said.summary) };
    let growth = row["growth_per_s"].as_f64().unwrap();
    assert!((growth.ln() / 60.0 - 1e-4 / 8.0).abs() < 1e-7, "{row}");
    assert_eq!(run(36.0, "").summary["forecast"], Value::Array(Vec::new()));
}

/// A weight of 1 kg at a wall, from which twenty links of a gram hang that are faster than it is.
fn slow_and_links(of_scene: &str, of_slow: &str, of_links: &str, damping_n_s_m: f64) -> String {
    use std::fmt::Write as _;
    let mut bodies =
        format!("(name: \"wall\", immovable: true), (name: \"slow\", position_m: (1.01, 0, 0), {of_slow}),");
    let link = format!("stiffness_n_m: 0.144, damping_n_s_m: {damping_n_s_m:?}, rest_length_m: 1.0");
    let mut springs =
        "(between: (\"wall\", \"slow\"), stiffness_n_m: 1296.0, rest_length_m: 1.0),".to_owned();
    let mut last = "slow".to_owned();
    for i in 0..20 {
        let name = format!("b{i}");
        let x = f64::from(i) + 2.0;
        write!(bodies, "(name: \"{name}\", position_m: ({x:?}, 0, 0), mass_kg: 0.001, {of_links}),").unwrap();
        write!(springs, "(between: (\"{last}\", \"{name}\"), {link}),").unwrap();
        last = name;
    }
    format!("(version: 1, step_hz: 120, {of_scene}, bodies: [{bodies}], springs: [{springs}])")
}

/// Every fast link is damped, and the slow weight is not: explicit Euler blows it up.
#[test]
fn the_mode_with_too_little_damping_is_found_among_faster_ones() {
    let scene = slow_and_links("method: explicit_euler", "", "", 0.036);
    let said = run_scene(&scene, "--refuse-unstable");
    assert!(
        said.code == 1
            && said.errors.contains("spring wall - slow: w h = 0.2999, explicit_euler is never stable"),
        "{}",
        said.errors
    );
}

/// Damping acts once a tick and springs a hundred times: of all that is there it is the least stable.
#[test]
fn damping_of_ticks_is_weighed_by_ticks() {
    let damped = "damping: (model: tutorial, rate_per_s: 0.0)";
    let scene = slow_and_links(
        &format!("method: velocity_verlet, substeps: 100, {damped}"),
        "damping_per_s: 300.0",
        "damping_per_s: 0.0",
        0.0,
    );
    let said = run_scene(&scene, "--refuse-unstable");
    assert!(said.code == 1 && said.errors.contains("damping of slow: c h"), "{}", said.errors);
    let scene =
        "(version: 1, method: implicit_euler, substeps: 100, damping: (model: tutorial, rate_per_s: 300.0),
        bodies: [(name: \"w\", immovable: true), (name: \"a\", position_m: (1.1, 0, 0), damping_per_s: 0.0),
            (name: \"b\", position_m: (2.1, 0, 0))],
        springs: [(between: (\"w\", \"a\"), stiffness_n_m: 300000.0, rest_length_m: 1.0),
            (between: (\"a\", \"b\"), stiffness_n_m: 1.0, rest_length_m: 1.0)])";
    let said = run_scene(scene, "");
    assert!(
        said.errors.contains("hung is unstable: damping of b: c h = 2.5, the limit of implicit_euler is 2"),
        "{}",
        said.errors
    );
}

/// Explicit Euler turns a speed v that only drag k v slows down into v (1 - k v h): it grows from k v h = 2 on.
#[test]
fn drag_that_turns_a_body_back_and_slows_it_down_is_stable() {
    for (drag, unstable) in [(19.8, false), (20.2, true)] {
        let scene = format!(
            "(version: 1, step_hz: 10, method: explicit_euler, drag: (quadratic_per_m: {drag:?}),
              bodies: [(name: \"a\", velocity_m_s: (1, 0, 0))])"
        );
        let said = run_scene(&scene, "--refuse-unstable");
        assert_eq!(said.code, i32::from(unstable), "{drag}: {}", said.errors);
    }
}

#[test]
fn particles_that_are_not_born_yet_are_looked_at() {
    let scene = "(version: 1, damping: (model: tutorial, rate_per_s: 300.0),
        emitters: [(rate_per_s: 100.0, speed_m_s: 1.0, life_s: 1.0)])";
    let said = run_scene(scene, "--refuse-unstable");
    assert!(
        said.code == 1 && said.errors.contains("c h = 2.5, the limit of semi_implicit_euler is 2"),
        "{}",
        said.errors
    );
}

#[test]
fn a_run_that_was_refused_wrote_nothing() {
    let said = run(1e8, "--refuse-unstable");
    assert_eq!((said.code, &said.files[..]), (1, &["hung.ron".to_owned()][..]), "{}", said.errors);
    assert!(said.errors.contains("hung is unstable: spring anchor - weight"), "{}", said.errors);
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
    let (pairs, springs): (String, String) = ((0..5).map(pair).collect(), (0..5).map(spring).collect());
    let said = run_scene(&format!("(version: 1, bodies: [{pairs}], springs: [{springs}])"), "");
    let lines: Vec<_> = said.errors.lines().filter(|line| line.contains("unstable")).collect();
    assert_eq!(lines.len(), 4, "{}", said.errors);
    assert!(
        lines[0].contains("spring a4 - b4") && lines[3].contains("2 more are unstable"),
        "{}",
        said.errors
    );
    assert_eq!(said.summary["forecast"].as_array().unwrap().len(), 5);
}
