//! Sweeps: what is measured against closed forms, and that shards, interruptions and threads change no byte.

use std::fs;
use std::io::Read as _;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Stdio};

use lab::Shard;
use lab::Value;
use lab::sweep::{Axis, Measure, Plan, Row, Sweep};
use motion::Method;
use scene::Scene;
use tempfile::TempDir;

use crate::rigs::{Dice, Said, command_lines, output, program, sandbox, wait_for};

fn sweep(scene: &str, axes: &[&str], seconds: f64, measures: &[Measure]) -> (Plan, Vec<Row>) {
    let axes = axes.iter().map(|axis| Axis::parse(axis).unwrap()).collect();
    let plan = Plan { axes, seconds, measures: measures.to_vec() };
    let sweep = Sweep::new(&Scene::parse("s", scene).unwrap(), plan.clone()).unwrap();
    let mut rows = Vec::new();
    sweep.run(Shard::WHOLE, 0, 2, |row| {
        rows.push(row);
        ControlFlow::Continue(())
    });
    (plan, rows)
}

/// The value of that column of a row.
#[track_caller]
fn value<'r>(plan: &Plan, row: &'r Row, name: &str) -> &'r Value {
    let at = plan.columns().iter().position(|column| column.name == name);
    &row.values[at.unwrap_or_else(|| panic!("no column {name}"))]
}

#[track_caller]
fn number(plan: &Plan, row: &Row, name: &str) -> f64 {
    match value(plan, row, name) {
        Value::Number(number) => *number,
        other => panic!("{name} is {other:?}"),
    }
}

const OSCILLATOR: &str = r#"(version: 1, bodies: [(name: "anchor", immovable: true), (name: "body", position_m: (1, 0, 0))],
    springs: [(between: ("anchor", "body"), stiffness_n_m: 1, rest_length_m: 0)])"#;

/// A moon around a planet around a heavy sun, whose energy hides that of the moon.
const MOON: &str = r#"(version: 1, mutual_gravity: (constant_m3_kg_s2: 1), bodies: [
    (name: "sun", mass_kg: 10000),
    (name: "planet", mass_kg: 1, position_m: (100, 0, 0), velocity_m_s: (0, 10, 0)),
    (name: "moon", mass_kg: 0.001, position_m: (100.5, 0, 0), velocity_m_s: (0, 11.4142136, 0))])"#;

#[test]
fn a_moon_that_leaves_its_planet_does_not_survive() {
    let axes = ["method=velocity_verlet,yoshida_4,runge_kutta_4", "step_hz=1,60"];
    let (plan, rows) = sweep(MOON, &axes, 40.0, &[Measure::Survives, Measure::Error]);
    for row in &rows {
        let is_fine = number(&plan, row, "step_hz") > 1.0;
        assert_eq!(value(&plan, row, "survives"), &Value::Flag(is_fine), "{row:?}");
        assert_eq!(number(&plan, row, "survived_s") > 39.0, is_fine, "{row:?}");
        assert_eq!(number(&plan, row, "error_m") < 1.0, is_fine, "{row:?}");
    }
}

#[test]
fn the_stability_limits_of_the_textbook_are_found_to_one_percent() {
    // Sixty values of w h from 1.5 to 2.95 in equal ratios: each rate has every third.
    let ratio: f64 = (2.95_f64 / 1.5).powf(1.0 / 59.0);
    let rates = [60.0, 60.0 / ratio, 60.0 / ratio.powi(2)].map(|rate| rate.to_string()).join(",");
    let (softest, stiffest) = (90.0_f64.powi(2), (90.0 * ratio.powi(57)).powi(2));
    let axes = [
        &*format!("springs[0].stiffness_n_m={softest}..{stiffest} log 20"),
        &*format!("step_hz={rates}"),
        "method=all",
    ];
    let (plan, rows) = sweep(OSCILLATOR, &axes, 10.0, &[Measure::Survives]);
    assert_eq!(rows.len(), 20 * 3 * 9);
    for method in Method::ALL {
        let of_it =
            |row: &&Row| value(&plan, row, "method") == &Value::Text(method.name().to_owned());
        let (mut survives, mut fails) = (Vec::new(), Vec::new());
        for row in rows.iter().filter(of_it) {
            let stiffness = number(&plan, row, "springs[0].stiffness_n_m");
            let wh = stiffness.sqrt() / number(&plan, row, "step_hz");
            match value(&plan, row, "survives") {
                Value::Flag(true) => survives.push(wh),
                _ => fails.push(wh),
            }
        }
        let highest = survives.iter().copied().fold(0.0, f64::max);
        let lowest = fails.iter().copied().fold(f64::INFINITY, f64::min);
        let limit = method.claims().stability_limit;
        if (1.5..2.95).contains(&limit) {
            let found = (highest * lowest).sqrt();
            assert!(highest < lowest, "{method:?}: {highest} survives and {lowest} does not");
            assert!(
                (found / limit - 1.0).abs() < 0.01,
                "{method:?}: {found}, where theory has {limit}"
            );
        } else {
            let all = if limit == 0.0 { &fails } else { &survives };
            assert_eq!(all.len(), 60, "{method:?}, whose limit is {limit}");
        }
    }
}

