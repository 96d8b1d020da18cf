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
    let said = sandbox(&folder, "replay box.zip --out sheet.ron");
    said.says(
        2,
        "sandbox: cannot make the folder sheet.ron: a file is in the way; give another path\n",
    );
    assert_eq!(said.out, "");
}

#[test]
fn the_summary_says_what_the_black_box_wrote() {
    let folder = folder();
    sandbox(&folder, FAILING);
    let summary = json(folder.path().join("s.json"));
    let saved = bundle(folder.path(), "box.zip").manifest;
    let fault = saved.fault.unwrap();
    let expected = json!({
        "path": "box.zip", "tick": fault.tick - 1,
        "fault": { "tick": fault.tick, "body": fault.body, "what": fault.what },
    });
    assert_eq!(summary["black_box"], expected);
    // It is that of the faulty tick, not of the one that was gone back to.
    assert_eq!([&summary["ticks"], &summary["quarantined"][0]["tick"]], [fault.tick; 2]);
    sandbox(&folder, "run sheet.ron --ticks 5 --black-box none.zip --summary s.json");
    assert_eq!(json(folder.path().join("s.json")).get("black_box"), Some(&Value::Null));
    sandbox(&folder, "run sheet.ron --ticks 5 --summary s.json");
    assert_eq!(json(folder.path().join("s.json")).get("black_box"), None);
}

#[test]
fn a_place_that_no_black_box_can_be_written_to_is_found_out_before_the_run() {
    let folder = folder();
    let line = "run sheet.ron --script nan.script --seconds 2 --black-box sheet.ron/box.zip --summary s.json";
    sandbox(&folder, line).warns(2, "cannot make the folder sheet.ron");
    assert!(!folder.path().join("s.json").exists());
    let line = "run sheet.ron --seconds 2 --black-box s.json --summary s.json";
    sandbox(&folder, line)
        .says(2, "sandbox: --summary and --black-box name the same file; give two\n");
    assert!(!folder.path().join("s.json").exists());
}

#[test]
fn a_bundle_where_a_scene_is_meant_is_named_and_the_window_tells_it_by_its_first_bytes() {
    let folder = folder();
    sandbox(&folder, FAILING);
    fs::rename(folder.path().join("box.zip"), folder.path().join("box.ron")).unwrap();
    for command in ["run", "plan", "effects", "ablate", "stability"] {
        let said = sandbox(&folder, &format!("{command} box.ron"));
        let words = "sandbox: box.ron: this is an archive, not a text; `sandbox box.ron` opens a bundle in the window, \
                     `sandbox replay box.ron` runs it\n";
        said.says(2, words);
        assert_eq!(said.out, "", "{command}");
    }
    let words = "sandbox: box.ron: a bundle repeats its own run; leave --method, --substeps and --record out\n";
    sandbox(&folder, "box.ron --substeps 2").says(2, words);
    let good = fs::read(folder.path().join("box.ron")).unwrap();
    fs::write(folder.path().join("bad.zip"), &good[..good.len() / 2]).unwrap();
    sandbox(&folder, "bad.zip").warns(2, "bad.zip: the bundle is damaged");
}
