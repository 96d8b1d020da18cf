//! What a scene takes, said before it is taken: memory, and the time of a tick.

use std::fs;
use std::io::Read as _;
use std::process::{Command, Stdio};

use lab::lesson::{RunLimit, run_lesson};
use lab::sweep::{Axis, Measure, Plan, Sweep};
use render::{Film, Image};
use sandbox::Options;
use scene::{Keeps, Scene};
use tempfile::TempDir;

use crate::effects::allocations::most_held;
use crate::rigs::{Dice, Drive, Said, folder, output, program, sandbox, scene_of, wait_for};

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

/// What is estimated over what is taken by a session that keeps all that, until its first tick is over.
fn estimated_by_taken(text: &str, keeps: Keeps) -> f64 {
    let mut estimated = 0;
    let taken = most_held(|| {
        // As it is read from a file.
        let text = text.to_owned();
        let scene = Scene::parse("big", &text).unwrap();
        drop(text);
        estimated = scene.estimated_bytes(keeps);
        let pictures = keeps.pictures.is_some();
        let options = Options { pictures, interpolate: pictures, ..Options::default() };
        let mut drive = Drive::with(scene, options);
        drive.session.tools.forecast_start(&mut drive.session.stage, 0.01);
        if keeps.ledger {
            drive.session.tools.keep_ledger(&drive.session.stage);
        }
        if keeps.black_box {
            drive.session.stage.keep_black_box();
        }
        drive.session.stage.playback_mut().limit_ticks(1);
        assert_eq!(drive.frame(0.01, []).session.stage.sim().ticks(), 1);
        if pictures {
            std::hint::black_box(drive.session.picture());
        }
    });
    estimated as f64 / taken as f64
}

const CLOUD: &str = "clouds: [(count: 150000, half_extents_m: (9, 9, 9))]";

/// Scenes of twenty kinds, each large in another way.
fn kinds() -> Vec<(&'static str, String)> {
    let list = |count: usize, entry: &dyn Fn(usize) -> String| {
        (0..count).map(|i| entry(i) + ", ").collect::<String>()
    };
    let bodies = |count: usize, keys: &str| {
        let keys = keys.to_owned();
        format!(
            "bodies: [{}]",
            list(count, &|i| format!("({})", keys.replace('#', &i.to_string())))
        )
    };
    let options = "name: \"b#\", label: \"label of #\", mass_kg: 2, damping_per_s: 0.1, max_speed_m_s: 50, locked_axes: [x], gravity_off: true, substeps: 2, method: runge_kutta_4, position_m: (#, 0, 0), velocity_m_s: (0, 1, 0), color: (1, 0, 0)";
    let (long, short) = ("n".repeat(90), "l".repeat(60));
    let thousand = format!(
        "bodies: [{}]",
        list(1000, &|i| format!("(name: \"b{i}\", position_m: ({i}, 0, 0))"))
    );
    let springs = list(199_999, &|i| {
        let (a, b) = (i % 1000, (i / 1000 + i % 1000 + 1) % 1000);
        format!("(between: (\"b{a}\", \"b{b}\"), stiffness_n_m: 0.001)")
    });
    let cloth = |rows: u32, more: &str| {
        format!(
            "soft_bodies: [cloth(rows: {rows}, columns: {rows}, along_m: (1, 0, 0), down_m: (0, -1, 0), stiffness_n_m: 0.01{more})]"
        )
    };
    vec![
        ("cloud", "clouds: [(count: 150000, half_extents_m: (9, 9, 9))]".to_owned()),
        ("emitter", "emitters: [(rate_per_s: 30000, life_s: 4, speed_m_s: 1)]".to_owned()),
        ("emitters", format!("emitters: [{}]", list(1000, &|i| format!("(name: \"e{i}\", rate_per_s: 25, life_s: 4, speed_m_s: 1, capacity: 100)")))),
        ("cloth", cloth(300, "")),
        ("stiff cloth", "method: semi_implicit_euler, soft_bodies: [cloth(rows: 300, columns: 300, along_m: (1, 0, 0), down_m: (0, -1, 0), mass_kg: 90000, stiffness_n_m: 5000)]".to_owned()),
        ("cloth in air", format!("drag: (linear_per_s: 0.1, quadratic_per_m: 0.2), wind: (velocity_m_s: (3, 0, 0)), {}", cloth(300, ", shear: true, bend: true"))),
        ("lattice", lattice_entries(50)),
        ("chain", "soft_bodies: [chain(points: 100000, to_m: (1, 0, 0), stiffness_n_m: 0.01)]".to_owned()),
        ("grid", "grids: [(rows: 1500, columns: 700)]".to_owned()),
        ("grids", format!("grids: [{}]", list(2000, &|i| format!("(name: \"g{i}\", rows: 10, columns: 10, origin_m: ({i}, 0, 0))")))),
        ("ring", "rings: [(count: 150000, radius_m: 5)]".to_owned()),
        ("bodies", bodies(100_000, "")),
        ("options", bodies(60_000, options)),
        ("drags", bodies(60_000, "drag_area_m2: 0.1")),
        ("long names", bodies(60_000, &format!("name: \"{long}#\", label: \"{short}\""))),
        ("scenery", bodies(60_000, "scenery: true, shape: cuboid(half_extents_m: (1, 1, 1)), rotation_deg: (0, 10, 0)")),
        ("springs", format!("{thousand}, springs: [{springs}]")),
        ("wells", format!("bodies: [()], wells: [{}]", list(200_000, &|i| format!("(position_m: ({i}, 1, 0), strength_m3_s2: 0.001, softening_m: 1)")))),
        ("owned wells", format!("{thousand}, wells: [{}]", list(20_000, &|i| format!("(position_m: (0, {i}, 5), strength_m3_s2: 0.001, softening_m: 1, bodies: [\"b{}\"])", i % 1000)))),
        ("table", format!("bodies: [(name: \"b\")], thrusts: [(body: \"b\", curve: table([{}]), from_s: 0, until_s: 1e6)]", list(300_000, &|i| format!("({i}, (1, 0, 0))")))),
        ("thrusts", format!("{thousand}, thrusts: [{}]", list(60_000, &|i| format!("(body: \"b{}\", curve: sine(amplitude_n: (1, 0, 0), angular_frequency_rad_s: 1, phase_rad: 0), from_s: 0, until_s: 9)", i % 1000)))),
        ("attraction", "mutual_gravity: (constant_m3_kg_s2: 1e-9, softening_m: 0.1), clouds: [(count: 4000, half_extents_m: (9, 9, 9))]".to_owned()),
        ("comments", format!("bodies: [()], /* {} */", "c".repeat(8_000_000))),
    ].into_iter().map(|(name, entries)| (name, scene(&entries))).collect()
}