#[test]
fn a_fall_has_the_numbers_of_its_closed_form() {
    const FALL: &str =
        r"(version: 1, gravity: (acceleration_m_s2: (0, -10, 0)), bodies: [(mass_kg: 2)])";
    let measures = Measure::ALL;
    let axes = [
        "method=explicit_euler,semi_implicit_euler,runge_kutta_4",
        "step_hz=10,20,80",
        "bodies[0].mass_kg=2,5",
    ];
    let (plan, rows) = sweep(FALL, &axes, 2.0, &measures);
    assert_eq!(rows.len(), 18);
    let near = |found: f64, exact: f64| (found - exact).abs() <= 1e-12 * exact.abs().max(1.0);
    for (run, row) in (0_u64..).zip(&rows) {
        assert_eq!(row.run, run);
        let (g, t, h) = (10.0, 2.0, 1.0 / number(&plan, row, "step_hz"));
        let method = value(&plan, row, "method").to_string();
        // x of explicit Euler is g t (t - h) / 2, of semi-implicit Euler g t (t + h) / 2.
        let error = if method == "runge_kutta_4" { 0.0 } else { 0.5 * g * t * h };
        assert!(near(number(&plan, row, "error_m"), error), "{row:?}");
        assert!(number(&plan, row, "reference_error_m") < 1e-12);
        assert!(near(number(&plan, row, "largest_speed_m_s"), g * t), "{row:?}");
        let side = match method.as_str() {
            "explicit_euler" => -1.0,
            "semi_implicit_euler" => 1.0,
            _ => 0.0,
        };
        assert!(
            near(number(&plan, row, "largest_distance_m"), 0.5 * g * t * (t + side * h)),
            "{row:?}"
        );
        // The energy m g (x - x of the true fall) over the kinetic energy at the end, m (g t)² / 2.
        assert!(near(number(&plan, row, "drift"), side.abs() * h / t), "{row:?}");
        assert_eq!(value(&plan, row, "survives"), &Value::Flag(true));
        assert!(near(number(&plan, row, "survived_s"), t));
        let evaluations = if method == "runge_kutta_4" { 4.0 } else { 1.0 };
        assert_eq!(number(&plan, row, "evaluations_per_body"), evaluations * t / h);
        assert_eq!(value(&plan, row, "unconverged_steps"), &Value::Count(0));
        assert!(number(&plan, row, "cpu_s") > 0.0);
    }
    // What a state hash is, `run` says as well.
    let hash = value(&plan, &rows[0], "state_hash").to_string();
    let folder = crate::rigs::folder([("fall.ron", FALL)]);
    let line = "run fall.ron --method explicit_euler --hz 10 --seconds 2 --summary s.json";
    sandbox(&folder, line).fine();
    let summary = fs::read_to_string(folder.path().join("s.json")).unwrap();
    assert!(summary.contains(&hash), "{hash} is not in {summary}");
}

#[test]
fn a_million_million_million_runs_are_counted() {
    let plan = |axes: &[&str]| Plan {
        axes: axes.iter().map(|axis| Axis::parse(axis).unwrap()).collect(),
        seconds: 0.1,
        measures: vec![Measure::LargestSpeed],
    };
    let million = [
        "pace=1..2 lin 1000000",
        "step_hz=60..120 lin 1000000",
        "bodies[1].mass_kg=1..2 lin 1000000",
    ];
    let huge = Sweep::new(&Scene::parse("s", OSCILLATOR).unwrap(), plan(&million)).unwrap();
    assert_eq!(huge.plan().runs(), Some(1_000_000_000_000_000_000));
    assert_eq!(
        plan(&[million[0], million[1], million[2], "substeps=1..1000 lin 1000"]).runs(),
        None
    );
}

/// Runs a sweep of 240 runs into `folder/out`.
fn swept(folder: &Path, out: &str, more: &[&str]) -> Said {
    output(command(folder, out).args(more))
}

fn command(folder: &Path, out: &str) -> Command {
    let mut command = Command::new(program());
    command.current_dir(folder).args([
        "sweep",
        "oscillator",
        "--vary",
        "springs[0].stiffness_n_m=1..400 log 20",
    ]);
    command.args([
        "--vary",
        "method=semi_implicit_euler,runge_kutta_4,implicit_euler",
        "--vary",
        "step_hz=10,20,40,60",
    ]);
    command.args(["--seconds", "5", "--measure", "drift,error,survives,state_hash", "--out", out]);
    command
}

const FILES: [&str; 3] = ["runs.csv", "sweep.json", "sweep.svg"];

