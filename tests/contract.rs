//! The good side of the command line: lists, plans, state files, summaries and hashes as the contract has them, and that the
//! contract names all there is.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;
use xxhash_rust::xxh3::Xxh3;

use crate::rigs::{command_lines, commands, expected, folder, json, root, sandbox, summarized};
use crate::tidy::code;

#[track_caller]
fn run(line: &str) -> String {
    sandbox(TempDir::new().unwrap(), line).fine()
}

/// The state hash of `sandbox run line`, read from its summary file.
#[track_caller]
fn hash(folder: &Path, line: &str) -> String {
    sandbox(folder, &format!("run {line} --summary hash.json")).fine();
    json(folder.join("hash.json"))["state_hash"].as_str().unwrap().to_owned()
}

/// A row of a state file.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    tick: u64,
    time: f64,
    body: String,
    numbers: [f64; 6],
}

/// The rows of `sandbox run line --state`, each number written with 17 digits that read back to the same bits.
#[track_caller]
fn rows(folder: &Path, line: &str) -> Vec<Row> {
    sandbox(folder, &format!("run {line} --state state.csv")).fine();
    let text = fs::read_to_string(folder.join("state.csv")).unwrap();
    let mut lines = text.lines();
    let heading = "tick,time_s,body,position_x_m,position_y_m,position_z_m,velocity_x_m_s,velocity_y_m_s,velocity_z_m_s";
    assert_eq!(lines.next(), Some(heading));
    let number = |cell: &str| {
        let value: f64 = cell.parse().unwrap();
        let digits = cell.split('e').next().unwrap().trim_start_matches('-');
        assert_eq!((digits.len(), digits.find('.')), (18, Some(1)), "{cell}");
        assert_eq!(format!("{value:.16e}"), cell);
        value
    };
    lines
        .map(|line| {
            let cells: Vec<_> = line.split(',').collect();
            assert_eq!(cells.len(), 9, "{line}");
            Row {
                tick: cells[0].parse().unwrap(),
                time: number(cells[1]),
                body: cells[2].to_owned(),
                numbers: std::array::from_fn(|i| number(cells[3 + i])),
            }
        })
        .collect()
}

fn parsed(line: &str) -> Vec<serde_json::Map<String, Value>> {
    let Value::Array(rows) = serde_json::from_str(&run(line)).unwrap() else {
        panic!("{line}: a list")
    };
    rows.into_iter().map(|row| row.as_object().unwrap().clone()).collect()
}

#[test]
fn every_list_has_the_same_rows_as_a_table_and_as_json() {
    for (what, headings) in [("scenes", 0), ("cases", 0), ("methods", 1), ("laws", 1), ("keys", 0)]
    {
        let table = run(&format!("list {what}"));
        let rows = parsed(&format!("list {what} --format json"));
        assert_eq!(table.lines().count(), headings + rows.len(), "{what}");
        for (line, row) in table.lines().skip(headings).zip(&rows) {
            let mut rest = line;
            for (name, value) in row {
                let text = match value {
                    Value::String(limit) if name == "stability_limit" && limit == "inf" => {
                        "always".to_owned()
                    }
                    Value::Number(limit) if name == "stability_limit" => {
                        match limit.as_f64().unwrap() {
                            0.0 => "never".to_owned(),
                            limit => format!("w h < {}", (limit * 1e3).floor() / 1e3),
                        }
                    }
                    Value::String(text) => text.clone(),
                    Value::Bool(flag) => if *flag { "yes" } else { "no" }.to_owned(),
                    other => other.to_string(),
                };
                let cell = rest
                    .strip_prefix(text.as_str())
                    .filter(|rest| text.is_empty() || rest.is_empty() || rest.starts_with(' '));
                rest = cell
                    .unwrap_or_else(|| panic!("{line}: {name} is {text:?}, not {rest:?}"))
                    .trim_start();
            }
            assert_eq!(rest, "", "{line}");
        }
    }
    let scenes: Vec<_> =
        parsed("list scenes --format json").iter().map(|row| row["scene"].clone()).collect();
    assert_eq!(scenes, scene::shipped().iter().map(|scene| scene.name).collect::<Vec<_>>());
}