fn lattice_entries(cells: u32) -> String {
    format!(
        "soft_bodies: [lattice(cells: ({cells}, {cells}, {cells}), size_m: (1, 1, 1), mass_kg: 1, stiffness_n_m: 0.01)]"
    )
}

/// "At most" is meant, and not by much. The text itself is counted, too: it is there while the scene is read.
#[test]
fn the_estimate_is_at_least_what_is_taken_and_not_much_more() {
    let factors: Vec<_> = kinds()
        .into_iter()
        .map(|(kind, text)| (kind, estimated_by_taken(&text, Keeps::default())))
        .collect();
    for (kind, factor) in &factors {
        assert!((1.0..=1.6).contains(factor), "{kind}: {factor}; all: {factors:?}");
    }
}

#[test]
fn the_estimate_has_what_the_run_keeps() {
    let no = Keeps::default();
    let keeps = [
        Keeps { ledger: true, ..no },
        Keeps { black_box: true, ..no },
        Keeps { pictures: Some(0), ..no },
        Keeps { ledger: true, black_box: true, pictures: Some(0), ..no },
    ];
    let factors = keeps.map(|keeps| estimated_by_taken(&scene(CLOUD), keeps));
    // There is no device here, nor a timeline that is full.
    assert!(factors.iter().all(|factor| (1.0..=3.0).contains(factor)), "{factors:?}");
    assert!(factors[0] <= 1.6, "{factors:?}");
}

#[test]
fn the_estimate_of_a_sweep_has_its_ledgers_and_references() {
    let measures: [&[Measure]; 3] =
        [&[Measure::StateHash], &[Measure::Drift, Measure::LargestDistance], &Measure::ALL];
    let mut factors = Vec::new();
    for (kind, text) in kinds() {
        // References of bodies that springs join take minutes.
        let measures = match kind {
            "cloud" | "emitter" => &measures[..],
            "cloth in air" => &measures[..2],
            _ => continue,
        };
        let scene = scene_of(&text);
        for measures in measures {
            let axes = vec![Axis::parse("step_hz=100,200").unwrap()];
            let plan = Plan { axes, seconds: 0.01, measures: measures.to_vec() };
            let sweep = Sweep::new(&scene, plan).unwrap();
            let taken = most_held(|| drop(std::hint::black_box(sweep.row(0))));
            factors.push((kind, measures.len(), sweep.estimated_bytes()[1] as f64 / taken as f64));
        }
    }
    assert!(factors.iter().all(|(.., factor)| (1.0..=3.0).contains(factor)), "{factors:?}");
}

