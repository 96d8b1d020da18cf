//! The parts of scenes, settings written into scene texts, and what `sandbox recommend` chooses.

mod promise;

use std::fs;

use history::Simulation;
use lab::cost::{Accuracy, Cost, Study};
use motion::Method;
use scene::{Scene, Setting, Substepping, load, shipped};
use serde_json::Value;

use crate::rigs::{self, Bits, all_bits, command_lines, sandbox};

/// Stiff cloth, a rope with a weight, and free debris: three parts that differ in what they need.
const GROUPS: &str = r#"// Stiff cloth and free debris.
(
    version: 1,
    step_hz: 60, // of pictures
    // What was tried first.
    method: explicit_euler,
    gravity: (),
    drag: (linear_per_s: 0.3, quadratic_per_m: 0.05),
    wind: (velocity_m_s: (3, 0, 0), gust_m_s: 1, gust_hz: 2),
    wells: [(strength_m3_s2: 2, softening_m: 1, bodies: ["rock", "weight"])],
    thrusts: [(body: "ship", curve: polynomial([(3, 1, 0)]), from_s: 0.03, until_s: 0.11)],
    seed: 5,
    bodies: [
        (name: "post", shape: cuboid(half_extents_m: (1, 1, 1)), immovable: true, position_m: (0, 9, 0)),
        (name: "sign", shape: cuboid(half_extents_m: (1, 1, 1)), scenery: true),
        (name: "rock", position_m: (0, 4, 0), velocity_m_s: (2, 3, 0)), // debris
        (name: "weight", position_m: (4, 9, 0), mass_kg: 0.5),
        (name: "ship", position_m: (1, 5, 2), max_speed_m_s: 5, method: yoshida_4),
    ],
    grids: [(kind: spheres, rows: 2, columns: 2, spacing_m: (2, 2), origin_m: (0, 12, 0))],
    emitters: [(rate_per_s: 40, life_s: 0.3, speed_m_s: 4, spread_deg: 20)],
    soft_bodies: [
        cloth(name: "flag", rows: 3, columns: 4, along_m: (3, 0, 0), down_m: (0, -2, 0), mass_kg: 0.6,
              stiffness_n_m: 400, damping_n_s_m: 0.1, shear: true, pinned: [left_edge]), // stiff
        chain(name: "rope", points: 4, from_m: (1, 9, 0), to_m: (3, 9, 0), stiffness_n_m: 60),
    ],
    springs: [
        (between: ("post", "rope.0"), stiffness_n_m: 80),
        (between: ("rope.3", "weight"), stiffness_n_m: 80),
    ],
)
"#;

fn groups() -> Scene {
    Scene::parse("groups", GROUPS).unwrap_or_else(|error| panic!("{error}"))
}

/// Bits of position and velocity of every body after some ticks, by stable id.
fn states(scene: &Scene, ticks: u64) -> Vec<(u32, Bits)> {
    let mut run = Simulation::new(scene.clone());
    run.run(ticks);
    all_bits(run.states())
}

#[track_caller]
fn runs_alone_as_in_the_whole(scene: &Scene) {
    let whole = states(scene, 60);
    for part in scene.parts() {
        let alone = states(&part.scene, 60);
        assert!(!alone.is_empty());
        for (id, state) in alone {
            let id = part.bodies[id as usize];
            let place = whole.binary_search_by_key(&id, |(id, _)| *id).unwrap();
            let name = scene.names.get(id).unwrap();
            assert_eq!(
                whole[place].1,
                state,
                "{name} of {} by {}",
                scene.name,
                scene.method.name()
            );
        }
    }
}

#[test]
fn parts_run_alone_as_they_do_in_the_whole() {
    let several =
        shipped().iter().map(|scene| scene.load().unwrap()).filter(|scene| scene.parts().len() > 1);
    let scenes: Vec<_> = several.chain([groups()]).collect();
    let names: Vec<_> = scenes.iter().map(|scene| scene.name.as_str()).collect();
    assert_eq!(names, ["third_law", "everything", "bungee", "resonance", "groups"]);
    for mut scene in scenes {
        for method in [Method::SemiImplicitEuler, Method::VelocityVerlet, Method::RungeKutta4] {
            scene.method = method;
            runs_alone_as_in_the_whole(&scene);
        }
    }
}

#[test]
fn a_part_of_everything_is_the_same_too() {
    for name in ["rope", "bridge", "cape", "fountain", "orbits_race", "ship_between"] {
        let scene = load(name).unwrap();
        assert_eq!(scene.parts().len(), 1, "{name}");
        runs_alone_as_in_the_whole(&scene);
    }
    assert!(load("empty").unwrap().parts().is_empty());
}

/// What stands behind `//` on each line that has it.
fn comments(text: &str) -> Vec<&str> {
    text.lines().filter_map(|line| line.split_once("//")).map(|(_, comment)| comment).collect()
}