#[track_caller]
fn same_files(folder: &Path, [one, other]: [&str; 2]) {
    let names = |out: &str| {
        let entries = fs::read_dir(folder.join(out)).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort_unstable();
        names
    };
    assert_eq!([names(one), names(other)], [FILES; 2]);
    for name in FILES {
        let bytes = |out: &str| fs::read(folder.join(out).join(name)).unwrap();
        assert!(bytes(one) == bytes(other), "{name} differs in {one} and {other}");
    }
}

#[test]
fn shards_are_merged_to_the_bytes_of_one_run() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    swept(folder, "whole", &["--threads", "3"]).fine();
    for of in [1, 3, 7] {
        let outs: Vec<_> = (1..=of).map(|number| format!("{number}of{of}")).collect();
        for (number, out) in (1..=of).zip(&outs) {
            swept(folder, out, &["--shard", &format!("{number}/{of}"), "--threads", "1"]).fine();
        }
        let merged = format!("merged{of}");
        // In any order.
        let turned: Vec<_> = outs.iter().rev().cloned().collect();
        sandbox(folder, &format!("merge {} --out {merged}", turned.join(" "))).fine();
        same_files(folder, ["whole", &merged]);
    }
    sandbox(folder, "merge 1of3 2of3 3of3 --out merged3").fine();
    same_files(folder, ["whole", "merged3"]);
    fs::remove_file(folder.join("merged3/runs.csv")).unwrap();
    swept(folder, "merged3", &["--resume"]).fine();
    same_files(folder, ["whole", "merged3"]);
    // A table that someone changed is not merged.
    let table = folder.join("2of3/runs.csv");
    let text = fs::read_to_string(&table).unwrap();
    fs::write(&table, text.replacen("\n4,", "\n5,", 1)).unwrap();
    sandbox(folder, "merge 1of3 2of3 3of3 --out x").fails(
        2,
        "2of3/runs.csv: this table does not have the checksum of its record; it was changed",
    );
    assert!(!folder.join("x").exists());
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_says_how_it_continues() {
    let folder = TempDir::new().unwrap();
    let mut long = Command::new(program());
    long.current_dir(folder.path()).args([
        "sweep",
        "oscillator",
        "--seconds",
        "20",
        "--out",
        "long",
    ]);
    long.args(["--vary", "step_hz=100..1000 lin 5000"]);
    let mut long = long.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for("a run", || {
        let journal = fs::read_to_string(folder.path().join("long/runs.part.csv")).ok()?;
        (journal.lines().count() > 1).then_some(())
    });
    // A shell may start what it runs in the background with interrupts ignored, and they stay ignored.
    let mut interrupt = Command::new("kill");
    assert!(interrupt.args(["-TERM", &long.id().to_string()]).status().unwrap().success());
    assert_eq!(long.wait().unwrap().code(), Some(143));
    let mut said = String::new();
    long.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    let words = "long: what was run is in that folder, and the same command with --resume continues after it";
    assert!(said.contains(words), "{said}");
}

#[test]
fn a_sweep_that_is_killed_five_times_is_the_same_in_the_end() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    swept(folder, "whole", &[]).fine();
    let (mut dice, mut done, mut kills) = (Dice(7), 0, 0);
    while kills < 5 {
        let enough = done + 1 + dice.below(30);
        let mut running = command(folder, "killed");
        if kills > 0 {
            running.arg("--resume");
        }
        let mut running = running.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let lines = || {
            let journal =
                fs::read_to_string(folder.join("killed/runs.part.csv")).unwrap_or_default();
            journal.lines().count().saturating_sub(1)
        };
        wait_for("enough runs", || (lines() >= enough).then_some(()));
        running.kill().unwrap();
        running.wait().unwrap();
        done = lines();
        kills += 1;
    }
    assert!(done < 240, "it was never interrupted");
    swept(folder, "killed", &[])
        .fails(2, "this sweep is not complete; --resume continues it; or give another folder");
    // A line that was cut is run again.
    let journal = folder.join("killed/runs.part.csv");
    let text = fs::read_to_string(&journal).unwrap();
    fs::write(&journal, &text[..text.len() - 9]).unwrap();
    let said = swept(folder, "killed", &["--resume"]).fine();
    assert!(said.contains("were done before"), "{said}");
    same_files(folder, ["whole", "killed"]);
    assert_eq!(swept(folder, "killed", &["--resume"]).fine(), "killed: this sweep is complete\n");
    swept(folder, "killed", &["--seconds", "4"]).fails(2, "");
    sandbox(folder, "sweep oscillator --vary step_hz=10,20 --out killed").fails(
        2,
        "killed/sweep.json: the sweep in this folder is of other values; give another folder, or remove it",
    );
}

#[test]
fn runs_are_printed_and_shards_that_do_not_fit_are_not_merged() {
    command_lines("sweep");
}
