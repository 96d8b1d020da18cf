//! Natural modes against closed forms: chains between walls, posts of their own, and what the command prints of them.

use history::Simulation;
use motion::margin::{NaturalMode, NaturalModes, natural_modes};
use scene::Scene;
use serde_json::Value;
use tempfile::TempDir;

use crate::rigs::{folder, sandbox};

/// Springs of a chain, N/m.
const STIFFNESS: f64 = 100.0;
/// Its dampers, N s/m.
const DAMPER: f64 = 0.5;
/// The rate of the scene's damping, 1/s.
const RATE: f64 = 0.25;

/// A chain of `bodies` bodies of 1 kg, 1 m apart along x between two walls, whose springs have length `rest_length` at rest.
fn chain(bodies: usize, rest_length: f64) -> String {
    let body = |i: usize| {
        let held = if i == 0 || i == bodies + 1 { "immovable: true" } else { "mass_kg: 1" };
        format!("(name: \"b{i}\", position_m: ({i}, 0, 0), {held})")
    };
    let spring = |i: usize| {
        format!(
            "(between: (\"b{i}\", \"b{}\"), stiffness_n_m: {STIFFNESS}, damping_n_s_m: {DAMPER}, rest_length_m: {rest_length})",
            i + 1
        )
    };
    let all: Vec<_> = (0..bodies + 2).map(body).collect();
    let springs: Vec<_> = (0..=bodies).map(spring).collect();
    format!(
        "(version: 1, damping: (rate_per_s: {RATE}), bodies: [{}], springs: [{}])",
        all.join(", "),
        springs.join(", ")
    )
}

fn modes(scene: &str, count: usize) -> (Simulation, NaturalModes) {
    let simulation = Simulation::new(Scene::parse("s", scene).unwrap());
    let modes = natural_modes(&simulation.world, count);
    (simulation, modes)
}

/// `2 sqrt(k/m) sin(j pi / (2 (N + 1)))`, rad/s.
fn frequency(number: usize, bodies: usize) -> f64 {
    2.0 * STIFFNESS.sqrt()
        * (number as f64 * std::f64::consts::PI / (2.0 * (bodies as f64 + 1.0))).sin()
}

#[track_caller]
fn near(found: f64, exact: f64) {
    assert!((found / exact - 1.0).abs() <= 1e-6, "{found} for {exact}");
}

#[test]
fn a_chain_at_its_rest_length_has_the_frequencies_and_damping_of_the_textbook() {
    // Solved as a whole, and by iteration.
    for bodies in [1, 2, 10, 40, 41, 100, 300] {
        let (simulation, NaturalModes { lowest, highest }) = modes(&chain(bodies, 1.0), 5);
        let (slow, fast) = (bodies.min(5), bodies.saturating_sub(5).min(5));
        assert_eq!([lowest.len(), highest.len()], [slow, fast], "{bodies}");
        let numbers = (1..=slow).chain(bodies - fast + 1..=bodies);
        for (number, mode) in numbers.zip(lowest.iter().chain(&highest)) {
            let omega = frequency(number, bodies);
            near(mode.angular_frequency, omega);
            near(mode.damping_ratio, DAMPER * omega / (2.0 * STIFFNESS) + RATE / (2.0 * omega));
            // Bodies move as `sin(j pi i / (N + 1))`.
            let shape = |i: usize| {
                (number as f64 * std::f64::consts::PI * i as f64 / (bodies as f64 + 1.0))
                    .sin()
                    .abs()
            };
            let most = (1..=bodies).map(shape).fold(0.0, f64::max);
            for (body, amplitude) in &mode.bodies {
                let i = (1..=bodies)
                    .find(|i| simulation.named(&format!("b{i}")) == Some(*body))
                    .unwrap();
                assert!(
                    (amplitude - shape(i) / most).abs() <= 1e-3,
                    "{bodies} {number}: {amplitude} of b{i}"
                );
            }
            assert_eq!(mode.bodies.len(), bodies.min(NaturalMode::BODIES));
        }
    }
}

#[test]
fn a_mode_is_found_as_often_as_it_is_there() {
    // Springs without length hold alike in every direction; their dampers do so along themselves alone.
    for bodies in [5, 60] {
        let (_, NaturalModes { lowest, highest }) = modes(&chain(bodies, 0.0), 6);
        for (at, mode) in lowest.iter().enumerate() {
            near(mode.angular_frequency, frequency(at / 3 + 1, bodies));
        }
        for (at, mode) in highest.iter().rev().enumerate() {
            near(mode.angular_frequency, frequency(bodies - at / 3, bodies));
        }
    }
}

