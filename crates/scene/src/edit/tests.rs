//! Keys put into texts of every style.

use glam::DVec3;

use motion::Method;

use super::*;
use crate::answers;
use crate::parts::Part;
use crate::scene::Scene;
use crate::text::faults::SceneError;

/// The text with other methods and substeps. A line of `sets` has the path of an entry or `scene`, a method and substeps; the
/// scene keeps its own if none are given.
fn edited(text: &str, sets: &str) -> Result<String, SceneError> {
    let scene = Scene::parse("t", text)?;
    let entries = scene.entries();
    let common = Setting { method: scene.method, substeps: scene.substeps };
    let (mut common, mut own) = (common, Vec::new());
    for set in sets.lines() {
        let [path, method, substeps] = set.split(' ').collect::<Vec<_>>()[..] else {
            panic!("{set}")
        };
        let method = Method::from_name(method).unwrap();
        let setting = Setting { method, substeps: substeps.parse().unwrap() };
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
    let own = Setting { method: Method::Yoshida4, substeps: 1 };
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
fn names_that_count_entries_follow_when_an_entry_goes() {
    let whole = scene(
        "(version: 1, bodies: [(), (), (position_m: (1, 0, 0))],
        grids: [(rows: 1, columns: 1), (rows: 1, columns: 2)],
        soft_bodies: [chain(points: 2, to_m: (0, 1, 0), stiffness_n_m: 1), cloth(rows: 2, columns: 2, along_m: (1, 0, 0),
            down_m: (0, -1, 0), stiffness_n_m: 1), chain(points: 2, to_m: (0, 1, 0), stiffness_n_m: 1)],
        springs: [(between: (\"body.0\", \"body.2\"), stiffness_n_m: 1), (between: (\"body.2\", \"grid2.x1.z0\"), stiffness_n_m: 2),
            (between: (\"chain.0\", \"chain2.1\"), stiffness_n_m: 3)],
        thrusts: [(body: \"body.0\", curve: polynomial([(1, 0, 0)]))],
        wells: [(strength_m3_s2: 1, softening_m: 1, bodies: [\"body.0\", \"body.1\"]), (strength_m3_s2: 1, softening_m: 1, bodies: [\"body.0\"])])",
    );
    let ends = |scene: &Scene| -> Vec<_> {
        scene
            .springs
            .iter()
            .map(|spring| spring.ends.map(|end| scene.names.get(end).unwrap().into_owned()))
            .collect()
    };
    let without = after(&whole, &whole.without("bodies[0]"));
    assert_eq!(ends(&without), [["body.1", "grid2.x1.z0"], ["chain.0", "chain2.1"]]);
    assert_eq!(
        without.own_laws.keys().copied().collect::<Vec<_>>(),
        [0],
        "the well of the second body"
    );
    assert!(without.own_laws[&0].thrusts.is_empty());
    let without = after(&whole, &whole.without("grids[0]"));
    assert_eq!(ends(&without)[1], ["body.2", "grid.x1.z0"]);
    let without = after(&whole, &whole.without("soft_bodies[1]"));
    assert_eq!(ends(&without)[2], ["chain.0", "chain2.1"], "a cloth counts no chains");
    let without = after(&whole, &whole.without("soft_bodies[0]"));
    assert_eq!(ends(&without), ends(&whole)[..2]);
    let named = after(&whole, &whole.named("bodies[0]", "hook"));
    assert_eq!(ends(&named)[0], ["hook", "body.2"]);
    assert_eq!(
        ends(&after(&named, &named.without("bodies[0]"))),
        ends(&after(&whole, &whole.without("bodies[0]")))
    );
    let named = after(&whole, &whole.named("grids[1]", "row"));
    assert_eq!(ends(&named)[1], ["body.2", "row.x1.z0"]);
    let named = after(&whole, &whole.named("bodies[2]", "ball"));
    assert_eq!(ends(&named)[..2], [["body.0", "ball"], ["ball", "grid2.x1.z0"]]);
}

#[test]
fn survival_scripts_follow_the_names_of_their_bodies() {
    let whole = scene(
        "(version: 1, bodies: [(), (), (name: \"ship\")], expect: (survival: (measure: energy, scale_j: 1, ticks: 10, bounded_below: 1,
            script: [(at_tick: 1, do: push(\"body.0\", (1, 0, 0))), (at_tick: 2, do: remove(\"ship\"))],
            rows: [(label: \"own\", script: [(at_tick: 3, do: remove(\"body.1\")) /* the last */]), (label: \"all\")])))",
    );
    let bodies = |scene: &Scene| -> Vec<Vec<String>> {
        let rows = scene.survival.as_ref().unwrap().iter();
        rows.map(|row| {
            row.script.iter().filter_map(|step| step.action.body().map(str::to_owned)).collect()
        })
        .collect()
    };
    assert_eq!(bodies(&whole), [vec!["body.1"], vec!["body.0", "ship"]]);
    let named = after(&whole, &whole.named("bodies[2]", "boat"));
    assert_eq!(bodies(&named), [vec!["body.1"], vec!["body.0", "boat"]]);
    assert!(named.text.contains("remove(\"body.1\")) /* the last */"));
    let without = after(&whole, &whole.without("bodies[0]"));
    assert_eq!(bodies(&without), [vec!["body.0"], vec!["ship"]]);
    let without = after(&whole, &whole.without("bodies[1]"));
    assert_eq!(bodies(&without), [vec![], vec!["body.0", "ship"]]);
}

#[test]
fn a_copy_stands_beside_and_has_its_own_name() {
    let whole = scene(
        "(version: 1, bodies: [(name: \"ball\", position_m: (1, 2, 3), mass_kg: 2)],
        soft_bodies: [chain(name: \"rope\", points: 2, to_m: (0, 1, 0), stiffness_n_m: 1)])",
    );
    let copied = after(&whole, &whole.copied("bodies[0]", DVec3::X));
    assert_eq!(copied.bodies[1].position, DVec3::new(2.0, 2.0, 3.0));
    assert_eq!(
        (copied.names.get(1).unwrap(), copied.bodies[1].inverse_mass),
        ("ball2".into(), Some(0.5))
    );
    let copied = after(&whole, &whole.copied("soft_bodies[0]", DVec3::Z));
    assert_eq!(copied.names.get(3).unwrap(), "rope2.0");
    assert_eq!(
        (copied.bodies[3].position, copied.bodies[4].position),
        (DVec3::Z, DVec3::new(0.0, 1.0, 1.0))
    );
    let shifted = after(&whole, &whole.shifted("bodies[0]", DVec3::NEG_Y));
    assert_eq!(shifted.bodies[0].position, DVec3::new(1.0, 1.0, 3.0));
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
fn a_group_that_a_well_names_is_followed() {
    let whole = scene(
        "(version: 1, bodies: [(name: \"a\")], grids: [(rows: 1, columns: 2), (rows: 1, columns: 2)],
        wells: [(strength_m3_s2: 1, bodies: [\"a\", \"grid2\"])])",
    );
    let attracted = |scene: &Scene| scene.own_laws.keys().copied().collect::<Vec<_>>();
    assert_eq!(attracted(&whole), [0, 3, 4]);
    assert_eq!(attracted(&after(&whole, &whole.named("grids[1]", "wall"))), [0, 3, 4]);
    assert_eq!(attracted(&after(&whole, &whole.without("grids[0]"))), [0, 1, 2]);
    assert_eq!(attracted(&after(&whole, &whole.without("grids[1]"))), [0]);
    // The bodies of the second grid come before those of the first.
    assert_eq!(attracted(&after(&whole, &whole.apart("grids[1]"))), [0, 1, 2]);
}

#[test]
fn fields_are_the_keys_with_what_is_written() {
    let whole = scene(
        "(version: 1, gravity: (), bodies: [(name: \"ab\", shape: sphere(radius_m: 1.5), mass_kg: 2, position_m: (1, -2, 3e2))])",
    );
    let field = |path: &str, key: &str| {
        whole.fields(path).into_iter().find(|field| field.key == key).and_then(|field| field.value)
    };
    assert_eq!(field("bodies[0]", "name"), Some(Value::Text("ab".to_owned())));
    assert_eq!(field("bodies[0]", "mass_kg"), Some(Value::Number(2.0)));
    assert_eq!(field("bodies[0]", "position_m"), Some(Value::Numbers(vec![1.0, -2.0, 300.0])));
    assert_eq!(
        field("bodies[0]", "shape"),
        Some(Value::Written("sphere(radius_m: 1.5)".to_owned()))
    );
    assert_eq!(field("bodies[0].shape", "radius_m"), Some(Value::Number(1.5)));
    assert_eq!(field("bodies[0]", "immovable"), None);
    assert_eq!(field("", "version"), Some(Value::Count(1)));
    assert_eq!(whole.fields("gravity").len(), 2);
    assert!(whole.fields("damping").is_empty());
    assert_eq!((whole.count("bodies"), whole.count("springs")), (1, 0));
    for text in ["plain", "a \"b\" \\ c", "two\nlines"] {
        let value = Value::Text(text.to_owned());
        assert_eq!(Value::read(Kind::Text, &value.to_string()), value);
    }
}

#[test]
fn what_rides_on_a_body_follows_its_name_and_stays_where_it_began() {
    let text = "(version: 1,
        bodies: [(name: \"comet\", position_m: (1, 2, 3)), (name: \"planet\"), (name: \"moon\")],
        emitters: [(name: \"dust\", rides_on: \"comet\", position_m: (0, 1, 0), rate_per_s: 1, life_s: 2, speed_m_s: 1)],
        wells: [(rides_on: \"planet\", strength_m3_s2: 1, bodies: [\"moon\", \"dust\"])])";
    let whole = scene(text);
    let well = |scene: &Scene| -> Vec<(u32, u32)> {
        let riding = |(id, laws): (&u32, &crate::OwnLawsSpec)| {
            let carriers: Vec<_> =
                laws.riding_wells.iter().map(|well| (*id, well.rides_on)).collect();
            carriers
        };
        scene.own_laws.iter().flat_map(riding).collect()
    };
    // The moon, and two particles.
    assert_eq!(well(&whole), [(2, 1), (3, 1), (4, 1)]);
    for (path, name) in [("bodies[0]", "rock"), ("bodies[1]", "rock"), ("emitters[0]", "jet")] {
        let named = after(&whole, &whole.named(path, name));
        assert_eq!((well(&named), named.emitters[0].rides_on), (well(&whole), Some(0)), "{path}");
    }
    let without = after(&whole, &whole.without("bodies[0]"));
    let emitter = &without.emitters[0];
    assert_eq!((emitter.rides_on, emitter.position), (None, DVec3::new(1.0, 3.0, 3.0)));
    assert_eq!(well(&without).len(), 3);
    let without = after(&whole, &whole.without("bodies[1]"));
    assert_eq!((well(&without), without.emitters[0].rides_on), (vec![], Some(0)));
    let without = after(&whole, &whole.without("emitters[0]"));
    assert_eq!(well(&without), [(2, 1)]);
    // Names that count: the planet becomes the first of all.
    let unnamed =
        scene(&text.replace("(name: \"planet\")", "()").replace("\"planet\"", "\"body.1\""));
    assert_eq!(well(&unnamed), well(&whole));
    let without = after(&unnamed, &unnamed.without("bodies[0]"));
    assert_eq!(well(&without), [(1, 0), (2, 0), (3, 0)]);
}
