//! The rules of the repository, as tests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use acceptance::mutants::{MUTANTS, Mutant};
use motion::effects::Effect;

use crate::rigs::{cargo_metadata, root};

/// Every Rust file of the workspace with its text.
fn sources() -> Vec<(PathBuf, String)> {
    let mut folders = vec![root().join("crates"), root().join("tests")];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                // What cargo-fuzz builds lies beside its targets.
                if !path.ends_with("target") {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                files.push((path, text));
            }
        }
    }
    assert!(files.len() > 50, "the sources were not found");
    files
}

/// The lines of `text` that are code: no comments.
pub(crate) fn code(text: &str) -> impl Iterator<Item = &str> {
    text.lines().map(|line| line.split("//").next().unwrap_or_default())
}

fn in_folder(path: &Path, folder: &str) -> bool {
    path.strip_prefix(root()).unwrap().starts_with(folder)
}

/// A rule of words: code in a folder, apart from some files, names none of them.
struct Never {
    folders: &'static [&'static str],
    except: &'static [&'static str],
    words: &'static [&'static str],
}

const CHANGE: &str = "crates/cockpit/src/stage/change.rs";

/// What no lint and no list of dependencies says.
const NEVER: &[Never] = &[
    // The physics knows no device, no file and no clock.
    Never {
        folders: &["crates/motion/src"],
        except: &[],
        words: &["wgpu", "winit", "parry", "std::fs", "std::time"],
    },
    // The view changes no stage, and a stage knows no picture.
    Never {
        folders: &["crates/cockpit/src/view.rs", "crates/cockpit/src/view"],
        except: &[],
        words: &["&mut Stage"],
    },
    Never {
        folders: &["crates/cockpit/src/stage"],
        except: &[],
        words: &["egui", "render::", "Camera", "View"],
    },
    // Changes, which are recorded, are the only way to change how bodies move.
    Never {
        folders: &["crates/cockpit/src", "crates/sandbox/src"],
        except: &[CHANGE],
        words: &[
            "push_once",
            ".sustain(",
            "resource_mut::<Requests>",
            ".request(",
            ".set_method(",
            "sim.give(",
            ".world_mut(",
        ],
    },
    // A page is a shell of the cockpit, too.
    Never {
        folders: &["crates/cockpit/src"],
        except: &["crates/cockpit/src/view/picking/tests.rs"],
        words: &["std::fs", "std::thread", "std::env", "eprintln", "println"],
    },
    Never {
        folders: &["crates/sandbox/src"],
        except: &["crates/sandbox/src/window.rs", "crates/sandbox/src/window"],
        words: &["winit", "Instant", "SystemTime"],
    },
    Never {
        folders: &[
            "crates/motion/src",
            "crates/pick/src",
            "crates/swarm/src",
            "crates/scene/src",
            "crates/history/src",
            "crates/render/src",
            "crates/lab/src",
            "crates/report/src",
            "crates/cockpit/src",
        ],
        except: &["crates/lab/src/clock.rs"],
        words: &["winit", "Instant::now", "SystemTime"],
    },
    Never { folders: &["crates/render/src"], except: &[], words: &["bevy_ecs", "motion::"] },
    // What a page has otherwise is a door of its crate, or in a manifest.
    Never {
        folders: &["crates"],
        except: &["crates/lab/src/clock.rs", "crates/page"],
        words: &["wasm"],
    },
    // What differs between systems is behind the doors of the window, of files and of the clock, or in a manifest.
    Never {
        folders: &["crates"],
        except: &[
            "crates/sandbox/src/window",
            "crates/sandbox/src/output",
            "crates/sandbox/src/output.rs",
            "crates/lab/src/clock.rs",
            "crates/motion/benches/common/mod.rs",
        ],
        words: &["target_os", "target_vendor", "(unix", "(windows", "(not(unix", "(not(windows"],
    },
    // Scenes and their worlds need the logs of particles on a graphics device, and no device.
    Never {
        folders: &["crates/swarm/src"],
        except: &["crates/swarm/src/device.rs", "crates/swarm/src/painter.rs"],
        words: &["wgpu", "render::"],
    },
    // Scene and history parse files.
    Never {
        folders: &[
            "crates/pick/src",
            "crates/render/src",
            "crates/lab/src",
            "crates/report/src",
            "crates/cockpit/src",
            "crates/sandbox/src",
        ],
        except: &[],
        words: &["ron::"],
    },
    // Commands read files in one place, with which outputs are compared: but for what saves what was opened, and a test.
    Never {
        folders: &[
            "crates/sandbox/src/commands",
            "crates/sandbox/src/output",
            "crates/sandbox/src/window",
            "crates/sandbox/src/window.rs",
        ],
        except: &[
            "crates/sandbox/src/output/command_files.rs",
            "crates/sandbox/src/output/scenes.rs",
            "crates/sandbox/src/window/program.rs",
            "crates/sandbox/src/window/recorder.rs",
        ],
        words: &["scene::load(", "load_case(", "lesson::load", "read_text("],
    },
    // A list of all laws names these: `motion::laws`, `forces_on` and the methods of `Effect` are the ones to ask.
    Never {
        folders: &[
            "crates/lab/src",
            "crates/report/src",
            "crates/cockpit/src",
            "crates/sandbox/src",
        ],
        except: &[],
        words: &["Wells", "Thrust"],
    },
    // What a test starts has a deadline.
    Never {
        folders: &["tests"],
        except: &["tests/rigs/program.rs", "tests/tidy.rs", "tests/bin"],
        words: &[".output()", ".wait_with_output()"],
    },
    // Input never writes the state of a body.
    Never {
        folders: &[
            "crates/cockpit/src/app",
            "crates/cockpit/src/input.rs",
            "crates/cockpit/src/stage",
            "crates/cockpit/src/stage.rs",
            "crates/cockpit/src/tools",
            "crates/cockpit/src/view",
            "crates/cockpit/src/view.rs",
        ],
        except: &["tests.rs"],
        words: &["get_mut::<", "entity_mut(", "&mut PhysicsBody", "&mut Transform", "&mut Force"],
    },
];