/// The most resident memory of `sandbox line`, bytes, and what it said.
#[cfg(target_os = "linux")]
fn peak(folder: &TempDir, line: &str) -> (u64, String) {
    let mut run = Command::new(program());
    let run = run.args(line.split(' ')).current_dir(folder).stderr(Stdio::piped());
    let mut run = run.stdout(Stdio::null()).spawn().unwrap();
    let status = format!("/proc/{}/status", run.id());
    let mut most = 0;
    let ended = wait_for("its end", || {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find(|line| line.starts_with("VmHWM:"));
        let kib = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
        most = most.max(kib.unwrap_or(0) * 1024);
        run.try_wait().unwrap()
    });
    let mut said = String::new();
    run.stderr.unwrap().read_to_string(&mut said).unwrap();
    assert_eq!(ended.code(), Some(0), "{said}");
    (most, said)
}

#[test]
#[cfg(target_os = "linux")]
fn a_sweep_stays_within_the_memory_that_is_allowed() {
    let text = scene("gravity: (), clouds: [(count: 50000, half_extents_m: (9, 9, 9))]");
    let folder = folder([("big.ron", text)]);
    let (program_itself, _) = peak(&folder, "list methods");
    let sweep = "sweep big.ron --vary step_hz=100,101,102,103 --seconds 0.05 --threads 4";
    for (measure, gib) in [("survives,drift,largest_speed", 0.35), ("error,drift", 0.5)] {
        let (most, said) = peak(&folder, &format!("{sweep} --measure {measure} --memory {gib}"));
        assert!(said.contains(" of 4 runs side by side fit into the memory"), "{said}");
        let most = most.saturating_sub(program_itself) as f64 / f64::from(1 << 30);
        assert!(most < gib, "{most} GiB of {gib} by {measure}: {said}");
    }
    sandbox(&folder, &format!("{sweep} --measure error,drift --memory 0.12"))
        .fails(2, "big.ron: a run takes about ");
    for command in ["ablate", "effects", "cost", "recommend --error 1"] {
        sandbox(&folder, &format!("{command} big.ron --memory 0.07"))
            .fails(2, "big: 50000 bodies and what the run keeps of them take about ");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn memory_that_runs_out_ends_the_program_in_words() {
    let text = scene("gravity: (), clouds: [(count: 50000, half_extents_m: (9, 9, 9))]");
    let folder = folder([("big.ron", text)]);
    let mut ended = 0;
    for line in
        ["run big.ron --ticks 1 --state s.csv", "sweep big.ron --vary step_hz=9,8 --seconds 0.2"]
    {
        for mib in (40..240).step_by(20) {
            // The allowance tells the program that there is enough.
            let line = format!("{line} --memory 64 --threads 1");
            let line = format!("ulimit -v {}; exec {} {line}", mib * 1024, program().display());
            let said = output(Command::new("bash").args(["-c", &line]).current_dir(&folder));
            // The program itself is not loaded.
            if said.err.contains("shared libraries") || said.code < 0 && said.err.is_empty() {
                continue;
            }
            assert!([0, 2].contains(&said.code), "{mib} MiB: {}", said.all());
            if said.code == 2 {
                assert!(said.err.contains("there is too little memory"), "{}", said.all());
                ended += 1;
            }
            fs::remove_file(folder.path().join("s.csv")).unwrap_or_default();
            assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "{mib} MiB: {}", said.all());
        }
    }
    assert!(ended > 5, "{ended}");
}

#[test]
fn a_run_is_refused_for_what_it_keeps() {
    let text = scene(CLOUD);
    run(&text, "run big.ron --ticks 1 --memory 0.15").fine();
    for keeps in ["--ledger", "--black-box box.zip"] {
        let said = run(&text, &format!("run big.ron --ticks 1 --memory 0.15 {keeps}"));
        said.fails(2, "150000 bodies and what the run keeps of them take about ");
    }
}

#[test]
fn a_small_allowance_is_said_in_a_unit_that_shows_it() {
    let folder = folder([("none", "")]);
    for line in ["cost kepler --memory 1e-9", "run tutorial --ticks 1 --memory 1e-9"] {
        sandbox(&folder, line).fails(2, "and 1 B are allowed");
    }
    sandbox(&folder, "run tutorial --ticks 1 --memory 1e-5").fails(2, "and 10.5 KiB are allowed");
}

#[test]
fn what_does_not_fit_is_refused_by_its_entry_before_it_is_made() {
    let text = lattice(157);
    let bodies = 158_u64.pow(3) + 2;
    let said = run(&text, "run big.ron --ticks 1 --memory 2");
    let all = &said.err;
    assert_eq!(said.code, 2, "{all}");
    let line = format!("big.ron:2:11: soft_bodies[1]: {bodies} bodies and ");
    assert!(
        all.contains(&line) && all.contains("GiB, and 2.0 GiB are allowed; give fewer"),
        "{all}"
    );
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
    let env = env
        .arg("--default-signal=INT")
        .arg(program())
        .args("run big.ron --state out.csv".split(' '));
    let mut run =
        env.current_dir(&folder).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let resident = || {
        let text = fs::read_to_string(format!("/proc/{}/statm", run.id())).unwrap_or_default();
        text.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0)
    };
    // In the midst of making bodies: more than the program alone, in pages of 4 KiB.
    wait_for("bodies that are being made", || (resident() > 50_000).then_some(()));
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    assert_eq!(run.wait().unwrap().code(), Some(130));
    let left: Vec<_> =
        fs::read_dir(&folder).unwrap().map(|file| file.unwrap().file_name()).collect();
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
    said.warns(2, "4000 bodies attract each other: a tick takes about ");
}

