//! What the documents say: generated parts are what the program says, and what a reader types or follows exists.

use std::fs;
use std::path::Path;
use std::process::Command;

use glam::DVec3;
use history::Simulation;
use lab::cost::Report;
use motion::effects::Effect;
use motion::{Claims, METHODS, Transform};
use sandbox::{actions, methods};
use tempfile::TempDir;

use crate::rigs::{assert_stored, cargo_metadata, commands, output, root, sandbox};
use crate::stability::committed;
use crate::tidy::{assert_named, named};

fn read(document: &str) -> String {
    fs::read_to_string(root().join(document)).unwrap()
}

/// Every document with its path from the root.
fn documents() -> Vec<(String, String)> {
    let in_folder = |folder: &'static str| {
        let names =
            fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().file_name());
        names.map(move |name| format!("{folder}/{}", name.to_str().unwrap()))
    };
    let names =
        in_folder("docs").chain(in_folder("docs/contract")).filter(|name| name.ends_with(".md"));
    let names = names.chain(["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(str::to_owned));
    names.map(|name| (name.clone(), read(&name))).collect()
}

/// Fails unless the part of a document between the marks of `name` is `text`; UPDATE_EXPECT=1 writes it.
#[track_caller]
fn assert_part(document: &str, name: &str, text: &str) {
    let page = read(document);
    let (before, rest) = page.split_once(&format!("<!-- {name}: begin")).unwrap();
    let (mark, rest) = rest.split_once("-->\n").unwrap();
    let (_, after) = rest.split_once(&format!("<!-- {name}: end")).unwrap();
    let page = format!("{before}<!-- {name}: begin{mark}-->\n{text}<!-- {name}: end{after}");
    assert_stored(document, &page);
}

#[test]
fn the_keys_are_those_of_the_program() {
    assert_part("docs/keys.md", "keys", &actions::markdown());
}

#[test]
fn the_methods_are_those_of_the_program() {
    assert_part("docs/methods.md", "methods", &methods::markdown());
}

#[test]
fn every_method_is_counted_in_the_readme_and_has_a_planet_in_the_race() {
    let numbers = ["seven", "eight", "nine", "ten", "eleven", "twelve", "thirteen"];
    let said = format!("compare {} methods of numerical integration", numbers[METHODS.len() - 7]);
    assert!(read("README.md").contains(&said), "README.md does not say {said:?}");
    let race = scene::load("orbits_race").unwrap();
    let planets = race.bodies.iter().filter_map(|body| body.method).collect::<Vec<_>>();
    for claims in METHODS {
        assert!(
            planets.contains(&claims.method),
            "no planet of orbits_race moves by {}",
            claims.name
        );
    }
    let mut race = Simulation::new(race);
    (0..540).for_each(|_| race.tick());
    let off = |name: &str| {
        let place =
            |name: &str| race.world.get::<Transform>(race.named(name).unwrap()).unwrap().position;
        // The far end of an orbit of a semi-major axis of 10 m and an eccentricity of 0.6.
        place(name).distance(place(&format!("{name}_sun")) + DVec3::X * 16.0)
    };
    let said = format!(
        "explicit Euler is {:.1} m from where its planet should be, velocity Verlet {:.0} cm, Runge-Kutta 4\n{:.2} mm.",
        off("explicit_euler"),
        1e2 * off("velocity_verlet"),
        1e3 * off("runge_kutta_4")
    );
    assert!(read("README.md").contains(&said), "README.md does not say {said:?}");
}

#[test]
fn the_scenes_are_those_that_are_shipped() {
    let row = |scene: &scene::ShippedScene| {
        format!("| `{}` | {} |\n", scene.name, scene.load().unwrap().description)
    };
    let rows: String = scene::shipped().iter().map(row).collect();
    assert_part(
        "docs/scenes.md",
        "scenes",
        &format!("| scene | what it shows |\n| --- | --- |\n{rows}"),
    );
}

#[test]
fn the_matrix_is_the_committed_one_and_names_every_case() {
    assert_part("docs/stability.md", "stability", &report::stability::markdown(&committed()));
    let page = read("docs/stability.md");
    for case in scene::cases() {
        assert!(page.contains(case.name), "docs/stability.md should name {}", case.name);
    }
}

#[test]
fn the_costs_are_those_of_the_committed_report() {
    let report: Report = serde_json::from_str(&read("docs/cost/report.json")).unwrap();
    assert!(
        report.complete && report.command == "sandbox cost kepler --quick",
        "{}",
        report.command
    );
    let [study] = &report.studies[..] else { panic!("one study") };
    assert_part("docs/accuracy.md", "cost", &report::brief(study, &report.machine));
    let everything = format!("## kepler\n\n{}", report::markdown(study, &report.machine));
    assert_stored("docs/cost/summary.md", &everything);
}

#[test]
fn the_readme_says_what_each_method_claims() {
    let readme = read("README.md");
    for Claims {
        title,
        position_order,
        evaluations,
        evaluations_with_velocity_laws: with_drag,
        ..
    } in METHODS
    {
        let with_drag = if with_drag == evaluations {
            String::new()
        } else {
            format!(", {with_drag} with drag")
        };
        let row = format!("\n| {title} | {position_order} | {evaluations}{with_drag} | ");
        assert!(readme.contains(&row), "README.md should contain the row{row}");
    }
}

#[test]
fn every_effect_is_explained() {
    let page = read("docs/effects.md");
    let names = Effect::ALL.map(|effect| effect.to_string());
    for effect in &names {
        assert!(page.contains(&format!("\n| `{effect}` | ")), "docs/effects.md lacks {effect}");
    }
    let all = format!("The effects are `{}`.", names.join(", "));
    assert!(read("docs/contract/scene.md").contains(&all), "docs/contract/scene.md lacks: {all}");
    let script = read("docs/contract/script.md");
    let row = script.lines().find(|line| line.contains("`switch_effect(")).unwrap();
    for effect in &names {
        assert!(row.contains(effect.as_str()), "docs/contract/script.md lacks {effect}");
    }
}

#[test]
fn the_tour_has_five_scenes_and_five_keys() {
    let readme = read("README.md");
    let rows = readme.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` | **"));
    let steps: Vec<_> = rows.map(|(name, rest)| (name, rest.split("**").next().unwrap())).collect();
    assert_eq!(steps.len(), 5);
    for (name, key) in steps {
        assert!(scene::load(name).is_ok(), "there is no scene {name}");
        let key = actions::key_of_word(key).unwrap();
        assert!(actions::binding(&key).is_some(), "the key {key} does nothing");
    }
}

/// The commands of each block of shell lines, without their comments.
fn blocks(page: &str) -> Vec<Vec<&str>> {
    fn commands(block: &str) -> Vec<&str> {
        let lines = block.split("\n```").next().unwrap().lines();
        let commands = lines.map(|line| line.split('#').next().unwrap().trim());
        commands.filter(|line| !line.is_empty()).collect()
    }
    page.split("```sh\n").skip(1).map(commands).collect()
}