#[test]
fn no_folder_names_what_is_not_its_own() {
    let all = sources();
    let mut wrong = Vec::new();
    for Never { folders, except, words } in NEVER {
        for folder in *folders {
            let inside = all.iter().filter(|(path, _)| in_folder(path, folder));
            assert!(inside.clone().next().is_some(), "{folder} has no sources");
            let is_free = |path: &Path| {
                except.iter().any(|except| in_folder(path, except) || path.ends_with(except))
            };
            for (path, text) in inside.filter(|(path, _)| !is_free(path)) {
                let text = if path.starts_with(root().join("tests")) {
                    text
                } else {
                    text.split("#[cfg(test)]").next().unwrap_or_default()
                };
                for (line, code) in (1..).zip(code(text)) {
                    let found = words.iter().filter(|word| code.contains(**word));
                    wrong.extend(
                        found.map(|word| format!("{}:{line} names {word}", path.display())),
                    );
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn motion_has_serde_and_the_plugin_only_if_asked() {
    let metadata = cargo_metadata(&["--no-deps"]);
    let packages = metadata["packages"].as_array().unwrap();
    let motion = packages.iter().find(|package| package["name"] == "inertia-motion").unwrap();
    assert!(motion["features"]["default"].is_null());
    let dependencies = motion["dependencies"].as_array().unwrap();
    for name in ["serde", "bevy_app", "bevy_reflect", "bevy_time", "bevy_transform"] {
        let found = dependencies.iter().find(|dependency| dependency["name"] == name).unwrap();
        assert_eq!(found["optional"], true, "{name}");
    }
}

/// The paths that one with braces stands for.
fn apart(path: &str) -> Vec<String> {
    let Some((before, inside)) = path.split_once('{') else { return vec![path.trim().to_owned()] };
    let inside = inside.trim().strip_suffix('}').unwrap();
    let (mut depth, mut start, mut paths) = (0, 0, Vec::new());
    for (at, c) in inside.char_indices().chain([(inside.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let part = inside[start..at].trim();
                paths.extend(
                    apart(part)
                        .iter()
                        .filter(|part| !part.is_empty())
                        .map(|part| format!("{before}{part}")),
                );
                start = at + 1;
            }
            _ => {}
        }
    }
    paths
}

/// The paths that the code of `module` names by `crate`, `self` or `super`, from the root of its crate, with their lines.
fn paths(module: &str, text: &str) -> Vec<(usize, String)> {
    let tests = text.find("#[cfg(test)]\nmod tests {").map(|at| text[..at].lines().count());
    let code = code(text).collect::<Vec<_>>().join("\n");
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let is_path = |c: char| is_name(c) || c == ':';
    let mut found = Vec::new();
    for (at, _) in
        ["crate::", "self::", "super::"].into_iter().flat_map(|start| code.match_indices(start))
    {
        let rest = &code[at..];
        let end = rest.find(|c| !is_path(c)).unwrap_or(rest.len());
        // A quote ends a piece of text that a macro makes a link of.
        if code[..at].ends_with(is_path) || rest[end..].starts_with('"') {
            continue;
        }
        let mut depth = 0;
        let closes = |(_, c): &(usize, char)| {
            depth += i32::from(*c == '{') - i32::from(*c == '}');
            depth == 0
        };
        let close =
            rest[end..].char_indices().find(closes).map_or(0, |(at, c)| at + usize::from(c == '}'));
        let line = code[..at].matches('\n').count() + 1;
        for path in apart(&rest[..end + close]) {
            let mut modules: Vec<_> = module.split("::").collect();
            modules.extend(tests.is_some_and(|tests| line > tests).then_some("tests"));
            for part in
                path.split("::").map(|part| part.split_whitespace().next().unwrap_or_default())
            {
                match part {
                    "crate" => modules.clear(),
                    "super" => modules.truncate(modules.len().saturating_sub(1)),
                    "self" | "" => {}
                    name => modules.push(name),
                }
            }
            found.push((line, modules.join("::")));
        }
    }
    found
}

/// The module of the file at that path below the sources of its crate.
fn module_of(path: &Path) -> String {
    path.with_extension("").to_str().unwrap().replace('/', "::")
}

/// The modules of `known` that the one of that name uses, outside its tests. Those around it and in it do not count: a module
/// shows what is in its folder.
fn used(module: &str, text: &str, known: &BTreeMap<String, &str>) -> BTreeSet<String> {
    let is_inside = |one: &str, other: &str| one == other || one.starts_with(&format!("{other}::"));
    let file = |(_, path): (usize, String)| {
        let mut path = path.as_str();
        while !known.contains_key(path) {
            path = path.rsplit_once("::")?.0;
        }
        Some(path.to_owned()).filter(|path| !is_inside(path, module) && !is_inside(module, path))
    };
    paths(module, text.split("#[cfg(test)]").next().unwrap()).into_iter().filter_map(file).collect()
}

/// The modules from which following what they use leads back to them.
fn circles(uses: &BTreeMap<String, BTreeSet<String>>) -> Vec<&String> {
    let leads_back = |start: &&String| {
        let (mut seen, mut next) = (BTreeSet::new(), vec![*start]);
        while let Some(module) = next.pop() {
            next.extend(uses[module].iter().filter(|used| seen.insert(*used)));
        }
        seen.contains(start)
    };
    uses.keys().filter(leads_back).collect()
}

#[test]
fn no_two_files_and_no_two_folders_need_each_other() {
    let known = BTreeMap::from(
        [("a", ""), ("b", ""), ("b::c", ""), ("d::e", "")]
            .map(|(name, text)| (name.to_owned(), text)),
    );
    let found = |text| used("b", text, &known).into_iter().collect::<Vec<_>>();
    assert_eq!(found("use crate::{a::X, d::{e::{Y, Z}}};"), ["a", "d::e"]);
    assert_eq!(found("use self::c::Y; fn f(x: crate::a::X) {}"), ["a"]);
    assert_eq!(found("use super::{a::{self, X}, d::e as f};"), ["a", "d::e"]);
    assert_eq!(found("// crate::a::X\n#[cfg(test)]\nuse crate::a::X;"), [""; 0]);
    let all = sources();
    for name in [
        "motion", "pick", "swarm", "scene", "history", "render", "lab", "report", "cockpit",
        "sandbox", "page",
    ] {
        let folder = root().join(format!("crates/{name}/src"));
        let texts: BTreeMap<_, _> = all
            .iter()
            .filter_map(|(path, text)| Some((module_of(path.strip_prefix(&folder).ok()?), &**text)))
            .filter(|(module, _)| {
                !["lib", "main"].contains(&&**module) && !module.ends_with("::tests")
            })
            .collect();
        assert!(texts.len() >= 5, "{name} has no files");
        let uses: BTreeMap<_, _> = texts
            .iter()
            .map(|(module, text)| (module.clone(), used(module, text, &texts)))
            .collect();
        assert_eq!(circles(&uses), [""; 0], "files of {name} that need each other");
        let head = |module: &String| module.split("::").next().unwrap_or_default().to_owned();
        let mut folders: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (module, used) in &uses {
            let own = head(module);
            let others = used.iter().map(head).filter(|used| *used != own).collect::<Vec<_>>();
            folders.entry(own).or_default().extend(others);
        }
        assert_eq!(circles(&folders), [""; 0], "folders of {name} that need each other");
    }
}

/// What may become f32 without a difference from what is near: sizes, directions, a streak, and what is near already.
const NO_PLACES: [&str; 6] =
    ["half_extents", "direction", "EXPOSURE_S", "(-eye)", "self.local(corner)", "origin"];

#[test]
fn places_become_f32_only_as_differences_from_what_is_near() {
    for (path, text) in sources().iter().filter(|(path, _)| in_folder(path, "crates")) {
        if path.components().any(|part| part.as_os_str() == "benches") {
            continue;
        }
        for (line, code) in (1..).zip(code(text)).filter(|(_, code)| code.contains(".as_vec3()")) {
            let is_near = code.contains(" - ") || NO_PLACES.iter().any(|word| code.contains(word));
            assert!(is_near, "{}:{line}: {code}", path.display());
        }
    }
}

/// The quoted texts that follow `before` in the code of `folder`.
fn quoted_after(folder: &str, before: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (path, text) in sources().iter().filter(|(path, _)| in_folder(path, folder)) {
        // Only tests have what is in these files.
        if path.file_name().is_some_and(|name| name == "tests.rs" || name == "lift.rs") {
            continue;
        }
        let code: String = code(text).map(|line| line.trim().to_owned() + " ").collect();
        let quoted = code.split(before).skip(1).filter_map(|rest| rest.split_once('"'));
        found.extend(quoted.map(|(word, _)| word.to_owned()));
    }
    assert!(!found.is_empty(), "nothing in {folder} follows {before}");
    found
}

#[test]
fn the_lists_of_names_that_files_hold_have_every_name_in_use() {
    let motion = "crates/motion/src";
    let laws = [
        quoted_after("crates/motion/src/laws", "fn name(&self) -> &'static str { \""),
        quoted_after(motion, "count_law(\""),
        quoted_after(motion, "Fault::Law(\""),
    ];
    for law in laws.into_iter().flatten() {
        assert!(motion::LAWS.iter().any(|(name, _)| *name == law), "LAWS lacks {law}");
    }
    let systems = quoted_after(motion, "\"integrate");
    let systems: BTreeSet<_> = systems.iter().map(|rest| format!("integrate{rest}")).collect();
    let places = quoted_after("crates/motion/src/tick/quarantine.rs", ": &str = \"");
    let mut names: BTreeSet<_> = motion::Cause::names().map(str::to_owned).collect();
    assert!(names.remove("requests") && names.remove("follow_motion"));
    // A law that is a resource goes by the name of its type, which is also that of its effect.
    let effects = Effect::ALL.map(|effect| format!("{effect:?}"));
    let laws: BTreeSet<_> = effects.into_iter().filter(|law| names.contains(law)).collect();
    assert_eq!(&(&systems | &places) | &laws, names);
}

#[test]
fn crates_whose_bits_matter_forbid_the_same_functions() {
    let lists: Vec<_> = ["motion", "swarm", "scene", "history"]
        .map(|name| fs::read_to_string(root().join(format!("crates/{name}/clippy.toml"))).unwrap())
        .iter()
        .map(|text| {
            text.lines()
                .filter(|line| !line.starts_with('#'))
                .map(str::to_owned)
                .collect::<Vec<_>>()
        })
        .collect();
    assert!(lists[0].len() > 40, "{} lines", lists[0].len());
    assert!(lists.iter().all(|list| *list == lists[0]));
}

#[test]
fn every_file_begins_with_what_it_is_for() {
    for (path, text) in sources() {
        assert!(text.starts_with("//! "), "{} does not begin with a `//!` line", path.display());
    }
}

#[test]
fn every_expected_text_has_its_test() {
    let sources: String = sources().into_iter().map(|(_, text)| text).collect();
    for file in fs::read_dir(root().join("tests/expected")).unwrap() {
        let path = file.unwrap().path();
        let name = format!("{:?}", path.file_stem().unwrap());
        assert!(sources.contains(&name), "no test compares with {}", path.display());
    }
}

#[test]
fn numbers_are_rounded_for_people_in_one_place() {
    // A column of a file has all digits of its numbers.
    let elsewhere = ["crates/report/src/numbers.rs", "crates/sandbox/src/output/states.rs"];
    let roundings = [".0e}", ".1e}", ".2e}", ".3e}", ".4e}", ".5e}", ".6e}"];
    for (path, text) in sources() {
        let shows = ["report", "cockpit", "sandbox"]
            .iter()
            .any(|name| in_folder(&path, &format!("crates/{name}/src")));
        if shows && !elsewhere.iter().any(|file| path.ends_with(file)) {
            let text = text.split("#[cfg(test)]").next().unwrap_or_default();
            let rounds = roundings.iter().any(|rounding| text.contains(rounding));
            assert!(!rounds, "{}: use report::numbers", path.display());
        }
    }
}

#[test]
fn one_version_of_glam_wgpu_and_winit() {
    let metadata = cargo_metadata(&["--locked"]);
    let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for package in metadata["packages"].as_array().unwrap() {
        versions
            .entry(package["name"].as_str().unwrap())
            .or_default()
            .push(package["version"].as_str().unwrap());
    }
    for (name, version) in [("glam", "0.33."), ("wgpu", "30."), ("winit", "0.30.")] {
        let found = &versions[name];
        assert_eq!(found.len(), 1, "{name} is here in {found:?}");
        assert!(found[0].starts_with(version), "{name} is {}, stay on {version}", found[0]);
    }
}

#[test]
fn every_mistake_of_the_list_can_be_made_and_its_test_exists() {
    for Mutant { mistake, file, from, to, killed_by } in MUTANTS {
        let text = fs::read_to_string(root().join(file)).unwrap();
        assert_eq!(
            (text.matches(from).count(), from == to),
            (1, false),
            "{mistake}: {from:?} in {file}"
        );
        let (module, test) = killed_by.rsplit_once("::").unwrap();
        let path = root()
            .join(format!("tests/{}.rs", module.trim_end_matches("::on_unix").replace("::", "/")));
        let tests = fs::read_to_string(path).unwrap();
        assert!(tests.contains(&format!("fn {test}()")), "{mistake}: there is no test {killed_by}");
    }
}

/// The files and folders that code spans of a text name, each with what the file has to name: `path` or `path: name`. A
/// `fn name` alone is in the file that was named before it.
pub fn named(text: &str) -> Vec<(&str, Option<&str>)> {
    let folders = ["assets", "crates", "docs", "examples", "scripts", "tests"];
    let mut places: Vec<(&str, Option<&str>)> = Vec::new();
    for span in text.split('`').skip(1).step_by(2) {
        let (path, name) =
            span.split_once(": ").map_or((span, None), |(path, name)| (path, Some(name)));
        let is_inside = path.split_once('/').is_some_and(|(folder, _)| folders.contains(&folder));
        let has_extension = Path::new(path).extension().is_some();
        if !path.contains(' ')
            && (is_inside || path.contains('/') && has_extension || path.ends_with(".md"))
        {
            places.push((path, name));
        } else if span.starts_with("fn ")
            && let Some((file, _)) = places.last()
        {
            places.push((file, Some(span)));
        }
    }
    places
}

/// Fails unless everything that `text` of a document names exists; how much that is.
#[track_caller]
pub fn assert_named(document: &str, text: &str) -> usize {
    let places = named(text);
    for (path, name) in &places {
        let file = root().join(path);
        assert!(file.exists(), "{document} names {path}, which does not exist");
        let Some(name) = name else { continue };
        let text =
            fs::read_to_string(&file).unwrap_or_else(|error| panic!("{document}: {path}: {error}"));
        // A function goes by its whole name.
        let after = |rest: &str| !name.starts_with("fn ") || rest.starts_with(['(', '<']);
        let is_named = text.match_indices(name).any(|(at, _)| after(&text[at + name.len()..]));
        assert!(is_named, "{document}: {path} does not name {name}");
    }
    places.len()
}

#[test]
fn what_the_documents_name_exists() {
    for (document, least) in
        [("ARCHITECTURE.md", 50), ("docs/how-it-works.md", 10), ("docs/performance.md", 5)]
    {
        let page = fs::read_to_string(root().join(document)).unwrap();
        let places = assert_named(document, &page);
        assert!(places >= least, "{document} names only {places} places");
    }
}
