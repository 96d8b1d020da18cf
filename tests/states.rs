//! The state file: its columns against closed forms and the summary, and its rows.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use glam::DVec3;
use tempfile::TempDir;

use crate::rigs::{folder, root, sandbox};

/// The rows of a state file as CSV, by the names of the columns.
fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

/// A number of a row.
#[track_caller]
fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is {:?} in {row:?}", row[column]))
}

#[track_caller]
fn vector(row: &BTreeMap<String, String>, name: &str, unit: &str) -> [f64; 3] {
    ["x", "y", "z"].map(|axis| number(row, &format!("{name}_{axis}_{unit}")))
}

const ALL: &str = "position,velocity,acceleration,force,forces,energies,momentum,angular_momentum";

/// A weight of 2 kg on a spring without length, in gravity and damping.
const WEIGHT: &str = r#"(version: 1, gravity: (), damping: (model: exact, rate_per_s: 0.5), method: runge_kutta_4,
    bodies: [(name: "anchor", immovable: true), (name: "weight", mass_kg: 2, position_m: (1, 2, 0), velocity_m_s: (0, 0, 3))],
    springs: [(between: ("anchor", "weight"), stiffness_n_m: 50, rest_length_m: 0)])"#;

#[test]
fn every_column_is_its_closed_form() {
    let folder = folder([("weight.ron", WEIGHT)]);
    let line = format!(
        "run weight.ron --seconds 2 --state s.csv --columns {ALL},distance:anchor --every 7"
    );
    sandbox(&folder, &line).fine();
    let (mut weights, mut anchors) = (0, 0);
    // Against y = -0.784 m, where spring and weight are in balance.
    let (mass, stiffness, damping, gravity) = (2.0, 50.0, 0.5, 9.8);
    let balance = [0.0, -mass * gravity / stiffness, 0.0];
    let start = [[1.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
    let omega = f64::sqrt(stiffness / mass - damping * damping / 4.0);
    for row in rows(&folder.path().join("s.csv")) {
        let time = number(&row, "time_s");
        let near = |found: f64, exact: f64| {
            assert!((found - exact).abs() <= 1e-4, "{found} for {exact} in {row:?}");
        };
        let is = |name: &str, unit: &str, exact: [f64; 3]| {
            vector(&row, name, unit)
                .into_iter()
                .zip(exact)
                .for_each(|(found, exact)| near(found, exact));
        };
        if row["body"] == "anchor" {
            anchors += 1;
            let empty = ["acceleration_x_m_s2", "force_y_n", "force_springs_x_n", "force_push_z_n"];
            assert!(empty.iter().all(|column| row[*column].is_empty()), "{row:?}");
            near(number(&row, "distance_anchor_m"), 0.0);
            continue;
        }
        weights += 1;
        let (sin, cos) = (omega * time).sin_cos();
        let decay = (-damping * time / 2.0).exp();
        let axis = |axis: usize| {
            let [x0, v0] = start.map(|start| start[axis]);
            let a = x0 - balance[axis];
            let b = (v0 + damping / 2.0 * a) / omega;
            let x = decay * (a * cos + b * sin);
            let v = decay * omega * (b * cos - a * sin) - damping / 2.0 * x;
            (x + balance[axis], v)
        };
        let (x, v) = ([0, 1, 2].map(|i| axis(i).0), [0, 1, 2].map(|i| axis(i).1));
        let squared = |v: [f64; 3]| v.iter().map(|part| part * part).sum::<f64>();
        is("position", "m", x);
        is("velocity", "m_s", v);
        is("momentum", "kg_m_s", v.map(|v| mass * v));
        is("force_push", "n", [0.0; 3]);
        is("force_gravity", "n", [0.0, -mass * gravity, 0.0]);
        is("force_springs", "n", x.map(|x| -stiffness * x));
        is("force_damping", "n", v.map(|v| -mass * damping * v));
        let force = [0, 1, 2].map(|i| {
            -stiffness * x[i] - mass * damping * v[i] - if i == 1 { mass * gravity } else { 0.0 }
        });
        is("force", "n", force);
        is("acceleration", "m_s2", force.map(|force| force / mass));
        let [a, b] = [x, v.map(|v| mass * v)];
        let turn =
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        is("angular_momentum", "kg_m2_s", turn);
        near(number(&row, "kinetic_energy_j"), mass * squared(v) / 2.0);
        near(number(&row, "potential_energy_gravity_j"), mass * gravity * x[1]);
        near(number(&row, "potential_energy_springs_j"), stiffness * squared(x) / 4.0);
        near(number(&row, "distance_anchor_m"), squared(x).sqrt());
    }
    // Ticks 0, 7, ... 238, and the last.
    assert_eq!([weights, anchors], [36, 36]);
}

/// Distances of the planets from their start, m, at the end of that tick.
fn off_start(rows: &[BTreeMap<String, String>], tick: u32) -> BTreeMap<String, f64> {
    let place = |row: &BTreeMap<String, String>| DVec3::from(vector(row, "position", "m"));
    let at = |tick: u32| rows.iter().filter(move |row| row["tick"] == tick.to_string());
    let start: BTreeMap<_, _> = at(0).map(|row| (row["body"].clone(), place(row))).collect();
    at(tick).map(|row| (row["body"].clone(), place(row).distance(start[&row["body"]]))).collect()
}

#[test]
fn time_turned_around_brings_back_what_is_moved_by_reversible_methods() {
    let folder = TempDir::new().unwrap();
    let script = root().join("assets/scripts/there_and_back.ron");
    let flags = "--seconds 24.2 --size 64x36 --state s.csv --every 2";
    sandbox(&folder, &format!("run orbits_race --script {} {flags}", script.display())).fine();
    let rows = rows(&folder.path().join("s.csv"));
    let back = off_start(&rows, 720);
    for method in ["position_verlet", "velocity_verlet", "yoshida_4"] {
        assert!(back[method] < 1e-9, "{method}: {}", back[method]);
    }
    // As the script says.
    let said = [
        ("runge_kutta_4", 7e-5),
        ("runge_kutta_2_midpoint", 0.11),
        ("runge_kutta_2_heun", 0.14),
        ("explicit_euler", 2.4),
        ("semi_implicit_euler", 6.1),
    ];
    for (method, meters) in said {
        assert!((back[method] / meters - 1.0).abs() < 0.06, "{method}: {}", back[method]);
    }
    let put_back = off_start(&rows, 1446);
    assert!(put_back["explicit_euler"] < 1e-9, "{}", put_back["explicit_euler"]);
}

#[test]
fn sums_over_all_rows_are_the_totals_of_the_summary() {
    for scene in [
        "thousand",
        "oscillator",
        "orbit",
        "solar",
        "figure_eight",
        "flag",
        "jelly",
        "bungee",
        "everything",
    ] {
        let folder = TempDir::new().unwrap();
        let flags = "--ticks 40 --state s.csv --every 40 --summary s.json";
        sandbox(
            &folder,
            &format!("run {scene} {flags} --columns energies,momentum,angular_momentum"),
        )
        .fine();
        let at = |name: &str| folder.path().join(name);
        let summary: serde_json::Value =
            serde_json::from_slice(&fs::read(at("s.json")).unwrap()).unwrap();
        let mut sums = BTreeMap::<String, [f64; 2]>::new();
        for row in rows(&at("s.csv")).into_iter().filter(|row| row["tick"] == "40") {
            for column in
                row.keys().filter(|column| !["tick", "time_s", "body"].contains(&&***column))
            {
                let kind = if column.starts_with("potential_energy") {
                    "potential_energy_j"
                } else {
                    column
                };
                let [sum, size] = sums.entry(kind.to_owned()).or_default();
                *sum += number(&row, column);
                *size += number(&row, column).abs();
            }
        }
        let near = |sum: &str, exact: &serde_json::Value| {
            let ([sum, size], exact) = (sums[sum], exact.as_f64().unwrap());
            assert!((sum - exact).abs() <= 1e-12 * size, "{scene}: {sum} for {exact}");
        };
        near("kinetic_energy_j", &summary["kinetic_energy_j"]);
        near("potential_energy_j", &summary["potential_energy_j"]);
        for (at, axis) in ["x", "y", "z"].into_iter().enumerate() {
            near(&format!("momentum_{axis}_kg_m_s"), &summary["momentum_kg_m_s"][at]);
            near(
                &format!("angular_momentum_{axis}_kg_m2_s"),
                &summary["angular_momentum_kg_m2_s"][at],
            );
        }
    }
}

#[test]
fn accelerations_are_what_velocities_do_next() {
    // Semi-implicit Euler: the velocity after a tick is that before it with the acceleration of its state, but for damping.
    let folder = TempDir::new().unwrap();
    for (scene, ticks) in [("flag", 20), ("figure_eight", 20), ("third_law", 20)] {
        let line = format!(
            "run {scene} --ticks {ticks} --hz 1000 --method semi_implicit_euler --substeps 1 --state s.csv"
        );
        sandbox(&folder, &format!("{line} --columns velocity,acceleration")).fine();
        let rows = rows(&folder.path().join("s.csv"));
        let bodies = rows.iter().filter(|row| row["tick"] == "0").count();
        for (before, after) in rows
            .iter()
            .zip(&rows[bodies..])
            .filter(|(row, _)| !row["acceleration_x_m_s2"].is_empty())
        {
            assert_eq!(before["body"], after["body"]);
            let h = number(after, "time_s") - number(before, "time_s");
            let [v, next] = [before, after].map(|row| vector(row, "velocity", "m_s"));
            let a = vector(before, "acceleration", "m_s2");
            for i in 0..3 {
                let expected = v[i] + h * a[i];
                let size = v[i].abs().max(h * a[i].abs()).max(1e-3);
                assert!(
                    (next[i] - expected).abs() <= 1e-9 * size,
                    "{scene}: {} for {expected}: {before:?}",
                    next[i]
                );
            }
        }
    }
}

#[test]
fn only_bodies_with_such_names_have_rows() {
    let folder = TempDir::new().unwrap();
    let names = |patterns: &str| {
        sandbox(&folder, &format!("run flag --ticks 1 --state s.csv --bodies {patterns}")).fine();
        let rows = rows(&folder.path().join("s.csv")).into_iter().filter(|row| row["tick"] == "1");
        rows.map(|row| row["body"].clone()).collect::<Vec<_>>()
    };
    assert_eq!(names("flag.r?.c1").len(), 10);
    assert_eq!(names("flag.r3.c2,flag.r1.c2"), ["flag.r1.c2", "flag.r3.c2"]);
    assert_eq!(names("*.r1.*").len(), names("flag.r1.c*").len());
    let sheet = names("*.c3");
    assert!(sheet.len() > 10 && sheet.iter().all(|name| name.ends_with(".c3")), "{sheet:?}");
}
