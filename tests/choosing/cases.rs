//! Scenes whose ticks need very different numbers of substeps, each tick against DOP853.

use glam::DVec3;
use history::Simulation;
use motion::{AutoSubsteps, Evaluations, Method, PhysicsBody, Transform};
use sandbox::input::Input;
use scene::{ChangeAction, Scene, Substepping};

use crate::cost::references::{System, advance, flat, vectors};
use crate::rigs::{Drive, folder, sandbox, scene_of};

/// Burrau's problem: bodies of 3, 4 and 5 kg at rest in the corners of a triangle of those sides, opposite to each.
const BURRAU: &str = "mutual_gravity: (constant_m3_kg_s2: 1), bodies: [
    (mass_kg: 3, position_m: (1, 3, 0)), (mass_kg: 4, position_m: (-2, -1, 0)), (mass_kg: 5, position_m: (1, -1, 0))]";

/// A moon of little weight round a planet round a sun.
const MOON: &str = "mutual_gravity: (constant_m3_kg_s2: 1), bodies: [
    (mass_kg: 1), (mass_kg: 1e-3, position_m: (1, 0, 0), velocity_m_s: (0, 1, 0)),
    (mass_kg: 1e-6, position_m: (1.016, 0, 0), velocity_m_s: (0, 1.15, 0))]";

/// A probe that passes a planet closely.
const SLINGSHOT: &str = "mutual_gravity: (constant_m3_kg_s2: 1), bodies: [
    (mass_kg: 1), (mass_kg: 0.01, position_m: (0, 1, 0), velocity_m_s: (-1, 0, 0)),
    (mass_kg: 1e-9, position_m: (-1.45, 0.885, 0), velocity_m_s: (1.0, 0.55, 0))]";

/// A rope that is thrown over and cracks.
const WHIP: &str =
    "gravity: (), soft_bodies: [chain(points: 8, from_m: (0, 0, 0), to_m: (2, 0, 0), mass_kg: 0.4,
    stiffness_n_m: 2000, pinned: [first], velocity_m_s: (0, 9, 0))]";

