//! What a scene takes, said before it is taken: memory, and the time of a tick.

use std::fs;
use std::process::{Command, Stdio};

use sandbox::Options;
use scene::Scene;

use crate::drive::Drive;
use crate::effects::allocations::most_held;
use crate::harness::{Said, folder, output, program, sandbox, scene_of, wait_for};

fn scene(entries: &str) -> String {
    format!("(version: 1, step_hz: 100, {entries})")
}

fn lattice(cells: u32) -> String {
    scene(&format!(
        "soft_bodies: [chain(points: 2, to_m: (1, 0, 0), stiffness_n_m: 0.01),
          lattice(cells: ({cells}, {cells}, {cells}), size_m: (1, 1, 1), mass_kg: 1, stiffness_n_m: 0.01)]"
    ))
}

/// Runs it in a folder with `big.ron`.
fn run(text: &str, line: &str) -> Said {
    let folder = folder([("big.ron", text)]);
    sandbox(&folder, line)
}

#[test]
fn the_estimate_is_what_is_taken_within_a_factor() {
    let cloud = "clouds: [(count: 150000, half_extents_m: (9, 9, 9))]";
    let emitter = "emitters: [(rate_per_s: 30000, life_s: 4, speed_m_s: 1)]";
    let cloth = "soft_bodies: [cloth(rows: 300, columns: 300, along_m: (1, 0, 0), down_m: (0, -1, 0), stiffness_n_m: 0.01)]";
    let factors = [scene(cloud), scene(emitter), scene(cloth), lattice(50)].map(|text| {
        let mut estimated = 0;
        let taken = most_held(|| {
            let scene = Scene::parse("big", &text).unwrap();
            estimated = scene.estimated_bytes();
            let options =
                Options { pictures: false, interpolate: false, threads: Some(1), ..Options::default() };
            let mut drive = Drive::with(scene, options);
            drive.session.forecast_start(0.01);
            drive.session.limit_ticks(1);
            assert_eq!(drive.frame(0.01, []).session.ticks(), 1);
        });
        estimated as f64 / taken as f64
    });
    assert!(factors.iter().all(|factor| (1.0 / 1.5..=1.5).contains(factor)), "{factors:?}");
}

#[test]
fn what_does_not_fit_is_refused_by_its_entry_before_it_is_made() {
    let text = lattice(157);
    let bodies = 158_u64.pow(3) + 2;
    let said = run(&text, "run big.ron --ticks 1 --memory 2");
    let all = &said.err;
    assert_eq!(said.code, 2, "{all}");
    let line = format!("big.ron:2:11: soft_bodies[1]: {bodies} bodies and ");
    assert!(all.contains(&line) && all.contains("GiB, and 2.0 GiB are allowed; give fewer"), "{all}");
    assert_eq!(all.lines().count(), 1, "{all}");
    run(&lattice(4), "run big.ron --ticks 1 --memory 0.1").fine();
    run(&lattice(4), "plan big.ron --memory 0.00001").warns(2, "soft_bodies[1]");
}

#[test]
#[cfg(target_os = "linux")]
fn an_address_space_that_is_too_small_is_refused_and_not_run_into() {
    let folder = folder([("big.ron", lattice(157))]);
    let line = format!("ulimit -v 4000000; exec {} run big.ron --ticks 1", program().display());
    let said = output(Command::new("bash").args(["-c", &line]).current_dir(&folder));
    said.warns(2, "GiB are free; give fewer");
}

#[test]
#[cfg(target_os = "linux")]
fn loading_can_be_interrupted() {
    let folder = folder([("big.ron", lattice(60))]);
    let mut env = Command::new("env");
    let env = env.arg("--default-signal=INT").arg(program()).args("run big.ron --state out.csv".split(' '));
    let mut run = env.current_dir(&folder).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let resident = || {
        let text = fs::read_to_string(format!("/proc/{}/statm", run.id())).unwrap_or_default();
        text.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0)
    };
    // In the midst of making bodies: more than the program alone, in pages of 4 KiB.
    wait_for("bodies that are being made", || (resident() > 50_000).then_some(()));
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    assert_eq!(run.wait().unwrap().code(), Some(130));
    let left: Vec<_> = fs::read_dir(&folder).unwrap().map(|file| file.unwrap().file_name()).collect();
    assert_eq!(left, ["big.ron"]);
}

#[test]
fn a_long_tick_is_told_before_it_is_taken() {
    let stars = |count: u32| {
        scene(&format!(
            "mutual_gravity: (constant_m3_kg_s2: 1e-9), clouds: [(count: {count}, half_extents_m: (9, 9, 9))]"
        ))
    };
    let sampled = lab::attraction_tick(&scene_of(&stars(20_000))).unwrap();
    assert!(sampled.bodies == 20_000 && sampled.seconds > 0.0 && sampled.seconds.is_finite());
    assert_eq!(lab::attraction_tick(&scene_of(&stars(2_000))), None);
    // Refused after that was told: the run itself is not waited for.
    let said = run(&stars(4_000), "run big.ron --ticks 100000000 --state big.ron/no.csv");
    said.warns(2, "4000 bodies attract each other: a tick takes some ");
}
