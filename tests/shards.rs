//! Shards of studies: their merge is what one run makes, but for times; and what is no whole study is refused.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::rigs::{folder, listing, sandbox, sealed};

/// Every file of a folder with its name.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let mut all: Vec<_> =
        listing(folder).iter().map(|path| (name(path), fs::read(path).unwrap())).collect();
    all.sort();
    all
}

/// A file as JSON without times.
fn timeless(path: &Path) -> Value {
    fn gives_up(note: &Value) -> bool {
        note.as_str().is_some_and(|note| note.contains("too long to time"))
    }
    fn strip(value: Value) -> Value {
        match value {
            Value::Object(map) => {
                let is_time = |key: &str| {
                    ["time", "arithmetic_time", "tick_times", "checksum"].contains(&key)
                };
                map.into_iter()
                    .filter(|(key, _)| !is_time(key))
                    .map(|(key, value)| (key, strip(value)))
                    .collect()
            }
            // A slow machine, or a busy one, gives up the largest sizes.
            Value::Array(items) => {
                items.into_iter().filter(|item| !gives_up(item)).map(strip).collect()
            }
            other => other,
        }
    }
    strip(serde_json::from_slice(&fs::read(path).unwrap()).unwrap())
}

/// Runs all shards of a command, and merges them, the last first.
fn merged(folder: &TempDir, command: &str, of: u32, out: &str) -> String {
    let shard = |k: u32| format!("{out}-{k}");
    for k in 1..=of {
        sandbox(folder, &format!("{command} --shard {k}/{of} --out {}", shard(k))).fine();
    }
    let folders: Vec<_> = (1..=of).rev().map(shard).collect();
    sandbox(folder, &format!("merge {} --out {out}", folders.join(" "))).fine()
}

#[test]
fn a_merged_survival_matrix_is_that_of_one_run_byte_for_byte() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let command =
        "stability huge_steps compressed_spring zero_length_spring far_from_origin --ticks 150";
    sandbox(&folder, &format!("{command} --out whole")).fine();
    for of in [1, 3, 7] {
        let out = format!("merged{of}");
        merged(&folder, command, of, &out);
        assert_eq!(contents(&at("whole")), contents(&at(&out)), "{of}");
    }
    // Again into the same folder, as a matrix is.
    sandbox(&folder, "merge merged3-1 merged3-2 merged3-3 --out merged3").fine();
}

#[test]
fn a_merged_study_of_cost_has_the_errors_and_counts_of_one_run() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let command = "cost free_fall harmonic_oscillator --quick --bodies 1";
    sandbox(&folder, &format!("{command} --out whole")).fine();
    merged(&folder, command, 2, "merged");
    assert_eq!(timeless(&at("whole/report.json")), timeless(&at("merged/report.json")));
    let names =
        |name: &str| contents(&at(name)).into_iter().map(|(name, _)| name).collect::<Vec<_>>();
    assert_eq!(names("whole"), names("merged"));
    // Times of another machine stay with their study.
    let part = at("merged-2/part.json");
    let text = fs::read_to_string(&part).unwrap();
    let mut other: Value = serde_json::from_str(&text).unwrap();
    other["machine"]["processor"] = "another processor".into();
    fs::write(&part, sealed(&other.to_string())).unwrap();
    sandbox(&folder, "merge merged-1 merged-2 --out two").fine();
    let report: Value = serde_json::from_slice(&fs::read(at("two/report.json")).unwrap()).unwrap();
    assert!(report["studies"][0]["machine"].is_null());
    assert_eq!(report["studies"][1]["machine"]["processor"], "another processor");
    let page = fs::read_to_string(at("two/report.html")).unwrap();
    assert!(
        page.contains("another processor")
            && page.contains("<dt>Study</dt><dd>harmonic_oscillator</dd>")
    );
    // Over the whole report of another command nothing is written.
    sandbox(&folder, "cost free_fall --quick --bodies 1 --out third").fine();
    sandbox(&folder, "merge merged-1 merged-2 --out third")
        .fails(2, "third/cells.csv: this file exists");
}

/// Two pairs of bodies, each a part of its own, and a free body.
const PAIRS: &str = r#"(version: 1, bodies: [(name: "a"), (name: "b", position_m: (1.5, 0, 0)),
    (name: "c", position_m: (0, 5, 0)), (name: "d", position_m: (1, 5.2, 0)), (name: "free", velocity_m_s: (1, 0, 0))],
    springs: [(between: ("a", "b"), stiffness_n_m: 10, rest_length_m: 1), (between: ("c", "d"), stiffness_n_m: 90, rest_length_m: 1)])"#;

