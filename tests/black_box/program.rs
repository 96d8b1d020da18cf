//! `run --black-box` and `replay`.

use std::fs;
use std::path::Path;

use history::Bundle;
use serde_json::Value;
use tempfile::TempDir;

use crate::rigs::{self, Said, command_lines, json, sandbox};

pub const CLOTH: &str = "(version: 1, name: \"sheet\", gravity: (), soft_bodies: [
    cloth(name: \"cloth\", rows: 5, columns: 5, along_m: (2, 0, 0), down_m: (0, -2, 0), stiffness_n_m: 50,
          damping_n_s_m: 0.2, pinned: [top_left, top_right])])";

/// w h is 12.6: a semi-implicit step grows by a factor of 157.
pub const STIFF: &str = "(version: 1, step_hz: 100, bodies: [
    (name: \"wall\", immovable: true), (name: \"ball\", position_m: (1.1, 0, 0))],
    springs: [(between: (\"wall\", \"ball\"), stiffness_n_m: 1.6e6, rest_length_m: 1)])";

pub fn folder() -> TempDir {
    let script =
        "[(at_tick: 10, do: press(\"G\")), (at_tick: 70, do: push(\"cloth.r2.c2\", (nan, 0, 0)))]";
    rigs::folder([("sheet.ron", CLOTH), ("stiff.ron", STIFF), ("nan.script", script)])
}

pub fn bundle(folder: &Path, name: &str) -> Bundle {
    Bundle::read(&fs::read(folder.join(name)).unwrap()).unwrap()
}

#[test]
fn black_boxes_are_written_replayed_and_refused_in_words() {
    command_lines("black_box");
}

#[test]
fn a_nan_push_in_the_middle_of_a_cloth_is_repeated_by_its_bundle() {
    let folder = folder();
    let line = "run sheet.ron --script nan.script --seconds 2 --black-box box.zip";
    let said = sandbox(&folder, line);
    said.warns(3, "cloth.r2.c2");
    said.warns(3, "is the last good one; box.zip holds");
    let saved = bundle(folder.path(), "box.zip");
    let fault = saved.manifest.fault.clone().unwrap();
    assert_eq!(fault.body.as_deref(), Some("cloth.r2.c2"));
    assert_eq!((saved.manifest.end_tick, saved.manifest.scene.as_str()), (fault.tick, "sheet"));
    assert_eq!(saved.scene, CLOTH);
    assert!(saved.picture.is_some_and(|picture| picture.starts_with(b"\x89PNG")));
    let out = sandbox(&folder, "replay box.zip").fine();
    let hash = &saved.manifest.end_state_hash;
    assert!(
        out.contains(&format!("hash {hash}; the same fault, cloth.r2.c2, tick {}", fault.tick)),
        "{out}"
    );
}

/// Written by the program of 2026-11-23: position Verlet, a spring, bodies with methods and a rate of their own, an
/// emitter; a body is removed and drag switched off before its snapshot at tick 160.
const FORMAT_1: &[u8] = include_bytes!("format_1.zip");

#[test]
fn a_bundle_of_an_earlier_program_is_repeated() {
    let folder = folder();
    fs::write(folder.path().join("box.zip"), FORMAT_1).unwrap();
    let out = sandbox(&folder, "replay box.zip").fine();
    let fault = "the same fault, dust, tick 1401: Force was not finite when integrate looked";
    assert!(out.contains(&format!("the same state, hash 5bc93ef20a8dfc4c; {fault}")), "{out}");
}

#[test]
fn energy_that_grows_for_longer_than_a_minute_is_repeated_by_its_bundle() {
    let folder = folder();
    // Explicit Euler adds 10 % a second: it takes 73 s to a thousand times as much.
    let slow = STIFF
        .replace("step_hz: 100", "step_hz: 60, method: explicit_euler")
        .replace("1.6e6", "5.73");
    fs::write(folder.path().join("slow.ron"), slow).unwrap();
    let line = "run slow.ron --seconds 120 --black-box box.zip --summary summary.json";
    let err = sandbox(&folder, line).ends(1).err;
    let black_box = &json(folder.path().join("summary.json"))["black_box"];
    let (oldest, began) =
        (black_box["tick"].as_u64().unwrap(), black_box["fault"]["tick"].as_u64().unwrap());
    assert!(began < 60 * 10 && oldest > 60 * 10, "{black_box}");
    assert!(err.contains(&format!("tick {oldest} is the oldest that is kept")), "{err}");
    let out = sandbox(&folder, "replay box.zip").fine();
    assert!(
        out.contains(&format!("the same fault, ball, tick {began}: the method created")),
        "{out}"
    );
}

#[test]
fn a_quarantine_wins_over_an_energy_jump_of_the_same_tick() {
    let folder = folder();
    let scene = STIFF.replace("bodies: [", "bodies: [(name: \"free\", position_m: (0, 9, 0)), ");
    fs::write(folder.path().join("two.ron"), scene).unwrap();
    let line = "run two.ron --fps 100 --seconds 1 --black-box box.zip --summary summary.json";
    sandbox(&folder, line).ends(1);
    let found = json(folder.path().join("summary.json"))["ticks"].as_u64().unwrap();
    let script = format!("[(at_tick: {}, do: push(\"free\", (nan, 0, 0)))]", found - 1);
    fs::write(folder.path().join("nan.script"), script).unwrap();
    sandbox(&folder, &format!("{line} --script nan.script")).ends(3);
    let fault = &json(folder.path().join("summary.json"))["black_box"]["fault"];
    assert_eq!((&fault["body"], &fault["tick"]), (&"free".into(), &found.into()));
}

#[test]
#[cfg(target_os = "linux")]
fn a_fault_is_told_and_decides_the_exit_code_where_its_bundle_cannot_be_written() {
    let folder = folder();
    std::os::unix::fs::symlink("/dev/full", folder.path().join("link")).unwrap();
    let full = "is the last good one; cannot write link: the disk is full; make room, or give another path\n";
    for (line, expected, tick) in [("sheet.ron --script nan.script", 3, 70), ("stiff.ron", 1, 0)] {
        let line = format!("run {line} --seconds 2 --black-box link --summary summary.json");
        let err = sandbox(&folder, &line).ends(expected).err;
        assert!(err.ends_with(&format!("; tick {tick} {full}")), "{err}");
        let summary = json(folder.path().join("summary.json"));
        let black_box = &summary["black_box"];
        assert_eq!((&black_box["path"], &black_box["tick"]), (&Value::Null, &tick.into()));
        assert_eq!(black_box["fault"]["tick"], tick + 1);
    }
}

#[test]
fn a_run_that_went_back_from_a_fault_and_ends_there_has_its_exit_code() {
    let folder = folder();
    let script =
        "[(at_tick: 10, do: press(\"G\")), (at_tick: 20, do: press(\",\")), (at_frame: 30, do: press(\"P\")),
        (at_tick: 70, do: push(\"cloth.r2.c2\", (nan, 0, 0)))]";
    fs::write(folder.path().join("back.script"), script).unwrap();
    let line = "run sheet.ron --script back.script --seconds 2 --summary summary.json";
    sandbox(&folder, line).warns(3, "cloth.r2.c2 quarantined in tick 71: ");
    let summary = json(folder.path().join("summary.json"));
    assert_eq!(
        (&summary["ticks"], summary["quarantined"].as_array().unwrap().len()),
        (&70.into(), 1)
    );
    assert_eq!(summary["quarantined"][0]["tick"], 71);
}

#[test]
fn a_bundle_beside_pictures_has_one() {
    let folder = folder();
    fs::write(folder.path().join("save.script"), "[(at_frame: 20, do: press(\"save_bundle\"))]")
        .unwrap();
    let line = "run sheet.ron --script save.script --ticks 60 --frames out --frame-every 1000 --size 320x200";
    sandbox(&folder, line).ends(0);
    let saved = bundle(folder.path(), "out/bundle_000020.zip");
    assert!(saved.picture.is_some_and(|picture| picture.starts_with(b"\x89PNG")));
}

#[test]
fn a_script_goes_back_and_saves_as_a_person_does() {
    let folder = folder();
    let script = "[(at_tick: 40, do: press(\",\")), (at_frame: 30, do: press(\"save_bundle\")),
        (at_frame: 31, do: press(\"P\"))]";
    fs::write(folder.path().join("back.script"), script).unwrap();
    let line = "run sheet.ron --script back.script --ticks 70 --summary back.json";
    sandbox(&folder, line).ends(0);
    let written = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    let name =
        written.map(|name| name.into_string().unwrap()).find(|name| name.starts_with("bundle_"));
    let out = sandbox(&folder, &format!("replay {}", name.unwrap())).fine();
    assert!(out.contains("no fault in either run"), "{out}");
    sandbox(&folder, "run sheet.ron --ticks 70 --summary straight.json");
    let hash = |file: &str| json(folder.path().join(file))["state_hash"].clone();
    assert_eq!(hash("back.json"), hash("straight.json"));
}

#[test]
fn what_differs_is_named_and_what_is_damaged_is_refused() {
    let folder = folder();
    sandbox(&folder, "run sheet.ron --script nan.script --seconds 2 --black-box box.zip");
    let write = |bundle: &Bundle| {
        fs::write(folder.path().join("other.zip"), bundle.write().unwrap()).unwrap();
    };

    let mut other = bundle(folder.path(), "box.zip");
    other.manifest.keyframes[1].state_hash = "0".repeat(16);
    other.manifest.program = "sandbox 0.0.1".to_owned();
    write(&other);
    let tick = other.manifest.keyframes[1].tick;
    let version = "it was written by sandbox 0.0.1, this is sandbox 0.1.0";
    let words = format!("sandbox: other.zip: the state differs from tick {tick} on; {version}\n");
    sandbox(&folder, "replay other.zip").says(1, &words);

    let mut other = bundle(folder.path(), "box.zip");
    other.events.clear();
    write(&other);
    sandbox(&folder, "replay other.zip").warns(1, "no fault instead of cloth.r2.c2, tick");

    let mut other = bundle(folder.path(), "box.zip");
    other.scene = STIFF.to_owned();
    write(&other);
    sandbox(&folder, "replay other.zip")
        .warns(2, "the snapshot in the bundle does not match its scene");

    let good = fs::read(folder.path().join("box.zip")).unwrap();
    for bad in
        [&good[..good.len() / 2], &[&good[..], b"x"].concat(), b"", b"PK\x03\x04", b"(version: 1)"]
    {
        fs::write(folder.path().join("bad.zip"), bad).unwrap();
        let Said { out, err, .. } = sandbox(&folder, "replay bad.zip").ends(2);
        assert_eq!((out.as_str(), err.lines().count()), ("", 1), "{err}");
    }
}