#[test]
fn modes_of_a_light_chain_that_carries_a_heavy_load_are_those_of_a_string() {
    // 60 links of 1 g between a wall and 1 t, each on a spring under 100 N: the squares of frequencies are ten decades apart.
    let (links, mass, tension) = (60, 0.001, 100.0);
    let body = |i: usize| {
        let held = match i {
            0 => "immovable: true".to_owned(),
            i if i > links => "mass_kg: 1000".to_owned(),
            _ => format!("mass_kg: {mass}"),
        };
        format!("(name: \"b{i}\", position_m: (0, {}, 0), {held})", -(i as f64))
    };
    let spring = |i: usize| {
        format!("(between: (\"b{i}\", \"b{}\"), stiffness_n_m: 10000, rest_length_m: 0.99)", i + 1)
    };
    let bodies: Vec<_> = (0..links + 2).map(body).collect();
    let springs: Vec<_> = (0..=links).map(spring).collect();
    let scene =
        format!("(version: 1, bodies: [{}], springs: [{}])", bodies.join(", "), springs.join(", "));
    let (_, NaturalModes { lowest, .. }) = modes(&scene, 9);
    // The load swings across in two directions and along the chain; then the links, between two fixed ends, in pairs.
    let string = |k: usize| {
        2.0 * f64::sqrt(tension / mass)
            * (k as f64 * std::f64::consts::PI / (2.0 * (links as f64 + 1.0))).sin()
    };
    for (at, mode) in lowest[3..].iter().enumerate() {
        let exact = string(at / 2 + 1);
        let found = mode.angular_frequency;
        assert!((found / exact - 1.0).abs() <= 1e-3, "{found} for {exact}");
    }
}