/// A jump from a bridge, on a cord of 10 m.
const BUNGEE: &str = "gravity: (), bodies: [(name: \"bridge\", immovable: true), (name: \"jumper\", mass_kg: 75, position_m: (1, 0, 0))],
    springs: [(between: (\"bridge\", \"jumper\"), stiffness_n_m: 150, rest_length_m: 10, pull_only: true)]";

struct Found {
    /// Largest error of a tick, m.
    worst: f64,
    /// Evaluations of one body.
    evaluations: u64,
    /// Most substeps of a tick.
    largest: u32,
}

fn states(run: &Simulation) -> Vec<(DVec3, DVec3)> {
    let state = |body| {
        let x = run.world.get::<Transform>(body).unwrap().position;
        (x, run.world.get::<PhysicsBody>(body).unwrap().velocity)
    };
    run.bodies.iter().map(|body| state(*body)).collect()
}

/// The substeps of the last tick.
fn choice(run: &Simulation) -> u32 {
    let mut choices = run.world.try_query::<&AutoSubsteps>().unwrap();
    choices.iter(&run.world).map(|choice| choice.last).max().expect("a body chooses")
}

fn run(scene: &Scene, ticks: u64) -> Found {
    let system = System::of(scene);
    let mut run = Simulation::new(scene.clone());
    let mut found = Found { worst: 0.0, evaluations: 0, largest: 0 };
    let tick_s = 1.0 / scene.step_hz;
    for _ in 0..ticks {
        let before = states(&run);
        run.tick();
        let after = states(&run);
        let truth = advance(&system, 0.0, tick_s, flat(&before));
        let errors = after.iter().zip(vectors(&truth)).map(|((x, _), truth)| x.distance(truth));
        found.worst = errors.fold(found.worst, f64::max);
        found.largest = found.largest.max(choice(&run));
    }
    let movable = scene.bodies.iter().filter(|body| body.is_movable()).count() as u64;
    found.evaluations = run.world.resource::<Evaluations>().accelerations() / movable;
    if let Some(w) = Substepping::excess(&run.world) {
        println!("   {w}");
    }
    found
}

fn scene(method: Method, hz: u32, error: f64, rest: &str) -> Scene {
    let method = method.name();
    scene_of(&format!(
        "(version: 1, step_hz: {hz}, method: {method}, substeps: auto(error_m: {error:?}, most: 65536), {rest})"
    ))
}

#[test]
fn every_tick_is_within_the_error_of_dop853_and_close_passages_cost_a_tenth() {
    // The largest part of the evaluations that the most substeps would take in every tick.
    for (name, rest, hz, ticks, share) in [
        ("three bodies", BURRAU, 100, 1500, 0.1),
        ("moon", MOON, 40, 200, 0.6),
        ("slingshot", SLINGSHOT, 40, 120, 1.1),
        ("whip", WHIP, 60, 60, 1.1),
        ("bungee", BUNGEE, 60, 300, 1.1),
    ] {
        for method in [Method::VelocityVerlet, Method::RungeKutta4, Method::Yoshida4] {
            for error in [1e-4, 1e-6] {
                let Found { worst, evaluations, largest } =
                    run(&scene(method, hz, error, rest), ticks);
                let steps = f64::from(largest) * ticks as f64;
                let most = steps * f64::from(method.claims().evaluations_with_velocity_laws);
                let what =
                    format!("{name}, {method:?}, {error:e}: {worst:e}, {evaluations} of {most}");
                assert!(worst <= error, "{what}");
                assert!(evaluations as f64 <= share * most + 10.0, "{what}");
            }
        }
    }
}

#[test]
fn the_lightest_of_three_bodies_leaves_the_binary_of_the_pythagorean_problem() {
    let scene = scene(Method::Yoshida4, 960, 1e-12, BURRAU);
    let system = System::of(&scene);
    let start: Vec<_> = scene.bodies.iter().map(|body| (body.position, body.velocity)).collect();
    let mut run = Simulation::new(scene);
    let mut truth = flat(&start);
    for tenth in (0..600).map(f64::from) {
        truth = advance(&system, 0.1 * tenth, 0.1 * (tenth + 1.0), truth);
        run.run(96);
    }
    assert_eq!(Substepping::excess(&run.world), None);
    // Semi-major axis and eccentricity of the pair, and the energy of the lightest about it, per mass.
    let elements = |states: &[(DVec3, DVec3)]| {
        let relative = |a: usize, b: usize| (states[b].0 - states[a].0, states[b].1 - states[a].1);
        let (r, v) = relative(1, 2);
        let a = -9.0 / (v.length_squared() - 2.0 * 9.0 / r.length());
        let e = (1.0 - r.cross(v).length_squared() / (9.0 * a)).sqrt();
        let [(r1, v1), (r2, v2)] = [relative(1, 0), relative(2, 0)];
        let (r, v) = ((r1 * 4.0 + r2 * 5.0) / 9.0, (v1 * 4.0 + v2 * 5.0) / 9.0);
        [a, e, 0.5 * v.length_squared() - 12.0 / r.length()]
    };
    let (x, v) = truth.split_at(truth.len() / 2);
    let truth: Vec<_> = vectors(x).into_iter().zip(vectors(v)).collect();
    let (ours, theirs) = (elements(&states(&run)), elements(&truth));
    // So long after the closest passage DOP853 knows no more digits of it.
    for (i, bound) in [0.05, 2e-3, 0.5].into_iter().enumerate() {
        assert!((ours[i] - theirs[i]).abs() < bound, "{ours:?} {theirs:?}");
    }
    let [a, e, energy] = ours;
    assert!((0.5..0.6).contains(&a) && (0.98..0.99).contains(&e) && energy > 1.0, "{ours:?}");
}

#[test]
fn an_engine_that_starts_has_its_closed_form() {
    let rest = "bodies: [(name: \"ship\", mass_kg: 2)], thrusts: [(body: \"ship\", from_s: 0.505,
        curve: sine(amplitude_n: (10, 0, 0), angular_frequency_rad_s: 150))]";
    for method in [Method::VelocityVerlet, Method::RungeKutta4, Method::Yoshida4] {
        let mut run = Simulation::new(scene(method, 30, 1e-6, rest));
        run.run(15);
        assert_eq!((choice(&run), states(&run)[0].0), (2, DVec3::ZERO));
        run.run(30);
        assert!(choice(&run) > 2 && Substepping::excess(&run.world).is_none(), "{method:?}");
        let (w, from, to) = (150.0_f64, 0.505, 1.5);
        let [(sin, cos), (later, _)] = [from, to].map(|t| (w * t).sin_cos());
        let expected = 10.0 / 2.0 / w * (cos * (to - from) - (later - sin) / w);
        let found = states(&run)[0].0.x;
        // 30 ticks add up, each with an error of velocity for the rest of the second.
        assert!((found - expected).abs() < 1e-3, "{method:?}: {found} {expected}");
    }
}

const COMET: &str = "method: velocity_verlet, wells: [(strength_m3_s2: 49.34802200544679)],
    bodies: [(name: \"comet\", position_m: (9.85, 0, 0), velocity_m_s: (0, 0.3876836, 0))]";

#[test]
fn a_scene_a_body_or_a_group_chooses_where_its_file_says_so() {
    let bodies = "bodies: [(name: \"a\"), (name: \"b\", substeps: 3), (name: \"post\", immovable: true), (name: \"lift\", immovable: true)],
        moves: [(body: \"lift\", curve: polynomial([(0, 0, 0), (1, 0, 0)]))],
        emitters: [(rate_per_s: 1, life_s: 2, speed_m_s: 1)]";
    let rope = |substeps: &str| {
        format!(
            "soft_bodies: [chain(name: \"rope\", points: 3, to_m: (1, 0, 0), stiffness_n_m: 9, pinned: [first]{substeps})]"
        )
    };
    let choosing = |keys: &str| {
        let scene = scene_of(&format!("(version: 1, {keys})"));
        let run = Simulation::new(scene.clone());
        let chooses = |id: &u32| {
            run.world.get::<AutoSubsteps>(run.bodies[*id as usize]).map(|choice| choice.error)
        };
        let ids = (0..scene.bodies.len() as u32).filter(|id| chooses(id).is_some());
        let names =
            ids.map(|id| format!("{} {:?}", scene.names.get(id).unwrap(), chooses(&id).unwrap()));
        (names.collect::<Vec<_>>(), run.substeps())
    };
    let all = format!("substeps: auto(error_m: 1e-3), {bodies}, {}", rope(""));
    let expected = ["a 0.001", "rope.1 0.001", "rope.2 0.001"].map(str::to_owned).to_vec();
    assert_eq!(choosing(&all), (expected, Substepping::auto(1e-3)));
    let own =
        format!("substeps: 5, {bodies}, {}", rope(", substeps: auto(error_m: 1e-4, least: 4)"));
    let expected = ["rope.1 0.0001", "rope.2 0.0001"].map(str::to_owned).to_vec();
    assert_eq!(choosing(&own), (expected, 5.into()));
    for wrong in [
        "auto(error_m: 0)",
        "auto(error_m: 1e-3, least: 1)",
        "auto(error_m: 1e-3, most: 1000)",
        "auto(error_m: 1e-3, least: 64, most: 32)",
        "auto(eror_m: 1e-3)",
        "auto()",
        "automatic(error_m: 1)",
        "\"auto\"",
    ] {
        let text = format!("(version: 1, substeps: {wrong}, bodies: [()])");
        let error = Scene::parse("t", &text).unwrap_err().to_string();
        assert!(error.contains("substeps"), "{wrong}: {error}");
    }
}

#[test]
fn substeps_that_are_chosen_come_and_go_and_come_back_in_a_seek() {
    let mut drive = Drive::of(scene_of(&format!("(version: 1, step_hz: 120, {COMET})")));
    drive.session.stage.keep_timeline();
    let mut hashes = Vec::new();
    for substeps in [Substepping::auto(1e-5), 3.into(), Substepping::auto(1e-4)] {
        drive.give([Input::Change(ChangeAction::SetSubsteps(substeps))]).ticks(100);
        let sim = drive.session.stage.sim();
        assert_eq!((sim.substeps(), sim.scene.substeps), (substeps, substeps));
        assert_eq!(
            sim.world.get::<AutoSubsteps>(sim.bodies[0]).is_some(),
            substeps.fixed().is_none()
        );
        hashes.push((sim.ticks(), sim.hash(), substeps));
    }
    for (ticks, hash, substeps) in hashes.into_iter().rev() {
        drive.session.seek(ticks);
        let sim = drive.session.stage.sim();
        assert_eq!((sim.hash(), sim.substeps()), (hash, substeps), "tick {ticks}");
    }
}

#[test]
fn commands_take_substeps_that_are_chosen() {
    let file = format!("(version: 1, step_hz: 120, {COMET})");
    let folder = folder([
        ("comet.ron", file.as_str()),
        ("change.ron", "[(at_s: 1, do: set_substeps(auto(error_m: 1e-5)))]"),
    ]);
    let hash = |line: &str| {
        let line = format!("run comet.ron --seconds 6 {line} --summary s.json");
        sandbox(&folder, &line).fine();
        let summary = std::fs::read(folder.path().join("s.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
        summary["state_hash"].as_str().unwrap().to_owned()
    };
    let hashes = ["", "--substeps auto(error_m:1e-5)", "--script change.ron"].map(hash);
    assert!(hashes[0] != hashes[1] && hashes[1] != hashes[2] && hashes[2] != hashes[0]);
    sandbox(&folder, "run comet.ron --seconds 6 --substeps auto(error_m:1e-9,most:4)")
        .warns(0, "ticks is larger than asked for");

    let sweep = "sweep comet.ron --seconds 10 --vary substeps=2,auto(error_m:1e-5) --measure error,evaluations --out rows";
    sandbox(&folder, sweep).fine();
    let rows = std::fs::read_to_string(folder.path().join("rows/runs.csv")).unwrap();
    let number = |row: usize, key: &str| {
        let [head, row] = [0, row].map(|line| rows.lines().nth(line).unwrap());
        let at = head.split(',').position(|name| name == key).unwrap();
        row.rsplit(',').nth(head.split(',').count() - 1 - at).unwrap().parse::<f64>().unwrap()
    };
    assert!(number(1, "error_m") > 0.5 && number(2, "error_m") < 5e-4, "{rows}");
    assert!(number(2, "evaluations_per_body") < 2.0 * number(1, "evaluations_per_body"), "{rows}");
}

#[test]
fn a_forecast_names_chosen_substeps_where_they_are_fewer_than_half_of_the_fixed_ones() {
    let file = |substeps: &str| {
        format!(
            "(version: 1, step_hz: 60, method: runge_kutta_4, {substeps} wells: [(strength_m3_s2: 1233.7)],
            bodies: [(position_m: (9.8, 0, 0), velocity_m_s: (0, 2.232, 0))])"
        )
    };
    let files = [("one.ron", file("")), ("chosen.ron", file("substeps: auto(error_m: 1e-3),"))];
    let folder = folder(files.each_ref().map(|(name, text)| (*name, text.as_str())));
    let forecast = |scene: &str| sandbox(&folder, &format!("forecast {scene}")).fine();
    let one = forecast("one.ron");
    assert!(one.contains("substeps, or substeps chosen for 0.001 m"), "{one}");
    let chosen = forecast("chosen.ron");
    assert!(chosen.contains("holds") && !chosen.contains("unstable"), "{chosen}");
}
