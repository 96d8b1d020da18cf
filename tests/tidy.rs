//! The rules of the repository, as tests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use acceptance::mutants::{MUTANTS, Mutant};
use motion::effects::Effect;

use crate::rigs::{cargo_metadata, commands, root, sandbox};

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
fn code(text: &str) -> impl Iterator<Item = &str> {
    text.lines().map(|line| line.split("//").next().unwrap_or_default())
}

fn in_folder(path: &Path, folder: &str) -> bool {
    path.strip_prefix(root()).unwrap().starts_with(folder)
}

/// Fails if code in `folder`, `except` aside, names one of `words`.
#[track_caller]
fn never(folder: &str, except: &[&str], words: &[&str]) {
    let mut seen = 0;
    for (path, text) in sources().iter().filter(|(path, _)| in_folder(path, folder)) {
        if except.iter().any(|except| in_folder(path, except)) {
            continue;
        }
        seen += 1;
        for (line, code) in code(text).enumerate() {
            for word in words {
                assert!(!code.contains(word), "{}:{} names {word}", path.display(), line + 1);
            }
        }
    }
    assert!(seen > 0, "{folder} has no sources");
}

#[test]
fn motion_knows_no_device_no_file_and_no_clock() {
    never("crates/motion/src", &[], &["wgpu", "winit", "parry", "std::fs", "std::time"]);
}

#[test]
fn motion_has_serde_and_the_plugin_only_if_asked() {
    let metadata = cargo_metadata(&["--no-deps"]);
    let packages = metadata["packages"].as_array().unwrap();
    let motion = packages.iter().find(|package| package["name"] == "motion").unwrap();
    assert!(motion["features"]["default"].is_null());
    let dependencies = motion["dependencies"].as_array().unwrap();
    for name in ["serde", "bevy_app"] {
        let found = dependencies.iter().find(|dependency| dependency["name"] == name).unwrap();
        assert_eq!(found["optional"], true, "{name}");
    }
}

/// The files and folders of `crates/motion/src`: each uses itself and those before it.
const LAYERS: &[&str] = &[
    "simd", "units", "lists", "names", "state", "laws", "methods", "kernels", "tick", "groups",
    "schedule", "snapshot", "observe",
];

/// The same of `crates/cockpit/src`.
const ROOMS: &[&str] = &[
    "clock", "refused", "methods", "input", "panels", "actions", "stage", "intent", "view",
    "tools", "app",
];

/// The same of `crates/sandbox/src`.
const SHELL: &[&str] = &["failure", "args", "output", "window", "commands"];

/// The same of `crates/scene/src`.
const FROM_TEXT_TO_SCENE: &[&str] = &[
    "random",
    "text",
    "action",
    "frame_times",
    "lists",
    "raw",
    "scene",
    "script",
    "memory",
    "check",
    "generate",
    "resolve",
    "spawn",
    "entries",
    "parts",
    "edit",
    "shipped",
    "lesson",
];

/// The same of `crates/history/src`.
const HISTORY: &[&str] = &[
    "simulation",
    "bonds",
    "distances",
    "snapshot",
    "settings",
    "change",
    "bundle",
    "timeline",
    "twin",
];

/// The same of `crates/lab/src`.
const LAB: &[&str] = &[
    "run",
    "shard",
    "column",
    "ordered",
    "trial",
    "cost",
    "ablation",
    "receipt",
    "recommend",
    "stability",
    "sweep",
    "lesson",
];

/// The same of `crates/report/src`.
const FROM_NUMBERS_TO_PAGES: &[&str] = &[
    "numbers",
    "forecast",
    "escape",
    "palette",
    "chart",
    "table",
    "words",
    "tables",
    "figures",
    "csv",
    "summary",
    "page",
    "handout",
    "stability",
    "sweep",
];

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