#[test]
fn a_well_beside_a_spring_adds_its_own_stiffness() {
    // `a = -mu r / r³` stretches what it attracts along r by 2 mu / r³, and pushes what it repels.
    for (strength, stiffness) in [(8.0, 100.0), (-8.0, 10.0)] {
        let scene = format!(
            "(version: 1, bodies: [(name: \"a\", immovable: true), (name: \"b\", position_m: (1, 0, 0), locked_axes: [y, z])],
            springs: [(between: (\"a\", \"b\"), stiffness_n_m: {stiffness}, rest_length_m: 1)], wells: [(strength_m3_s2: {strength})])"
        );
        let (_, NaturalModes { lowest, .. }) = modes(&scene, 3);
        assert_eq!(lowest.len(), 1);
        near(lowest[0].angular_frequency, f64::sqrt(stiffness - 2.0 * strength));
    }
}

#[test]
fn a_frequency_that_counts_a_well_by_half_is_an_upper_bound() {
    // Across the chain the well pulls back, along it the well stretches: only a small group counts both.
    for (bodies, is_large) in [(30, false), (60, true)] {
        let middle = 0.5 * (bodies as f64 + 1.0);
        let beside = chain(bodies, 1.0).replace(
            "bodies: [",
            &format!("wells: [(strength_m3_s2: 1.0, position_m: ({middle}, 3, 0))], bodies: ["),
        );
        let (_, NaturalModes { lowest, highest }) = modes(&beside, 5);
        let mut all = lowest.iter().chain(&highest);
        assert!(all.all(|mode| mode.is_upper_bound == is_large), "{bodies}");
        let (_, NaturalModes { lowest, .. }) = modes(&chain(bodies, 1.0), 5);
        assert!(lowest.iter().all(|mode| !mode.is_upper_bound), "{bodies}");
        if is_large {
            let folder = folder([("well.ron", beside)]);
            let said = sandbox(&folder, "forecast well.ron --modes 1").fine();
            assert!(said.contains("at most ") && said.contains("at least "), "{said}");
        }
    }
}

#[test]
fn modes_of_several_groups_are_sorted_and_none_is_told_of_twice() {
    let post = |i: usize| {
        format!(
            "(name: \"p{i}\", position_m: ({i}, 0, 0), immovable: true), (name: \"b{i}\", position_m: ({i}, 1, 0), mass_kg: 2)"
        )
    };
    let spring = |i: usize| {
        let stiffness = 2 * i * i;
        format!("(between: (\"p{i}\", \"b{i}\"), stiffness_n_m: {stiffness}, rest_length_m: 1)")
    };
    let of = |each: &dyn Fn(usize) -> String| [3, 1, 2].map(each).join(", ");
    let scene = format!("(version: 1, bodies: [{}], springs: [{}])", of(&post), of(&spring));
    let cases: [(usize, &[usize], &[usize]); 4] =
        [(1, &[1], &[3]), (2, &[1, 2], &[3]), (3, &[1, 2, 3], &[]), (5, &[1, 2, 3], &[])];
    for (count, slow, fast) in cases {
        let (_, NaturalModes { lowest, highest }) = modes(&scene, count);
        let found = |modes: &[NaturalMode]| {
            modes.iter().map(|mode| mode.angular_frequency.round() as usize).collect::<Vec<_>>()
        };
        assert_eq!(found(&lowest), slow);
        assert_eq!(found(&highest), fast);
    }
}

#[test]
fn the_few_modes_of_a_large_group_are_listed_once() {
    // Of 60 springs in a row only three pull, each on two bodies of 1 kg.
    let text = chain(60, 1.0);
    let text = text.split(&format!("stiffness_n_m: {STIFFNESS}")).collect::<Vec<_>>();
    let mut all = text[0].to_owned();
    for (spring, rest) in text[1..].iter().enumerate() {
        let stiffness = if [10, 20, 30].contains(&spring) { 100 * spring } else { 0 };
        all += &format!("stiffness_n_m: {stiffness}{rest}");
    }
    let (_, NaturalModes { lowest, highest }) = modes(&all, 2);
    let found = |modes: &[NaturalMode]| -> Vec<f64> {
        modes.iter().map(|mode| mode.angular_frequency.powi(2) / 2.0).collect()
    };
    let (lowest, highest) = (found(&lowest), found(&highest));
    assert_eq!((lowest.len(), highest.len()), (2, 1), "{lowest:?} {highest:?}");
    near(lowest[0], 1000.0);
    near(lowest[1], 2000.0);
    near(highest[0], 3000.0);
}

#[test]
fn what_nothing_pulls_back_has_no_mode() {
    let (_, free) = modes("(version: 1, gravity: (), bodies: [(name: \"ball\")])", 3);
    assert_eq!(free, NaturalModes::default());
    // Two bodies on a spring swing against each other, and drift freely.
    let pair =
        "(version: 1, bodies: [(name: \"a\"), (name: \"b\", position_m: (1, 0, 0), mass_kg: 3)],
        springs: [(between: (\"a\", \"b\"), stiffness_n_m: 12, rest_length_m: 1)])";
    let (_, NaturalModes { lowest, highest }) = modes(pair, 3);
    assert_eq!([lowest.len(), highest.len()], [1, 0]);
    near(lowest[0].angular_frequency, f64::sqrt(12.0 * (1.0 + 1.0 / 3.0)));
}

#[test]
fn the_command_tells_the_modes_and_how_far_everything_is_from_instability() {
    let folder = folder([("chain.ron", chain(3, 1.0))]);
    let said = sandbox(&folder, "forecast chain.ron --modes 2 --hz 100 --format json").fine();
    let found: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(found["step_hz"], 100.0);
    let [lowest, highest] =
        ["lowest", "highest"].map(|end| found["modes"][end].as_array().unwrap().clone());
    assert_eq!([lowest.len(), highest.len()], [2, 1]);
    for (number, mode) in (1..).zip(lowest.iter().chain(&highest)) {
        let hz = frequency(number, 3) / std::f64::consts::TAU;
        near(mode["frequency_hz"].as_f64().unwrap(), hz);
        near(mode["period_s"].as_f64().unwrap(), 1.0 / hz);
    }
    assert_eq!(lowest[0]["bodies"][0]["body"], "b2");
    assert_eq!(lowest[0]["bodies"][0]["amplitude"], 1.0);
    // The value of the forecast is that of the fastest mode, to its tolerance.
    let rows = found["forecast"].as_array().unwrap();
    let row = rows.iter().find(|row| row["instrument"] == "margin").unwrap();
    assert_eq!([&row["verdict"], &row["method"]], ["stable", "semi_implicit_euler"]);
    let value = row["value"].as_f64().unwrap();
    assert!((value / (frequency(3, 3) / 100.0) - 1.0).abs() < 1e-2, "{row}");
    let table = sandbox(&folder, "forecast chain.ron --modes 2").fine();
    assert!(table.contains("natural modes at the start") && table.contains("b2 1.00"), "{table}");
    let without = sandbox(&folder, "forecast chain.ron --format json").fine();
    assert!(serde_json::from_str::<Value>(&without).unwrap()["modes"].is_null());
    let free = sandbox(TempDir::new().unwrap(), "forecast tutorial --modes 3").fine();
    assert!(free.contains("no natural modes: no springs hold a body that can move"), "{free}");
}