#[test]
fn methods_and_laws_are_listed_with_every_claim() {
    command_lines("lists");
}

/// The tables of runs and the summaries that they write.
#[test]
#[cfg(unix)]
fn summaries_have_the_keys_of_the_contract_in_order() {
    command_lines("summaries");
}

#[test]
fn every_key_and_every_action_is_listed_once() {
    let (mut keys, mut names) = (HashSet::new(), HashSet::new());
    for row in parsed("list keys --format json") {
        let text = |key: &str| row[key].as_str().unwrap().to_owned();
        assert_eq!(row.keys().collect::<Vec<_>>(), ["input", "when", "name", "what"]);
        assert!(!text("what").is_empty());
        assert!(["always", "camera mode", "selection mode"].contains(&text("when").as_str()));
        if text("name").is_empty() {
            // The mouse: an input is words, and may mean one thing in each mode.
            assert!(keys.insert((text("input"), text("when"))));
            continue;
        }
        assert!(names.insert(text("name")), "{row:?}");
        for key in text("input").split_whitespace() {
            assert!(keys.insert((key.to_owned(), String::new())), "{key} is listed twice");
        }
    }
    assert_eq!(names.len(), sandbox::actions::BINDINGS.len());
}

#[test]
fn explicit_euler_swaps_exactly_the_two_middle_lines_of_the_plan() {
    let (semi_implicit, explicit) =
        (run("plan tutorial"), run("plan tutorial --method explicit_euler"));
    // Without the number of the place.
    let systems = |plan: &str| -> Vec<String> {
        plan.lines().skip(1).map(|line| line.split_once(". ").unwrap().1.to_owned()).collect()
    };
    let mut swapped = systems(&semi_implicit);
    swapped.swap(1, 2);
    assert_eq!(systems(&explicit), swapped);
    assert!(explicit.starts_with("step of `tutorial`: explicit_euler, 120 Hz, 29 bodies\n"));
}

