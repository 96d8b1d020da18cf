//! Keys put into texts of every style.

use glam::DVec3;

use motion::Method;

use super::*;
use crate::answers;
use crate::parts::Part;
use crate::scene::Scene;
use crate::substepping::Substepping;
use crate::text::faults::SceneError;

fn setting((method, substeps): (Method, impl Into<Substepping>)) -> Setting {
    Setting { method, substeps: substeps.into() }
}

/// The text with other methods and substeps. A line of `sets` has the path of an entry or `scene`, a method and substeps; the
/// scene keeps its own if none are given.
fn edited(text: &str, sets: &str) -> Result<String, SceneError> {
    let scene = Scene::parse("t", text)?;
    let entries = scene.entries();
    let (mut common, mut own) = (setting((scene.method, scene.substeps)), Vec::new());
    for set in sets.lines() {
        let [path, method, substeps] = set.split(' ').collect::<Vec<_>>()[..] else {
            panic!("{set}")
        };
        let method = Method::from_name(method).unwrap();
        let setting = setting((method, substeps.parse::<u32>().unwrap()));
        match entries.iter().find(|entry| entry.path() == path) {
            Some(entry) => own.push((entry, setting)),
            None => common = setting,
        }
    }
    scene.with_methods("t", common, &own)
}

/// What an edit makes of a text, or why it cannot be made.
fn outcome(edited: Result<String, SceneError>) -> String {
    edited.unwrap_or_else(|error| error.to_string())
}

#[test]
fn methods_and_substeps_are_written_where_they_stand_or_beside_what_stands() {
    answers("edit/methods.txt", |case| {
        let (sets, text) = case.split_once("\n\n").unwrap();
        outcome(edited(text, sets))
    });
    // Lines that break as on Windows.
    let text = "(\n  version: 1,\n  bodies: [(mass_kg: 2,\n ), ( // soft\n)])";
    let windows = |text: &str| text.replace('\n', "\r\n");
    let sets = "scene implicit_euler 2\nbodies[0] runge_kutta_4 3\nbodies[1] implicit_euler 5";
    assert_eq!(edited(&windows(text), sets).unwrap(), windows(&edited(text, sets).unwrap()));
}

#[test]
fn an_edit_that_would_change_more_is_found_out() {
    let parse = |text: &str| Scene::parse("t", text).unwrap();
    let before = parse("(version: 1, bodies: [(), ()])");
    let common = Setting { method: before.method, substeps: before.substeps };
    let own = Setting { method: Method::Yoshida4, substeps: 1.into() };
    let entries = before.entries();
    let fine = |after: &str| before.differs_only_in(&parse(after), common, &[(&entries[0], own)]);
    assert!(fine("(version: 1,\n bodies: [(method: yoshida_4), ()])"));
    for wrong in [
        "(version: 1, bodies: [(), ()])",
        "(version: 1, bodies: [(method: yoshida_4, substeps: 2), ()])",
        "(version: 1, bodies: [(method: yoshida_4), (method: yoshida_4)])",
        "(version: 1, bodies: [(method: yoshida_4, mass_kg: 2), ()])",
        "(version: 1, method: yoshida_4, bodies: [(), ()])",
    ] {
        assert!(!fine(wrong), "{wrong}");
    }
}

#[test]
fn free_bodies_get_the_scenes_own_keys_unless_mutual_gravity_forbids_it() {
    let text = "(version: 1, bodies: [(name: \"a\"), (method: yoshida_4)],
        soft_bodies: [chain(points: 2, to_m: (1, 0, 0), stiffness_n_m: 1)])";
    let scene = Scene::parse("t", text).unwrap();
    let parts = scene.parts();
    let [euler, symplectic] =
        [(Method::ImplicitEuler, 1), (Method::SemiImplicitEuler, 2)].map(setting);
    let settings: Vec<_> = parts.iter().zip([euler, symplectic]).collect();
    let chosen = |scene: &Scene, settings: &[(&Part, Setting)]| {
        let (common, own) = scene.methods_of_parts(settings);
        (
            common,
            own.into_iter().map(|(entry, setting)| (entry.path(), setting)).collect::<Vec<_>>(),
        )
    };
    let own = [("soft_bodies[0]".to_owned(), euler), ("bodies[1]".to_owned(), symplectic)];
    assert_eq!(chosen(&scene, &settings), (symplectic, own.to_vec()));
    assert_eq!(chosen(&scene, &[]), (setting((scene.method, 1)), Vec::new()));

    let text = "(version: 1, mutual_gravity: (), bodies: [(name: \"a\")],
        emitters: [(rate_per_s: 1, life_s: 1, speed_m_s: 1)])";
    let scene = Scene::parse("t", text).unwrap();
    let parts = scene.parts();
    let fine = setting((Method::RungeKutta4, 1));
    let settings: Vec<_> = parts.iter().zip([fine, euler]).collect();
    let own = vec![("emitters[0]".to_owned(), euler)];
    assert_eq!(chosen(&scene, &settings), (fine, own));
    let (common, own) = scene.methods_of_parts(&settings);
    let edited = Scene::parse("t", &scene.with_methods("t", common, &own).unwrap()).unwrap();
    assert_eq!(edited.bodies[1].method, Some(Method::ImplicitEuler));
}

