//! `replay --out`, the summary of a black box, and bundles where scenes are meant.

use std::fs;

use serde_json::{Value, json};

use super::program::{CLOTH, bundle, folder};
use crate::rigs::{Said, json, sandbox};

const FAILING: &str =
    "run sheet.ron --script nan.script --seconds 2 --black-box box.zip --summary s.json";

#[test]
fn a_replay_writes_what_a_person_wants_to_look_at() {
    let folder = folder();
    sandbox(&folder, &format!("{FAILING} --state then.csv")).ends(3);
    sandbox(&folder, "replay box.zip --out looked/at").says(0, "made the folder looked/at\n");
    let saved = bundle(folder.path(), "box.zip");
    let at = folder.path().join("looked/at");
    let mut names: Vec<_> =
        fs::read_dir(&at).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["picture.png", "scene.ron", "state.csv", "summary.json"]);
    assert_eq!(fs::read_to_string(at.join("scene.ron")).unwrap(), CLOTH);
    assert_eq!(Some(fs::read(at.join("picture.png")).unwrap()), saved.picture);

    let fault = saved.manifest.fault.clone().unwrap();
    let fault = json!({ "tick": fault.tick, "body": "cloth.r2.c2", "what": fault.what });
    let (hash, tick) = (&saved.manifest.end_state_hash, saved.manifest.end_tick);
    let program = &saved.manifest.program;
    assert_eq!(
        json(at.join("summary.json")),
        json!({
            "bundle": "box.zip", "scene": "sheet", "same": true, "first_different_tick": null,
            "snapshot_tick": 0, "end_tick": tick, "state_hash": { "then": hash, "now": hash },
            "fault": { "then": fault, "now": fault }, "program": { "then": program, "now": program },
            "picture": "picture.png",
        })
    );
    // The last tick of the run that was stopped.
    let (then, now) = (
        fs::read_to_string(folder.path().join("then.csv")).unwrap(),
        fs::read_to_string(at.join("state.csv")).unwrap(),
    );
    let rows: Vec<_> = now.lines().skip(1).collect();
    assert_eq!((now.lines().next(), rows.len()), (then.lines().next(), 25));
    assert!(rows.iter().all(|row| row.starts_with(&format!("{tick},"))));
    assert!(then.ends_with(&(rows.join("\n") + "\n")), "{now}");
}

#[test]
fn a_replay_that_differs_is_written_down_and_ends_with_1() {
    let folder = folder();
    sandbox(&folder, FAILING);
    let mut other = bundle(folder.path(), "box.zip");
    (other.picture, other.manifest.fault) = (None, None);
    other.manifest.end_state_hash = "0".repeat(16);
    fs::write(folder.path().join("other.zip"), other.write().unwrap()).unwrap();
    let tick = other.manifest.end_tick;
    let words = format!("at the end, tick {tick}; cloth.r2.c2, tick {tick}");
    sandbox(&folder, "replay other.zip --out out").warns(1, &words);
    let summary = json(folder.path().join("out/summary.json"));
    assert_eq!((&summary["same"], &summary["first_different_tick"]), (&json!(false), &json!(tick)));
    assert_eq!((&summary["fault"]["then"], &summary["picture"]), (&Value::Null, &Value::Null));
    assert_eq!(summary["fault"]["now"]["body"], "cloth.r2.c2");
    assert!(!folder.path().join("out/picture.png").exists());
}

#[test]
fn what_cannot_be_unpacked_leaves_nothing() {
    let folder = folder();
    sandbox(&folder, FAILING);
    let good = fs::read(folder.path().join("box.zip")).unwrap();
    fs::write(folder.path().join("bad.zip"), &good[..good.len() / 2]).unwrap();
    let Said { out, err, .. } = sandbox(&folder, "replay bad.zip --out out").ends(2);
    assert_eq!((out.as_str(), err.lines().count()), ("", 1), "{err}");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_damaged_bundle_is_refused_in_the_window() {
    let folder = folder();
    sandbox(&folder, FAILING);
    let good = fs::read(folder.path().join("box.zip")).unwrap();
    fs::write(folder.path().join("bad.zip"), &good[..good.len() / 2]).unwrap();
    sandbox(&folder, "bad.zip").warns(2, "bad.zip: the bundle is damaged");
}