#[test]
fn a_merged_recommendation_has_every_part_of_the_scene() {
    let folder = folder([("pairs.ron", PAIRS)]);
    let at = |name: &str| folder.path().join(name);
    let command = "recommend pairs.ron --error 0.01 --seconds 0.5 --quick";
    let whole: Value =
        serde_json::from_str(&sandbox(&folder, &format!("{command} --format json")).fine())
            .unwrap();
    let table = merged(&folder, command, 2, "merged");
    assert_eq!(fs::read_to_string(at("merged/recommend.txt")).unwrap(), table);
    let merged: Value =
        serde_json::from_slice(&fs::read(at("merged/recommend.json")).unwrap()).unwrap();
    let parts = |report: &Value| {
        let parts = report["parts"].as_array().unwrap().iter();
        parts
            .map(|part| (part["part"].clone(), part["entries"].clone(), part["bodies"].clone()))
            .collect::<Vec<_>>()
    };
    assert_eq!(parts(&merged), parts(&whole));
    assert_eq!(parts(&merged).len(), 3);
    assert!(
        merged["parts"]
            .as_array()
            .unwrap()
            .iter()
            .all(|part| part["pick"]["error_m"].as_f64().unwrap() <= 0.01)
    );
    // The scene with it runs.
    sandbox(&folder, "run merged/scene.ron --seconds 0.5").fine();
    // Times of different processors are not compared.
    let part = at("merged-2/part.json");
    let mut other: Value = serde_json::from_slice(&fs::read(&part).unwrap()).unwrap();
    other["machine"]["processor"] = "another processor".into();
    fs::write(&part, sealed(&other.to_string())).unwrap();
    sandbox(&folder, "merge merged-1 merged-2 --out two")
        .fails(2, "times of different processors are not compared: measure all shards on one kind");
    assert!(!at("two").exists());
}

#[test]
fn shards_that_are_no_whole_study_are_refused_by_name() {
    let folder =
        folder([("own.ron", PAIRS), ("foreign/part.json", "{}"), ("foreign/note.txt", "mine")]);
    let at = |name: &str| folder.path().join(name);
    let line = |command: &str| sandbox(&folder, command);
    let command = "stability huge_steps zero_length_spring --ticks 50";
    merged(&folder, command, 3, "m");
    line("merge m-1 m-3 --out o").fails(2, "missing shards: 2/3; give the folders of all");
    line("merge m-1 m-2 m-2 m-3 --out o")
        .fails(2, "m-2: shard 2/3 is here and in m-2; leave one of them out");
    line("merge m-1 foreign --out o").fails(2, "part.json: not a part of a study of this version");
    line("merge m-1 nowhere --out o")
        .fails(2, "nowhere: no shard of a sweep or a study was written into this folder");
    line("stability huge_steps --ticks 50 --shard 2/3 --out n").fine();
    line("merge m-1 n m-3 --out o")
        .fails(2, "n: this is a study of another command than that in m-1");
    line(&format!("{command} --shard 2/4 --out k")).fine();
    line("merge m-1 k m-3 --out o")
        .fails(2, "k: this is a study of another number of shards than that in m-1");
    line(&format!("{command} --shard 1/3 --out m-2")).fails(
        2,
        "part.json: the part in this folder is of another shard; give another folder, or remove it",
    );
    line(&format!("{command} --shard 1/3 --out foreign"))
        .fails(2, "part.json: not a part of a study");
    line(&format!("{command} --shard 1/3")).fails(2, "--out");
    line(&format!("{command} --shard 4/3 --out x")).fails(2, "give which part of how many");
    line("recommend own.ron --error 1 --shard 1/2 --out x --apply y.ron").fails(2, "--apply");
    line("merge m-1 m-2 m-3 --out m-1").fine();
    for name in ["o", "x", "y.ron"] {
        assert!(!at(name).exists(), "{name}");
    }
    // A scene that changed.
    let studied = "recommend own.ron --error 0.1 --seconds 0.2 --quick";
    line(&format!("{studied} --shard 1/2 --out r1")).fine();
    fs::write(at("own.ron"), PAIRS.replace("1.5", "1.6")).unwrap();
    line(&format!("{studied} --shard 2/2 --out r2")).fine();
    line("merge r1 r2 --out r").fails(2, "r2: this is a study of other scenes than that in r1");
    // One that was cut short.
    let part = at("r2/part.json");
    let text = fs::read_to_string(&part).unwrap();
    let changed = |from, to| sealed(&text.replace(from, to));
    fs::write(&part, changed("\"complete\": true", "\"complete\": false")).unwrap();
    line("merge r2 --out r").fails(2, "r2: shard 2/2 is not complete; finish it with --resume");
    // One of an earlier format.
    fs::write(&part, changed("\"format\": 3", "\"format\": 2")).unwrap();
    line("merge r2 --out r").fails(
        2,
        "r2/part.json: this part was made by another version; run the shard again into another folder",
    );
}