/// The arguments of the program in a line that starts it.
fn arguments(line: &str) -> Option<&str> {
    ["cargo run --release -- ", "scripts/run ", "sandbox "]
        .iter()
        .find_map(|start| line.strip_prefix(start))
}

#[test]
fn every_command_is_one() {
    let all = commands();
    let commands: Vec<_> = all.iter().map(String::as_str).collect();
    let takes_a_scene = |command: &&str| {
        let help = sandbox(".", &format!("{command} --help")).fine();
        help.lines().any(|line| line.starts_with("Usage:") && line.contains("SCENE>"))
    };
    let of_scenes: Vec<_> = commands.iter().copied().filter(takes_a_scene).collect();
    assert!(of_scenes.contains(&"run") && !of_scenes.contains(&"list"), "{of_scenes:?}");
    for (document, page) in documents() {
        for line in blocks(&page).into_iter().flatten() {
            if let Some(arguments) = arguments(line) {
                // The help comes once the arguments before it were understood.
                let said = sandbox(".", &format!("{arguments} --help"));
                assert!(said.code == 0, "{document}: {line}: {}", said.err);
                let words: Vec<_> = arguments.split_whitespace().collect();
                let opened = match &words[..] {
                    [command, rest @ ..] if commands.contains(command) => {
                        rest.first().filter(|_| of_scenes.contains(command))
                    }
                    words => words.first(),
                };
                // A reader's own files are not here.
                let named = opened.filter(|name| !name.starts_with("--") && !name.contains('.'));
                assert!(
                    named.is_none_or(|name| scene::load(name).is_ok()),
                    "{document}: {line}: no such scene"
                );
            } else if line.starts_with("scripts/") {
                let script = root().join(line.split_whitespace().next().unwrap());
                assert!(script.is_file(), "{document}: {line}: there is no such script");
                let said = output(Command::new("bash").arg("-n").arg(&script));
                assert!(said.code == 0, "{line}: {}", said.err);
            }
        }
    }
}