/// Edits the settings of the scene and of every entry of its parts, and looks for anything else that changed.
#[track_caller]
fn round_trip(name: &str, text: &str, common: Setting, own: impl Fn(usize) -> Setting) {
    let before = Scene::parse(name, text).unwrap();
    let mut expected = before.clone();
    (expected.method, expected.substeps) = (common.method, common.substeps);
    let (parts, mut entries) = (before.parts(), Vec::new());
    for (i, part) in parts.iter().enumerate() {
        for entry in &part.entries {
            entries.push((entry, own(i)));
            for id in entry.bodies.clone() {
                let body = &mut expected.bodies[id as usize];
                (body.method, body.substeps) = (Some(own(i).method), Some(own(i).substeps));
            }
        }
    }
    let edited =
        before.with_methods(name, common, &entries).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(comments(&edited), comments(text), "{name}");
    // What an entry need not say, because the scene does, it does not.
    let without_lines = |mut scene: Scene| {
        scene.declared.iter_mut().for_each(|declaration| declaration.line = None);
        for body in &mut scene.bodies {
            body.method = Some(body.method.unwrap_or(scene.method));
            body.substeps = Some(body.substeps.unwrap_or(scene.substeps));
        }
        scene
    };
    let after = Scene::parse(name, &edited).unwrap();
    assert_eq!(*after.text, *edited, "{name}");
    // All keys are there now: the same again changes nothing, and other values change only themselves.
    assert_eq!(after.with_methods(name, common, &entries).unwrap(), edited, "{name}");
    let expected = Scene { text: after.text.clone(), ..expected };
    assert_eq!(without_lines(after), without_lines(expected), "{name}");
    // Lines are added, never run together or torn apart.
    let kept = text.lines().filter(|line| line.trim_start().starts_with("//"));
    assert!(kept.clone().all(|line| edited.lines().any(|of| of == line)), "{name}");
    assert!(edited.lines().all(|line| line.trim() != ","), "{name}");
}

#[test]
fn settings_are_written_into_every_shipped_scene() {
    let many =
        [(Method::RungeKutta4, 2), (Method::VelocityVerlet, 5), (Method::SemiImplicitEuler, 1)]
            .map(|(method, substeps)| Setting { method, substeps: Substepping::Fixed(substeps) });
    let fine = Setting { method: Method::Yoshida4, substeps: 3.into() };
    for shipped in shipped() {
        let verlet = shipped.text.contains("verlet_previous_position_m");
        // Position Verlet alone knows a previous position.
        let method = Method::PositionVerlet;
        let common = if verlet { Setting { method, substeps: 3.into() } } else { fine };
        let own = |part: usize| {
            if verlet { Setting { method, substeps: 4.into() } } else { many[part % many.len()] }
        };
        round_trip(shipped.name, shipped.text, common, own);
        if verlet {
            let scene = shipped.load().unwrap();
            let refused = scene.with_methods(shipped.name, fine, &[]);
            assert!(refused.unwrap_err().to_string().contains("knows no previous position"));
        }
    }
    round_trip("groups", GROUPS, fine, |part| many[part % many.len()]);
    round_trip("groups", &GROUPS.replace('\n', "\r\n"), fine, |part| many[part % many.len()]);
}

fn folder() -> tempfile::TempDir {
    rigs::folder([("groups.ron", GROUPS)])
}

/// The pick of each part in a JSON report, checked against the part's own study: (name, method, substeps, price).
fn picks(report: &Value) -> Vec<(String, Method, Substepping, f64)> {
    let mut picks = Vec::new();
    for part in report["parts"].as_array().unwrap() {
        let study: Study = serde_json::from_value(part["study"].clone()).unwrap();
        let pick = &part["pick"];
        let method = Method::from_name(pick["method"].as_str().unwrap()).unwrap();
        let substeps = serde_json::from_value(pick["substeps"].clone()).unwrap();
        let front = study.front(Accuracy::Position, Cost::RealTime);
        let on_front = |cell: &&&lab::cost::Cell| {
            cell.setting.method == method && cell.setting.substeps == substeps
        };
        let cell = front.iter().find(on_front).expect("a point of the measured front");
        assert_eq!(pick["error_m"].as_f64(), study.error(cell, Accuracy::Position));
        let price = pick["price"].as_f64().unwrap();
        let measured = study.cost(cell, Cost::RealTime).unwrap() * 1e3 / 60.0;
        assert!((price - measured).abs() < 1e-9 * measured, "{price} and {measured}");
        picks.push((part["part"].as_str().unwrap().to_owned(), method, substeps, price));
    }
    let sum: f64 = picks.iter().map(|(.., price)| price).sum();
    assert!((report["total"].as_f64().unwrap() - sum).abs() < 1e-9 * sum);
    picks
}