#[test]
fn every_shipped_scene_has_a_plan_whose_lines_are_numbered() {
    let golden = expected("plans").data();
    for scene in scene::shipped() {
        let plan = run(&format!("plan {}", scene.name));
        assert!(golden.contains(&plan), "{plan}");
        assert!(plan.starts_with(&format!("step of `{}`: ", scene.name)), "{plan}");
        let numbered = plan.lines().skip(1).filter(|line| !line.trim_start().starts_with('('));
        for (i, line) in numbered.enumerate() {
            let (number, system) = line.trim_start().split_once(". ").unwrap();
            assert_eq!(number, (i + 1).to_string(), "{plan}");
            let (name, what) = system.split_once(' ').unwrap();
            assert!(name.chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{name}");
            assert!(!what.trim().is_empty(), "{name} is not explained");
        }
    }
}

#[test]
fn a_state_file_has_the_start_every_kth_tick_and_the_end_once() {
    let folder = TempDir::new().unwrap();
    for (ticks, every, expected) in [
        (10, 3, vec![0, 3, 6, 9, 10]),
        (9, 3, vec![0, 3, 6, 9]),
        (2, 7, vec![0, 2]),
        (3, 1, vec![0, 1, 2, 3]),
        (0, 5, vec![0]),
    ] {
        let rows = rows(folder.path(), &format!("tutorial --ticks {ticks} --every {every}"));
        assert_eq!(rows.len(), expected.len() * 29);
        let ticks: Vec<_> = rows.chunks(29).map(|rows| rows[0].tick).collect();
        assert_eq!(ticks, expected);
        for row in &rows {
            assert!((row.time - row.tick as f64 / 120.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_state_file_has_immovable_bodies_in_stable_id_order_and_no_scenery() {
    let folder = TempDir::new().unwrap();
    let bodies = rows(folder.path(), "tutorial --ticks 0").into_iter().map(|row| row.body);
    let tutorial = scene::load("tutorial").unwrap();
    assert_eq!(bodies.collect::<Vec<_>>(), tutorial.names.iter().collect::<Vec<_>>());
    let rows = rows(folder.path(), "projectile --ticks 1");
    assert_eq!(rows.iter().map(|row| row.body.as_str()).collect::<Vec<_>>(), ["ball", "ball"]);
    // Bits that a person can check: x = v h, and v loses g h before the move.
    let (h, v) = (1.0 / 120.0, 14.142_135_623_730_951);
    assert_eq!(rows[0].numbers, [0.0, 0.0, 0.0, v, v, 0.0]);
    let vy = v + -9.8 * h;
    assert_eq!(rows[1].numbers, [v * h, vy * h, 0.0, v, vy, 0.0]);
}

/// Gravity on after a while and a push; nothing of it depends on frames.
const FALL: &str = "(version: 1, name: \"fall\", gravity: (), damping: (model: tutorial, rate_per_s: 0.4),
    grids: [(rows: 4, columns: 3)], bodies: [(name: \"ball\", velocity_m_s: (1, 5, 0.1), mass_kg: 0.3)])";

#[test]
fn the_state_is_the_same_for_every_frame_rate_and_every_run() {
    let folder = folder([("fall.ron", FALL)]);
    let times: String =
        (0..200_u32).map(|i| format!("{}\n", 0.003 + f64::from(i * 7919 % 97) * 0.001)).collect();
    fs::write(folder.path().join("uneven.times"), times).unwrap();
    for scene in ["fall.ron", "thousand"] {
        let hash = |flags: &str| hash(folder.path(), &format!("{scene} --ticks 240 {flags}"));
        let expected = hash("");
        for flags in
            ["", "--fps 30", "--fps 60", "--fps 144", "--fps 0.5", "--frame-times uneven.times"]
        {
            assert_eq!(hash(flags), expected, "{scene} {flags}");
        }
        assert_ne!(hash("--method explicit_euler"), expected, "{scene}");
        assert_ne!(hash("--hz 60"), expected, "{scene}");
    }
}

#[test]
fn a_shipped_scene_and_its_file_give_the_same_state_from_any_folder() {
    let folder = TempDir::new().unwrap();
    for scene in scene::shipped() {
        let file = root().join(format!("crates/scene/assets/scenes/{}.ron", scene.name));
        fs::copy(file, folder.path().join("copy.ron")).unwrap();
        let shipped = hash(folder.path(), &format!("{} --ticks 60", scene.name));
        assert_eq!(hash(folder.path(), "copy.ron --ticks 60"), shipped, "{}", scene.name);
    }
}

#[test]
fn the_state_hash_is_xxh3_over_the_bits_of_the_state() {
    let folder = folder([("fall.ron", FALL)]);
    for scene in ["tutorial", "coast", "projectile", "thousand", "empty", "fall.ron"] {
        let line = format!("{scene} --ticks 30 --every 30");
        let rows = rows(folder.path(), &line);
        let mut xxh3 = Xxh3::new();
        for number in rows.iter().filter(|row| row.tick == 30).flat_map(|row| row.numbers) {
            xxh3.update(&number.to_bits().to_le_bytes());
        }
        assert_eq!(
            hash(folder.path(), &line.replace(" --every 30", "")),
            format!("{:016x}", xxh3.digest())
        );
    }
}

#[test]
fn every_shipped_scene_keeps_what_it_expects_for_a_minute() {
    for scene in scene::shipped() {
        // A bound of the energy is what a scene claims of its own method, and is there to show others fail; so are the
        // steps of springs, and not every method solves mutual gravity.
        let resolved = scene.load().unwrap();
        let bounded = resolved.expect.unwrap_or_default().energy_drift_below.is_some();
        let springs = !resolved.springs.is_empty() || !resolved.soft_bodies.is_empty();
        let own = [resolved.method];
        // Particles on the device have a method of their own. Large scenes take long.
        let swarms = resolved.emitters.iter().any(|emitter| emitter.on_device.is_some());
        let large = resolved.bodies.len() > 10_000;
        let attracts = resolved.mutual_gravity.is_some();
        let methods = if bounded || springs || swarms || attracts || large {
            &own[..]
        } else {
            &motion::Method::ALL
        };
        for method in methods {
            // By its own method it is no fault either.
            let own = *method == resolved.method;
            let seconds = if own { 60.0 } else { 10.0 };
            let black_box = if own { "--black-box box.zip" } else { "" };
            let seconds = seconds * resolved.pace;
            let flags =
                format!("--seconds {seconds} --assert --method {} {black_box}", method.name());
            let table = run(&format!("run {} {flags}", scene.name));
            let simulated =
                table.lines().find_map(|line| line.strip_prefix("simulated_s")).unwrap();
            let simulated: f64 = simulated.trim().parse().unwrap();
            assert!((simulated / seconds - 1.0).abs() < 1e-9, "{}: {simulated} s", scene.name);
        }
    }
}

#[test]
fn implicit_steps_that_do_not_converge_are_counted_and_told() {
    // Implicit Euler falls into its sun.
    let (said, summary) = summarized([("", ""); 0], "run orbits_race --seconds 24");
    let told = said.ends(0).err;
    let steps = summary["unconverged_steps"].as_u64().unwrap();
    assert!(steps > 0 && summary["newton_iterations"].as_u64().unwrap() > 24 * 60);
    assert!(told.contains(&format!("{steps} implicit steps did not converge")), "{told}");
}

/// The page of the contract with that name.
fn contract(page: &str) -> String {
    fs::read_to_string(root().join(format!("docs/contract/{page}.md"))).unwrap()
}

/// The flags that a text names, whole.
fn flags(text: &str) -> BTreeSet<String> {
    let is_flag = |c: char| c.is_ascii_alphanumeric() || c == '-';
    let words = text.split(|c| !is_flag(c)).filter_map(|word| word.strip_prefix("--"));
    // A rule of a table is no flag.
    let flags = words.filter(|flag| flag.starts_with(|c: char| c.is_ascii_alphanumeric()));
    flags.filter(|flag| !["help", "version"].contains(flag)).map(str::to_owned).collect()
}

/// The flags of each command, as its help lists them. The window is the command without a name.
fn flags_of_commands() -> BTreeMap<String, BTreeSet<String>> {
    let listed = commands().into_iter().chain([String::new()]).map(|command| {
        let help = sandbox(".", &format!("{command} --help")).fine();
        // Examples and what is said of other flags name flags, too: an option begins its line.
        let options = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
        let options: String =
            options.map(|line| line.split("  ").next().unwrap().to_owned() + " ").collect();
        (command, flags(&options))
    });
    listed.collect()
}

#[test]
fn the_contract_names_every_command_with_exactly_its_flags() {
    let page = contract("command-line");
    let block =
        page.split_once("\n## Commands\n\n```\n").unwrap().1.split_once("\n```\n").unwrap().0;
    let (block, of_all) = block.split_once("\nany of them ").unwrap();
    let (block, of_all) = (format!("\n{block}"), flags(of_all));
    let mut sections = BTreeMap::new();
    for section in block.split("\nsandbox ").skip(1) {
        let name = section
            .split(' ')
            .next()
            .filter(|word| word.starts_with(|c: char| c.is_ascii_lowercase()));
        let flags: BTreeSet<_> = flags(section).union(&of_all).cloned().collect();
        sections.insert(name.unwrap_or_default().to_owned(), flags);
    }
    let expected = flags_of_commands();
    assert_eq!(sections.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (command, named) in sections {
        assert_eq!(
            named, expected[&command],
            "docs/contract/command-line.md on `sandbox {command}`"
        );
    }
}

#[test]
fn the_contract_names_no_flag_that_does_not_exist() {
    let exist: BTreeSet<_> = flags_of_commands().into_values().flatten().collect();
    let mut seen = 0;
    for page in fs::read_dir(root().join("docs/contract")).unwrap() {
        let page = page.unwrap().path();
        let named = flags(&fs::read_to_string(&page).unwrap());
        seen += named.len();
        let missing: Vec<_> = named.difference(&exist).collect();
        assert!(missing.is_empty(), "{} names {missing:?}", page.display());
    }
    assert!(seen > exist.len(), "the pages name {seen} flags of {}", exist.len());
}

#[test]
fn the_contract_names_every_key_of_scenes() {
    let page = contract("scene");
    let words: BTreeSet<_> =
        page.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
    let mut keys = BTreeSet::new();
    for file in ["raw.rs", "raw/coupled.rs", "raw/survival.rs"] {
        let source = fs::read_to_string(root().join("crates/scene/src").join(file)).unwrap();
        let lines: Vec<_> =
            source.lines().map(|line| line.trim().trim_start_matches("pub ")).collect();
        for (before, line) in lines.iter().zip(&lines[1..]) {
            let Some((field, value)) = line.split_once(": ") else { continue };
            let is_name = field.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
            if is_name && ["Option<", "Vec<"].iter().any(|kind| value.starts_with(kind)) {
                let renamed = before
                    .strip_prefix("#[serde(rename = \"")
                    .and_then(|rest| rest.split_once('"'));
                keys.insert(renamed.map_or(field, |(key, _)| key).to_owned());
            }
        }
    }
    assert!(keys.len() > 100, "found only {keys:?}");
    let missing: Vec<_> = keys.iter().filter(|key| !words.contains(key.as_str())).collect();
    assert!(missing.is_empty(), "docs/contract/scene.md lacks {missing:?}");
}

#[test]
fn the_contract_names_every_key_and_measure_of_lessons() {
    let page = contract("lesson");
    let words: BTreeSet<_> =
        page.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).collect();
    let source =
        |file: &str| fs::read_to_string(root().join("crates/scene/src").join(file)).unwrap();
    let (keys, measures) = (source("lesson/raw.rs"), source("lesson.rs"));
    let structs = keys.split("\nstruct Raw").skip(1).map(|text| text.split_once("\n}").unwrap().0);
    let keys = structs
        .flat_map(str::lines)
        .filter_map(|line| Some(line.trim().split_once(": ")?.0.to_owned()));
    let of = |name: &str| {
        let start = format!("pub enum {name} {{");
        measures.split_once(&*start).unwrap().1.split_once("\n}").unwrap().0.to_owned()
    };
    let measures = ["RunMeasure", "ScreenMeasure"].map(of).concat();
    let measures =
        code(&measures).map(|line| line.trim().trim_end_matches(',').split('(').next().unwrap());
    let measures =
        measures.filter(|word| word.starts_with(|c: char| c.is_ascii_uppercase())).map(snake_case);
    let all: Vec<_> = keys.chain(measures).collect();
    assert!(all.len() > 50, "found only {all:?}");
    let missing: Vec<_> = all.iter().filter(|key| !words.contains(key.as_str())).collect();
    assert!(missing.is_empty(), "docs/contract/lesson.md lacks {missing:?}");
}

/// The name in files of a variant.
fn snake_case(variant: &str) -> String {
    let mut name = String::new();
    for c in variant.chars() {
        if c.is_ascii_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.push(c.to_ascii_lowercase());
    }
    name
}

#[test]
fn the_contract_names_every_action_of_scripts() {
    let page = contract("script");
    let error =
        scene::Script::parse("t", "[(at_s: 0, do: no_such_action)]").unwrap_err().to_string();
    let names: Vec<_> = error.split_once("known here: ").unwrap().1.split(", ").collect();
    assert!(names.len() > 20, "found only {names:?}");
    for name in names {
        let named = ["`", "("].iter().any(|end| page.contains(&format!("`{name}{end}")));
        assert!(named, "docs/contract/script.md lacks the action {name}");
    }
}