/// An edit as a line: `add LIST ENTRY`, `remove LIST INDEX` or `set GROUP KEY VALUE`, which removes the key without a value.
fn edit(line: &str) -> TextEdit {
    let mut words = line.splitn(4, ' ');
    let mut word = || words.next().map(str::to_owned);
    let [Some(verb), Some(place)] = [word(), word()] else { panic!("{line}") };
    let rest = line.splitn(3, ' ').last().unwrap();
    match &*verb {
        "add" => TextEdit::add(&place, rest),
        "remove" => TextEdit::Remove { list: place, index: rest.parse().unwrap() },
        _ => TextEdit::Set { group: place, key: word().unwrap(), value: word() },
    }
}

#[test]
fn entries_and_keys_come_and_go_with_their_lines() {
    answers("edit/edits.txt", |case| {
        let (edits, text) = case.split_once("\n\n").unwrap();
        outcome(rewrite("t", text, &edits.lines().map(edit).collect::<Vec<_>>()))
    });
}

fn scene(text: &str) -> Scene {
    Scene::parse("t", text).unwrap_or_else(|error| panic!("{error}"))
}

fn after(scene: &Scene, edits: &[TextEdit]) -> Scene {
    let text = rewrite("t", &scene.text, edits).unwrap_or_else(|error| panic!("{error}"));
    Scene::parse("t", &text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[test]
fn a_grid_and_a_cloud_taken_apart_are_the_same_bodies() {
    let whole = scene(
        "(version: 1, seed: 3, bodies: [()], clouds: [(count: 5, half_extents_m: (1, 2, 3), speed_m_s: 3, mass_kg: 0.3, color: (0.1, 0.7, 0.2))],
        grids: [(kind: mixed, rows: 2, columns: 3, method: yoshida_4, substeps: 2)],
        springs: [(between: (\"cloud.1\", \"cloud.2\"), stiffness_n_m: 1)])",
    );
    let cloud = after(&whole, &whole.apart("clouds[0]"));
    assert_eq!(cloud.bodies[1..6], whole.bodies[7..]);
    assert_eq!(cloud.names.get(2).unwrap(), "cloud-1");
    assert_eq!(cloud.springs[0].ends, [2, 3]);
    let grid = after(&whole, &whole.apart("grids[0]"));
    assert_eq!(grid.bodies[1..7], whole.bodies[1..7]);
    assert!(whole.apart("bodies[0]").is_empty());
}

#[test]
fn fields_are_the_keys_with_what_is_written() {
    // Paths in the first line, and the text.
    answers("edit/fields.txt", |case| {
        let (paths, text) = case.split_once('\n').unwrap();
        let fields = |path| {
            let fields = scene(text).fields(path);
            let value =
                |field: &Field| Some(format!("  {}: {:?}\n", field.key, field.value.as_ref()?));
            let values = fields.iter().filter_map(value).collect::<String>();
            format!("{path:?}: {} keys\n{values}", fields.len())
        };
        paths.split(' ').map(fields).collect()
    });
    let whole = scene("(version: 1, bodies: [()])");
    assert_eq!((whole.count("bodies"), whole.count("springs")), (1, 0));
    for text in ["plain", "a \"b\" \\ c", "two\nlines"] {
        let value = Value::Text(text.to_owned());
        assert_eq!(Value::read(Kind::Text, &value.to_string()), value);
    }
}

/// Scenes after a line such as `without PATH`, `named PATH NAME`, `apart PATH`, `copied PATH X Y Z` or `shifted PATH X Y Z`, with
/// what has own laws and what rides on what.
#[test]
fn what_names_a_body_or_counts_entries_follows_when_entries_come_go_and_are_named() {
    answers("edit/entries.txt", |case| {
        let (changes, text) = case.split_once("\n\n").unwrap();
        let changed = changes.lines().fold(scene(text), |scene, change| {
            let words: Vec<_> = change.split(' ').collect();
            let by = || DVec3::from_slice(&[2, 3, 4].map(|i| words[i].parse().unwrap()));
            let edits = match words[0] {
                "without" => scene.without(words[1]),
                "named" => scene.named(words[1], words[2]),
                "apart" => scene.apart(words[1]),
                "copied" => scene.copied(words[1], by()),
                _ => scene.shifted(words[1], by()),
            };
            after(&scene, &edits)
        });
        let name = |id: u32| changed.names.get(id).unwrap().into_owned();
        let laws = changed.own_laws.iter().map(|(id, laws)| {
            let riding: Vec<_> = laws.riding_wells.iter().map(|well| name(well.rides_on)).collect();
            let (wells, thrusts) = (laws.wells.len(), laws.thrusts.len());
            format!("\n{}: {wells} wells, {thrusts} thrusts, wells on {riding:?}", name(*id))
        });
        let emitters = changed.emitters.iter().map(|emitter| {
            let rides_on = emitter.rides_on.map(name);
            format!("\n{}: on {rides_on:?} at {}", emitter.name, emitter.position)
        });
        changed.text.to_string() + &laws.chain(emitters).collect::<String>()
    });
}