/// The binary that `cargo run` builds here if no flag names one; `None` where it would ask for a flag.
fn binary_of_cargo_run() -> Option<String> {
    let metadata = cargo_metadata(&["--no-deps"]);
    let packages = metadata["packages"].as_array().unwrap();
    let defaults: Vec<_> =
        packages.iter().filter_map(|package| package["default_run"].as_str()).collect();
    let targets = packages.iter().flat_map(|package| package["targets"].as_array().unwrap());
    let binaries = targets.filter(|target| target["kind"][0] == "bin");
    let all: Vec<_> = binaries.filter_map(|target| target["name"].as_str()).collect();
    match (&defaults[..], &all[..]) {
        ([one], _) | ([], [one]) => Some((*one).to_owned()),
        _ => None,
    }
}

#[test]
fn cargo_run_finds_the_program() {
    assert_eq!(binary_of_cargo_run().as_deref(), Some("sandbox"));
}

#[test]
#[cfg(unix)]
fn the_first_command_of_each_block_of_the_readme_runs_as_it_is_typed() {
    let mut run = 0;
    for block in blocks(&read("README.md")) {
        let Some(line) = block[0].strip_prefix("cargo run --release -- ") else { continue };
        // The root of the repository, with room for what is written there.
        let folder = TempDir::new().unwrap();
        std::os::unix::fs::symlink(root().join("assets"), folder.path().join("assets")).unwrap();
        sandbox(folder.path(), line).fine();
        run += 1;
    }
    assert!(run > 0, "the README runs nothing");
}

/// What CONTRIBUTING.md says how to add, in its order.
const RECIPES: [&str; 11] = [
    "law",
    "method",
    "scene key",
    "generator",
    "tool",
    "command",
    "script action",
    "measure of lessons",
    "output column",
    "chart",
    "draw primitive",
];

#[test]
fn each_recipe_has_steps_and_a_test_and_names_what_there_is() {
    let page = read("CONTRIBUTING.md");
    let sections = page.split("\n## ").skip(1).filter_map(|section| {
        let recipe = section.strip_prefix("A ").or_else(|| section.strip_prefix("An "))?;
        recipe.split_once('\n')
    });
    let recipes: Vec<_> = sections.collect();
    assert_eq!(recipes.iter().map(|(title, _)| *title).collect::<Vec<_>>(), RECIPES);
    for (title, text) in recipes {
        let (text, proof) =
            text.split_once("\nProof: ").unwrap_or_else(|| panic!("{title} has no proof"));
        let steps: Vec<_> =
            text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())).collect();
        assert!(steps.len() >= 3, "{title} has only the steps {steps:?}");
        for (number, step) in (1..).zip(steps) {
            assert!(step.starts_with(&format!("{number}. ")), "{title}: {step}");
        }
        assert_named(title, text);
        let is_test = |path: &str| path.starts_with("tests/") || path.contains("/tests");
        assert!(named(proof).iter().any(|(path, _)| is_test(path)), "{title} names no test");
        assert_named(title, proof);
    }
}

/// The name by which a link leads to a heading.
fn anchor(heading: &str) -> String {
    let kept = heading
        .trim_start_matches('#')
        .trim()
        .chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

#[test]
fn every_link_leads_somewhere() {
    for (document, page) in documents() {
        let folder = root().join(&document).parent().map(Path::to_owned).unwrap();
        let prose = page.split("```").step_by(2);
        let targets = prose.flat_map(|text| text.split("](").skip(1));
        for target in targets.map(|rest| rest.split(')').next().unwrap()) {
            if target.starts_with("https://") {
                continue;
            }
            let (path, heading) = target.split_once('#').unwrap_or((target, ""));
            let path = if path.is_empty() { root().join(&document) } else { folder.join(path) };
            assert!(path.exists(), "{document}: {target} does not exist");
            if !heading.is_empty() {
                let text = fs::read_to_string(&path).unwrap();
                let mut headings = text.lines().filter(|line| line.starts_with('#'));
                assert!(
                    headings.any(|line| anchor(line) == heading),
                    "{document}: {target}: no such heading"
                );
            }
            if path.extension().is_some_and(|extension| extension == "png") {
                assert!(
                    fs::read(&path).unwrap().starts_with(b"\x89PNG"),
                    "{document}: {target} is no picture"
                );
            }
        }
    }
}