#[test]
fn a_film_takes_no_more_memory_for_more_pictures() {
    let size_px = [96, 64];
    let taken = |pictures: u32| {
        let mut dice = Dice(7);
        // Nothing of it can be compressed, and all of it changes.
        let mut noise =
            || Image { size_px, rgba: (0..96 * 64 * 4).map(|_| dice.bits() as u8 | 1).collect() };
        let spool = tempfile::tempfile().unwrap();
        let out = tempfile::tempfile().unwrap();
        most_held(|| {
            let mut film = Film::new(spool);
            (0..pictures).for_each(|picture| film.add(noise(), f64::from(picture)).unwrap());
            film.finish(out, &[]).unwrap();
        })
    };
    let [few, many] = [10, 200].map(taken);
    assert!(many <= few + 1024, "{few} and {many} bytes");
    // Beside them, what the compressor takes for itself.
    assert!(many <= Film::bytes(size_px) + (2 << 20), "{many} bytes");
}

#[test]
fn the_runs_of_a_lesson_are_bounded_by_all_that_they_compute() {
    let lesson = |runs: &str| {
        format!(
            r#"(version: 1, title: "T", about: "A.", page: "P", scene: "oscillator",
                measure: (x: position("ball", x)), runs: [{runs}],
                steps: [(task: "Push it.", done: "x > x_before + 0.5", solution: [push("ball", (5000, 0, 0))],
                         wrong: [[press("G")], [push("ball", (-50, 0, 0))]], then: "At {{x}} m.", holds: "x > 3")])"#
        )
    };
    let stars = scene(
        "mutual_gravity: (constant_m3_kg_s2: 1e-9, softening_m: 0.1), clouds: [(count: 4000, half_extents_m: (9, 9, 9))]",
    );
    // Bodies that attract each other; a reference beside the run; and any number of runs.
    let runs = [
        r#"(scene: "stars.ron", seconds: 60, measure: (e: energy))"#.to_owned(),
        r#"(scene: "flag", seconds: 120, measure: (e: error))"#.to_owned(),
        (0..4000)
            .map(|i| format!(r#"(scene: "thousand", seconds: 20, measure: (e{i}: energy)), "#))
            .collect(),
    ];
    for runs in runs {
        let text = lesson(&runs);
        let folder = folder([("my.ron", text.as_str()), ("stars.ron", stars.as_str())]);
        let lesson = scene::lesson::load(folder.path().join("my.ron").to_str().unwrap()).unwrap();
        let fault = run_lesson(&lesson, 1.0, RunLimit { seconds: 0.02, ..RunLimit::USUAL })
            .unwrap_err()
            .to_string();
        assert!(fault.contains("my.ron: its runs take more than 0.02 s: runs["), "{fault}");
        assert!(fault.contains(" s; give fewer or shorter runs"), "{fault}");
    }
}