#[test]
fn each_part_gets_the_cheapest_measured_setting_below_the_error_and_the_file_has_it() {
    let folder = folder();
    let line = "recommend groups.ron --error 1e-2 --quick --seconds 0.5 --format json --apply out/better.ron";
    let report: Value = serde_json::from_str(&sandbox(&folder, line).fine()).unwrap();
    assert_eq!((&report["scene"], &report["unit"]), (&"groups".into(), &"ms".into()));
    let picks = picks(&report);
    let names: Vec<_> = picks.iter().map(|(name, ..)| name.as_str()).collect();
    assert_eq!(names, ["rope", "flag", "free bodies"]);
    for part in report["parts"].as_array().unwrap() {
        let study: Study = serde_json::from_value(part["study"].clone()).unwrap();
        let cheapest = study
            .cells
            .iter()
            .filter(|cell| study.error(cell, Accuracy::Position).is_some_and(|error| error <= 1e-2))
            .filter_map(|cell| study.cost(cell, Cost::RealTime))
            .fold(f64::INFINITY, f64::min);
        assert!((part["pick"]["price"].as_f64().unwrap() - cheapest * 1e3 / 60.0).abs() < 1e-9);
    }
    let dearest = picks.iter().max_by(|a, b| a.3.total_cmp(&b.3)).unwrap();
    assert_eq!(report["sets_the_price"], dearest.0.as_str());

    let path = folder.path().join("out/better.ron");
    let better = load(path.to_str().unwrap()).unwrap();
    for (part, (_, method, substeps, _)) in groups().parts().iter().zip(&picks) {
        for entry in &part.entries {
            let body = better.bodies[entry.bodies.start as usize];
            assert_eq!(body.method.unwrap_or(better.method), *method, "{}", entry.path());
            assert_eq!(body.substeps.unwrap_or(better.substeps), *substeps, "{}", entry.path());
        }
    }
    let free = picks.last().unwrap();
    assert_eq!((better.method, better.substeps), (free.1, free.2));
    assert_eq!(comments(&fs::read_to_string(&path).unwrap()), comments(GROUPS));
    sandbox(&folder, "run out/better.ron --seconds 0.2").fine();

    // That file is somebody's now.
    let words = "there is a file already, and not that of the scene; give --apply another name";
    sandbox(&folder, line).fails(2, words);
}

#[test]
fn a_budget_buys_the_smallest_largest_error() {
    let folder = folder();
    let bought = |more: &str| {
        let line = format!("recommend groups.ron --budget-ms 1e6 --quick --seconds 0.25 {more}");
        sandbox(&folder, &line).fine()
    };
    let report: Value = serde_json::from_str(&bought("--format json")).unwrap();
    assert_eq!(report["next"], Value::Null, "nothing better was measured");
    picks(&report);
    let number = |value: &Value| value.as_f64().unwrap();
    let errors: Vec<_> = report["parts"]
        .as_array()
        .unwrap()
        .iter()
        .map(|part| {
            let study: Study = serde_json::from_value(part["study"].clone()).unwrap();
            let own = number(&part["reference_error_m"]);
            let all = study.cells.iter().filter_map(|cell| study.error(cell, Accuracy::Position));
            (number(&part["pick"]["error_m"]).max(own), all.fold(f64::INFINITY, f64::min).max(own))
        })
        .collect();
    let largest = |of: fn(&(f64, f64)) -> f64| errors.iter().map(of).fold(0.0, f64::max);
    assert_eq!(largest(|(pick, _)| *pick), largest(|(_, best)| *best), "{errors:?}");

    // Onto the scene's own file, as a table.
    let text = bought("--apply groups.ron");
    assert!(text.contains("the price is set by ") && text.contains("\nflag "), "{text}");
    assert_ne!(fs::read_to_string(folder.path().join("groups.ron")).unwrap(), GROUPS);
    sandbox(&folder, "run groups.ron --ticks 3").fine();
}

#[test]
fn what_nothing_measured_can_do_is_said_and_nothing_is_written() {
    let folder = folder();
    for (goal, cure) in
        [("--budget-ms 1e-9", "give a larger budget"), ("--error 1e-30", "give a larger error")]
    {
        let line = format!("recommend groups.ron --quick --seconds 0.1 --apply no.ron {goal}");
        sandbox(&folder, &line).fails(1, cure);
        assert!(!folder.path().join("no.ron").exists());
    }
}

#[test]
fn bad_flags_are_named() {
    command_lines("recommend");
}

/// Explicit Euler and Runge-Kutta 2 may be near enough for a second, and let the spring grow without end.
#[test]
fn what_is_chosen_is_not_refused_as_unstable() {
    let scene = "(version: 1, step_hz: 60, method: runge_kutta_4, bodies: [(name: \"post\", immovable: true),
        (name: \"ball\", position_m: (1.1, 0, 0))],
        springs: [(between: (\"post\", \"ball\"), stiffness_n_m: 300, rest_length_m: 1)])";
    for error in ["0.03", "0.001"] {
        let folder = rigs::folder([("spring.ron", scene)]);
        let line =
            format!("recommend spring.ron --error {error} --seconds 1 --quick --apply chosen.ron");
        sandbox(&folder, &line).ends(0);
        sandbox(&folder, "run chosen.ron --seconds 1 --refuse-unstable").ends(0);
    }
}