/// The uses of a later layer, or of what is no layer, in the file at that path below the sources of its crate.
fn wrong_uses(layers: &[&str], path: &Path, text: &str) -> Vec<String> {
    let module = module_of(path);
    let head = |path: &str| path.split("::").next().unwrap_or_default().to_owned();
    let place = |name: &str| layers.iter().position(|layer| *layer == name);
    let own = place(&head(&module));
    paths(&module, text)
        .into_iter()
        .map(|(line, path)| (line, head(&path)))
        .filter(|(_, head)| place(head).is_none() || place(head) > own)
        .map(|(line, head)| format!("{}:{line}: {module} uses `{head}`", path.display()))
        .collect()
}

/// Fails if a layer of a crate uses a later one, or one is not in the list.
#[track_caller]
fn in_layers(folder: &str, layers: &[&str]) {
    let folder = root().join(folder);
    let names = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let names = names.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned());
    let names: BTreeSet<_> = names.filter(|name| !["lib", "main"].contains(&&**name)).collect();
    assert_eq!(names, layers.iter().map(|layer| (*layer).to_owned()).collect());
    let mut wrong = Vec::new();
    for (path, text) in sources() {
        if let Ok(path) = path.strip_prefix(&folder)
            && !["lib.rs", "main.rs"].map(Path::new).contains(&path)
            && !path.ends_with("tests.rs")
        {
            wrong.extend(wrong_uses(layers, path, &text));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn each_layer_of_motion_uses_only_those_before_it() {
    in_layers("crates/motion/src", LAYERS);
}

#[test]
fn each_room_of_cockpit_and_sandbox_uses_only_those_before_it() {
    in_layers("crates/cockpit/src", ROOMS);
    in_layers("crates/sandbox/src", SHELL);
}

#[test]
fn each_layer_of_scene_and_history_uses_only_those_before_it() {
    in_layers("crates/scene/src", FROM_TEXT_TO_SCENE);
    in_layers("crates/history/src", HISTORY);
}

#[test]
fn each_layer_of_lab_and_report_uses_only_those_before_it() {
    in_layers("crates/lab/src", LAB);
    in_layers("crates/report/src", FROM_NUMBERS_TO_PAGES);
}

#[test]
fn a_use_of_a_later_layer_is_found() {
    let uses = [
        ("tick/integrate.rs", "use crate::schedule::stepper::Stepper;", true),
        ("tick/integrate.rs", "use crate::{laws, schedule};", true),
        ("tick/integrate.rs", "fn f(at: crate::Transform) {}", true),
        ("tick/integrate.rs", "use super::super::schedule::systems;", true),
        ("tick.rs", "use super::schedule::systems;", true),
        ("kernels/affine.rs", "$crate::groups::rows!();", true),
        ("tick/integrate.rs", "use crate::kernels::Account;", false),
        ("tick/integrate.rs", "use crate::{\n    laws::{Law, Wells},\n    state,\n};", false),
        ("tick/integrate.rs", "use super::super::laws::Law;", false),
        ("tick/integrate.rs", "use super::quarantine::Cause;", false),
        ("tick/integrate.rs", "/// See [`Stepper`](crate::Stepper).", false),
        ("tick.rs", "#[cfg(test)]\nmod tests {\n    use super::*;", false),
    ];
    for (path, text, is_wrong) in uses {
        assert_eq!(
            !wrong_uses(LAYERS, Path::new(path), text).is_empty(),
            is_wrong,
            "{path}: {text}"
        );
    }
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
fn no_two_files_need_each_other() {
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
    for name in
        ["motion", "pick", "scene", "history", "render", "lab", "report", "cockpit", "sandbox"]
    {
        let folder = root().join(format!("crates/{name}/src"));
        let texts: BTreeMap<_, _> = all
            .iter()
            .filter_map(|(path, text)| Some((module_of(path.strip_prefix(&folder).ok()?), &**text)))
            .filter(|(module, _)| !["lib", "main"].contains(&&**module))
            .collect();
        assert!(texts.len() > 10, "{name} has no files");
        let uses = texts
            .iter()
            .map(|(module, text)| (module.clone(), used(module, text, &texts)))
            .collect();
        assert_eq!(circles(&uses), [""; 0], "files of {name} that need each other");
    }
}

#[test]
fn the_view_changes_no_stage_and_a_stage_knows_no_picture() {
    never("crates/cockpit/src/view.rs", &[], &["&mut Stage"]);
    never("crates/cockpit/src/view", &[], &["&mut Stage"]);
    never("crates/cockpit/src/stage", &[], &["egui", "render::", "Camera", "View"]);
}

#[test]
fn the_sandbox_changes_a_simulation_by_changes_alone() {
    let ways = [
        "push_once",
        ".sustain(",
        "resource_mut::<Requests>",
        ".request(",
        ".set_method(",
        "sim_mut().push(",
    ];
    for folder in ["crates/cockpit/src", "crates/sandbox/src"] {
        never(folder, &["crates/cockpit/src/stage/change.rs"], &ways);
    }
    // Which also records it.
    for folder in ["crates/cockpit/src", "crates/sandbox/src"] {
        never(folder, &["crates/cockpit/src/stage/change.rs"], &["sim.give(", "sim_mut().give("]);
    }
}

/// The whole program may hold a stage, so it must not become the place for everything.
#[test]
fn a_stage_has_at_most_sixty_methods_and_private_parts() {
    let mut methods = 0;
    for (_, text) in sources().iter().filter(|(path, _)| in_folder(path, "crates/cockpit/src")) {
        for part in text.split("\nimpl Stage {\n").skip(1) {
            let body = part.split("\n}\n").next().unwrap();
            methods += body.lines().filter(|line| is_method(line)).count();
        }
    }
    assert!((30..=60).contains(&methods), "{methods}");

    let text = fs::read_to_string(root().join("crates/cockpit/src/stage.rs")).unwrap();
    let stage = text.split("pub struct Stage {\n").nth(1).unwrap().split("\n}\n").next().unwrap();
    let fields = code(stage).filter_map(|line| line.trim().strip_prefix("pub"));
    let visible: BTreeSet<_> =
        fields.filter_map(|field| field.split(':').next()?.rsplit(' ').next()).collect();
    // Messages out of a stage, on which it does not depend.
    assert_eq!(visible, BTreeSet::from(["caption", "files", "notices", "orders"]));
}

fn is_method(line: &str) -> bool {
    let Some(item) = line.strip_prefix("    ").filter(|item| !item.starts_with(' ')) else {
        return false;
    };
    !item.starts_with("//") && item.contains("fn ")
}

#[test]
fn render_has_never_heard_of_an_entity() {
    never("crates/render/src", &[], &["bevy_ecs", "motion::", "winit"]);
}

#[test]
fn only_the_window_names_winit_or_reads_the_wall_clock() {
    let window = ["crates/sandbox/src/window.rs", "crates/sandbox/src/window"];
    never("crates/sandbox/src", &window, &["winit", "Instant", "SystemTime"]);
    // A page is a shell of the cockpit, too.
    let doors = ["std::fs", "std::thread", "std::env", "eprintln", "println"];
    never("crates/cockpit/src", &["crates/cockpit/src/view/picking/tests.rs"], &doors);
    for name in ["motion", "pick", "scene", "history", "render", "lab", "report", "cockpit"] {
        never(&format!("crates/{name}/src"), &[], &["winit", "Instant::now", "SystemTime"]);
    }
}

#[test]
fn only_scene_parses_files() {
    // Reports read what they wrote themselves.
    let own = [
        "cost/record.rs",
        "stability/record.rs",
        "stability/class.rs",
        "shard.rs",
        "sweep/axis.rs",
        "sweep/measure.rs",
        "sweep/record.rs",
        "recommend.rs",
        "part.rs",
    ];
    let own = own.map(|file| format!("crates/lab/src/{file}"));
    let own: Vec<_> =
        own.into_iter().chain(["crates/sandbox/src/output/files.rs".to_owned()]).collect();
    let own: Vec<_> = own.iter().map(|file| &**file).collect();
    // What motion derives behind its feature `serde` is read by history.
    for name in ["pick", "render", "lab", "report", "cockpit", "sandbox"] {
        never(&format!("crates/{name}/src"), &own, &["ron::", "Deserialize"]);
    }
}

#[test]
fn commands_read_files_in_one_place_that_outputs_are_compared_with() {
    let rooms = ["commands", "output", "window", "window.rs"];
    // The one place, what saves what was opened, and a test.
    let except =
        ["output/command_files.rs", "output/scenes.rs", "window/program.rs", "window/recorder.rs"];
    let except = except.map(|file| format!("crates/sandbox/src/{file}"));
    for room in rooms {
        never(
            &format!("crates/sandbox/src/{room}"),
            &except.each_ref().map(|file| &**file),
            &["scene::load(", "load_case(", "lesson::load", "load_script(", "read_text("],
        );
    }
}

/// What a place may become f32 of without a difference: sizes, directions, a streak, and what is one already.
const NO_PLACES: &[&str] = &[
    "half_extents()",
    "half_extents",
    "direction()",
    "direction",
    "(velocity * EXPOSURE_S)",
    "(-eye)",
    "self.local(corner)",
    "origin",
];

/// Conversions of vectors to f32 in `text` that are of no difference, with their lines.
fn whole_places(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (line, code) in code(text).enumerate() {
        for (at, _) in code.match_indices(".as_vec3()") {
            let before = &code[..at];
            // The last group in parentheses, or the last name.
            let mut depth = 0;
            let starts = |(_, c): &(usize, char)| {
                depth += i32::from(*c == ')') - i32::from(*c == '(');
                depth < 0
                    || depth == 0
                        && !(*c == '(' || c.is_alphanumeric() || matches!(c, '_' | '.' | ')'))
            };
            let start = before
                .char_indices()
                .rev()
                .find(starts)
                .map_or(0, |(place, c)| place + c.len_utf8());
            let receiver = &before[start..];
            let is_difference = receiver.starts_with('(') && receiver.contains(" - ");
            if !is_difference && !NO_PLACES.iter().any(|fine| receiver.ends_with(fine)) {
                found.push((line + 1, receiver.to_owned()));
            }
        }
    }
    found
}

#[test]
fn places_become_f32_only_as_differences_from_what_is_near() {
    for (text, is_whole) in [
        ("let x = at.position.as_vec3();", true),
        ("f(self.place(body).as_vec3())", true),
        ("(place * 2.0).as_vec3()", true),
        ("(at.position - eye).as_vec3()", false),
        ("let [a, b] = [a, b].map(|at| (at - self.eye).as_vec3());", false),
        ("shape.half_extents().as_vec3()", false),
    ] {
        assert_eq!(!whole_places(text).is_empty(), is_whole, "{text}");
    }
    let mut found = Vec::new();
    for (path, text) in sources().iter().filter(|(path, _)| in_folder(path, "crates")) {
        let folders = ["crates/pick/src", "crates/cockpit/src"];
        if folders.iter().any(|folder| in_folder(path, folder)) {
            let before_tests = text.split("#[cfg(test)]").next().unwrap_or_default();
            let tests = path.components().any(|part| part.as_os_str() == "tests")
                || path.ends_with("tests.rs");
            let whole = if tests { Vec::new() } else { whole_places(before_tests) };
            found.extend(
                whole.into_iter().map(|(line, what)| format!("{}:{line}: {what}", path.display())),
            );
        } else if !path
            .components()
            .any(|part| ["tests", "benches"].map(|name| name.as_ref()).contains(&part.as_os_str()))
        {
            assert!(!text.contains(".as_vec3()"), "{} makes places f32", path.display());
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}

/// The lines of `text` that can write a component of a body, up to its tests.
fn writes(text: &str) -> Vec<usize> {
    let words = ["get_mut::<", "entity_mut(", "&mut PhysicsBody", "&mut Transform", "&mut Force"];
    let before_tests = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = (1..).zip(code(before_tests));
    lines
        .filter(|(_, code)| words.iter().any(|word| code.contains(word)))
        .map(|(line, _)| line)
        .collect()
}

#[test]
fn input_never_writes_the_state_of_a_body() {
    for (text, is_write) in [
        ("world.entity_mut(body).insert(Transform::at(place));", true),
        ("world.get_entity_mut(body)?.remove::<PhysicsBody>();", true),
        ("world.get_mut::<PhysicsBody>(body)?.velocity = velocity;", true),
        ("world.query::<&mut Transform>().iter_mut(world)", true),
        ("world.entity(body).get::<Transform>()", false),
        ("world.resource_mut::<PushQueue>().push_once(body, newtons);", false),
    ] {
        assert_eq!(!writes(text).is_empty(), is_write, "{text}");
    }
    let folders = ["app", "input.rs", "stage", "stage.rs", "tools", "view", "view.rs"]
        .map(|name| format!("crates/cockpit/src/{name}"));
    for folder in folders {
        let inside: Vec<_> =
            sources().into_iter().filter(|(path, _)| in_folder(path, &folder)).collect();
        assert!(!inside.is_empty(), "{folder} has no sources");
        for (path, text) in inside.iter().filter(|(path, _)| !path.ends_with("tests.rs")) {
            assert_eq!(writes(text), [0; 0], "lines of {} write a body", path.display());
        }
    }
}

#[test]
fn only_motion_keeps_lists_of_laws() {
    // A list of all laws names these: `motion::laws`, `forces_on` and the methods of `Effect` are the ones to ask.
    for name in ["lab", "report", "cockpit", "sandbox"] {
        never(&format!("crates/{name}/src"), &[], &["Wells", "Thrust"]);
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
    assert!(names.remove("requests"));
    // A law that is a resource goes by the name of its type, which is also that of its effect.
    let effects = Effect::ALL.map(|effect| format!("{effect:?}"));
    let laws: BTreeSet<_> = effects.into_iter().filter(|law| names.contains(law)).collect();
    assert_eq!(&(&systems | &places) | &laws, names);
}

#[test]
fn crates_whose_bits_matter_forbid_the_same_functions() {
    let lists: Vec<_> = ["motion", "scene", "history"]
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
fn no_test_is_ignored_and_nothing_is_left_to_do() {
    // Put together here, so that this file does not find itself.
    let words = [["#[ig", "nore"], ["todo", "!("], ["unimplem", "ented!"], ["dbg", "!("]]
        .map(|word| word.concat());
    for (path, text) in sources() {
        for word in &words {
            assert!(!text.contains(word.as_str()), "{} has {word}", path.display());
        }
    }
}

#[test]
fn what_a_test_starts_has_a_deadline() {
    never(
        "tests",
        &["tests/rigs/program.rs", "tests/tidy.rs", "tests/bin"],
        &[".output()", ".wait_with_output()"],
    );
}

#[test]
fn unwrap_is_for_tests() {
    for (path, text) in sources().iter().filter(|(path, _)| in_folder(path, "crates")) {
        let test = ["tests", "benches", "examples"]
            .iter()
            .any(|folder| path.components().any(|part| part.as_os_str() == *folder));
        let tests_only = path.file_name().is_some_and(|name| name == "tests.rs");
        if !test && !tests_only {
            let before_tests = text.split("#[cfg(test)]").next().unwrap_or_default();
            assert!(!before_tests.contains(".unwrap()"), "{} unwraps", path.display());
        }
    }
}

#[test]
fn numbers_are_rounded_for_people_in_one_place() {
    let rounds = |line: &str| {
        let after = line.split(":.").skip(1);
        after
            .filter(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()).starts_with("e}"))
            .count()
    };
    assert_eq!([rounds("{x:.2e} m, {y:.3}"), rounds("{x:e}"), rounds("{:.10e}")], [1, 0, 1]);
    // A column of a file has all digits of its numbers.
    let elsewhere = ["crates/report/src/numbers.rs", "crates/sandbox/src/output/states.rs"];
    for (path, text) in sources() {
        let shows = ["cockpit", "sandbox", "report"]
            .iter()
            .any(|name| in_folder(&path, &format!("crates/{name}/src")));
        if shows && !elsewhere.iter().any(|file| path.ends_with(file)) {
            let text = text.split("#[cfg(test)]").next().unwrap_or_default();
            assert_eq!(
                code(text).map(rounds).sum::<usize>(),
                0,
                "{}: use report::numbers",
                path.display()
            );
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
    let measures =
        measures.split_once("pub enum Measure {").unwrap().1.split_once("\n}").unwrap().0;
    let measures =
        code(measures).map(|line| line.trim().trim_end_matches(',').split('(').next().unwrap());
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

/// Enums that recipes extend, and those of motion's and history's that follow from them.
const EXTENDED: [&str; 12] = [
    "Action", "Target", "Change", "Request", "Effect", "Method", "Measure", "Goal", "Intent",
    "Input", "Panel", "Act",
];

/// The `match` blocks of a text that name a variant of an enum in [`EXTENDED`], and have an arm for all others.
fn wildcards(text: &str) -> Vec<String> {
    let text: String = code(text).map(|line| line.to_owned() + "\n").collect();
    let own = EXTENDED.iter().find(|name| text.contains(&format!("impl {name} {{")));
    let mut found = Vec::new();
    for (at, _) in text.match_indices("match ") {
        let Some(open) = text[at..].find('{').map(|open| at + open) else { continue };
        // Several values at once: special cases of them.
        if text[at..].starts_with("match (") {
            continue;
        }
        let (mut depth, mut end) = (0, text.len());
        // The patterns alone: what is in the braces, less what follows an arrow.
        let (mut arms, mut arm) = (vec![String::new()], true);
        for (i, c) in text[open..].char_indices() {
            match c {
                '{' | '(' | '[' => depth += 1,
                '}' | ')' | ']' => depth -= 1,
                _ => {}
            }
            if depth == 0 {
                end = open + i;
                break;
            }
            let ends_arm = depth == 1 && (c == ',' || c == '}');
            if arm && text[open + i..].starts_with("=>") {
                arm = false;
            } else if !arm && ends_arm {
                arm = true;
                arms.push(String::new());
            } else if arm && i > 0 {
                arms.last_mut().unwrap().push(c);
            }
        }
        let is_extended = |arm: &String| {
            let arm = arm.split(" if ").next().unwrap_or_default();
            EXTENDED.iter().any(|name| {
                arm.match_indices(&format!("{name}::"))
                    .any(|(at, _)| !arm[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
            }) || own.is_some() && arm.contains("Self::")
        };
        let takes_all = |arm: &String| {
            let pattern = arm.trim().trim_start_matches(',').trim();
            pattern == "_"
                || pattern.chars().all(|c| c.is_ascii_lowercase() || c == '_')
                    && !pattern.is_empty()
        };
        if arms.iter().any(is_extended) && arms.iter().any(takes_all) {
            found.push(text[at..end].lines().next().unwrap_or_default().trim().to_owned());
        }
    }
    found
}

#[test]
fn no_match_forgets_what_a_recipe_adds() {
    assert_eq!(
        wildcards("match action {\n Action::Push(..) => 1,\n _ => 0,\n}"),
        ["match action {"]
    );
    assert_eq!(wildcards("match a { Action::Push(..) => { 1 } other => 0 }").len(), 1);
    assert!(
        wildcards(
            "match action { Action::Push(..) => 1, Action::Wheel(_) => match x { 1 => 2, _ => 3 } }"
        )
        .is_empty()
    );
    let mut wrong = Vec::new();
    for (path, text) in sources() {
        if in_folder(&path, "crates")
            && !path.ends_with("tests.rs")
            && !in_folder(&path, "crates/motion/benches")
        {
            let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
            wrong.extend(
                wildcards(text).into_iter().map(|line| format!("{}: {line}", path.display())),
            );
        }
    }
    assert!(wrong.is_empty(), "an arm for all others forgets the next one:\n{}", wrong.join("\n"));
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
    let folders = ["assets", "crates", "docs", "examples", "scripts", "shaders", "tests"];
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
