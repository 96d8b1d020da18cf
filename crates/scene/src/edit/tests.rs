//! Keys put into texts of every style.

use glam::DVec3;

use motion::Method;

use super::*;
use crate::parts::Part;
use crate::scene::Scene;
use crate::text::faults::SceneError;

/// A setting for the entry at a path, or for the scene itself.
type Set = (Option<&'static str>, Setting);

fn set(path: Option<&'static str>, method: Method, substeps: u32) -> Set {
    (path, Setting { method, substeps })
}

fn setting((method, substeps): (Method, u32)) -> Setting {
    Setting { method, substeps }
}

/// The text with these methods and substeps; the scene keeps its own if none are given.
fn edited(text: &str, sets: &[Set]) -> Result<String, SceneError> {
    let scene = Scene::parse("t", text)?;
    let entries = scene.entries();
    let common = sets.iter().find(|(path, _)| path.is_none());
    let common = common.map_or(set(None, scene.method, scene.substeps), |set| *set).1;
    let own = sets.iter().filter_map(|(path, setting)| {
        let entry = entries.iter().find(|entry| Some(&*entry.path()) == *path);
        path.map(|_| (entry.unwrap(), *setting))
    });
    scene.with_methods("t", common, &own.collect::<Vec<_>>())
}

#[track_caller]
fn edits(text: &str, sets: &[Set], expected: &str) {
    let edited = edited(text, sets).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(edited, expected);
}

#[test]
fn values_are_replaced_where_they_stand() {
    edits(
        "(version: 1, method : /* why */ explicit_euler /* this */, substeps: 3 // and so many\n)",
        &[set(None, Method::Yoshida4, 12)],
        "(version: 1, method : /* why */ yoshida_4 /* this */, substeps: 12 // and so many\n)",
    );
    edits(
        "(version: 1, bodies: [(method: \n yoshida_4)], r#substeps: 4)",
        &[set(None, Method::RungeKutta4, 2), set(Some("bodies[0]"), Method::ImplicitEuler, 2)],
        "(version: 1, method: runge_kutta_4, bodies: [(method: \n implicit_euler)], r#substeps: 2)"
            .replace("version: 1, method: runge_kutta_4, ", "version: 1, ")
            .replace("r#substeps: 2", "r#substeps: 2, method: runge_kutta_4")
            .as_str(),
    );
}

#[test]
fn lines_get_lines_and_rows_get_more_of_the_row() {
    let text = "Scene(\n    version: 1,\n    // Of the name.\n    name: \"a, (b: [\", // name\n    bodies: [\n        (name: \"x\", mass_kg: 2),\n        (),\n    ],\n)";
    edits(
        text,
        &[
            set(None, Method::RungeKutta4, 4),
            set(Some("bodies[0]"), Method::Yoshida4, 4),
            set(Some("bodies[1]"), Method::RungeKutta4, 1),
        ],
        "Scene(\n    version: 1,\n    // Of the name.\n    name: \"a, (b: [\", // name\n    method: runge_kutta_4,\n    substeps: 4,\n    bodies: [\n        (name: \"x\", mass_kg: 2, method: yoshida_4),\n        (substeps: 1),\n    ],\n)",
    );
    // A line that breaks as on Windows, an entry over two lines, a comma at the end of a row.
    let text = "(\r\n  version: 1,\r\n  soft_bodies: [chain(points: 2, to_m: (1, 0, 0),\r\n    stiffness_n_m: 1, ), cloth(rows: 2, columns: 2,\r\n along_m: (1, 0, 0), down_m: (0, 1, 0), stiffness_n_m: 1 // soft\r\n)])";
    edits(
        text,
        &[
            set(None, Method::ImplicitEuler, 2),
            set(Some("soft_bodies[0]"), Method::RungeKutta4, 3),
            set(Some("soft_bodies[1]"), Method::ImplicitEuler, 5),
        ],
        "(\r\n  version: 1,\r\n  method: implicit_euler,\r\n  substeps: 2,\r\n  soft_bodies: [chain(points: 2, to_m: (1, 0, 0),\r\n    stiffness_n_m: 1, method: runge_kutta_4, substeps: 3, ), cloth(rows: 2, columns: 2,\r\n along_m: (1, 0, 0), down_m: (0, 1, 0), stiffness_n_m: 1, substeps: 5 // soft\r\n)])",
    );
}

#[test]
fn one_of_the_two_keys_takes_the_other_beside_it() {
    edits(
        "(version: 1,\n    method: yoshida_4, // good\n    seed: 3)",
        &[set(None, Method::Yoshida4, 7)],
        "(version: 1,\n    method: yoshida_4, // good\n    substeps: 7,\n    seed: 3)",
    );
    edits(
        "(version: 1, bodies: [(substeps: 2, mass_kg: 1)])",
        &[set(Some("bodies[0]"), Method::Yoshida4, 2)],
        "(version: 1, bodies: [(substeps: 2, method: yoshida_4, mass_kg: 1)])",
    );
    // A value that holds anyway is not written.
    let text = "(version: 1, method: yoshida_4, bodies: [()])";
    edits(
        text,
        &[set(None, Method::Yoshida4, 1), set(Some("bodies[0]"), Method::Yoshida4, 1)],
        text,
    );
    edits("(version: 1)", &[set(None, Method::default(), 1)], "(version: 1)");
}

#[test]
fn what_cannot_be_written_is_refused() {
    let refused = |text: &str, set| edited(text, &[set]).unwrap_err().to_string();
    let text = "(version: 1, bodies: [(), (verlet_previous_position_m: (1, 0, 0))], method: position_verlet)";
    let error = refused(text, set(Some("bodies[1]"), Method::Yoshida4, 1));
    assert!(error.contains("yoshida_4 knows no previous position"), "{error}");
    assert!(
        refused(text, set(None, Method::PositionVerlet, 0))
            .contains("0 is not a number of substeps")
    );
    assert!(
        refused("(version: 1, bodies: [", set(None, Method::Yoshida4, 1))
            .contains("ends too early")
    );
    let joined = "(version: 1, soft_bodies: [chain(points: 2, to_m: (1, 0, 0), stiffness_n_m: 1)],
        bodies: [(name: \"a\")], springs: [(between: (\"a\", \"chain.1\"), stiffness_n_m: 1)])";
    assert!(refused(joined, set(Some("bodies[0]"), Method::Yoshida4, 1)).contains("of its group"));
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

#[track_caller]
fn rewritten(text: &str, edits: &[TextEdit], expected: &str) {
    let edited = rewrite("t", text, edits).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(edited, expected);
}

fn remove(list: &str, index: usize) -> TextEdit {
    TextEdit::Remove { list: list.to_owned(), index }
}

#[test]
fn entries_come_and_go_with_their_lines() {
    let text = "(\n    version: 1,\n    bodies: [\n        // One.\n        (name: \"a\"), // first\n        (name: \"b\",\n         mass_kg: 2),\n        (name: \"c\")\n    ],\n)";
    rewritten(
        text,
        &[remove("bodies", 1), TextEdit::add("bodies", "(name: \"d\")")],
        "(\n    version: 1,\n    bodies: [\n        // One.\n        (name: \"a\"), // first\n        (name: \"c\"),\n        (name: \"d\"),\n    ],\n)",
    );
    rewritten(
        text,
        &[remove("bodies", 0), remove("bodies", 2)],
        "(\n    version: 1,\n    bodies: [\n        // One.\n        (name: \"b\",\n         mass_kg: 2),\n    ],\n)",
    );
    rewritten(
        text,
        &[TextEdit::add("springs", "(x: 1)"), TextEdit::add("springs", "(x: 2)")],
        &text.replace(
            "    ],\n)",
            "    ],\n    springs: [\n        (x: 1),\n        (x: 2),\n    ],\n)",
        ),
    );
    let row = "(version: 1, bodies: [(), (mass_kg: 1), ()])";
    rewritten(row, &[remove("bodies", 0)], "(version: 1, bodies: [(mass_kg: 1), ()])");
    rewritten(row, &[remove("bodies", 2)], "(version: 1, bodies: [(), (mass_kg: 1)])");
    rewritten(
        row,
        &[remove("bodies", 0), remove("bodies", 1), remove("bodies", 2)],
        "(version: 1, bodies: [])",
    );
    rewritten(
        row,
        &[
            remove("bodies", 0),
            remove("bodies", 1),
            remove("bodies", 2),
            TextEdit::add("bodies", "(mass_kg: 3)"),
        ],
        "(version: 1, bodies: [(mass_kg: 3)])",
    );
    rewritten(
        row,
        &[
            remove("bodies", 2),
            TextEdit::add("bodies", "(mass_kg: 3)"),
            TextEdit::set("bodies[2]", "mass_kg", "4"),
        ],
        "(version: 1, bodies: [(), (mass_kg: 1), (mass_kg: 3)])",
    );
    rewritten(
        row,
        &[TextEdit::add("grids", "()")],
        "(version: 1, bodies: [(), (mass_kg: 1), ()], grids: [()])",
    );
    rewritten(
        "(version: 1, bodies: [])",
        &[TextEdit::add("bodies", "()")],
        "(version: 1, bodies: [\n    (),\n])",
    );
    rewritten(
        "(version: 1, bodies: [ // none yet\n])",
        &[TextEdit::add("bodies", "()")],
        "(version: 1, bodies: [ // none yet\n    (),\n])",
    );
}

#[test]
fn keys_come_and_go() {
    let text = "(version: 1, bodies: [(shape: sphere(radius_m: 1), mass_kg: 2), ()])";
    rewritten(
        text,
        &[
            TextEdit::set("bodies[0].shape", "radius_m", "3.0"),
            TextEdit::Set { group: "bodies[0]".to_owned(), key: "mass_kg".to_owned(), value: None },
            TextEdit::set("bodies[1]", "name", "\"b\""),
            TextEdit::set("bodies[1]", "mass_kg", "4.0"),
            TextEdit::set("", "seed", "3"),
        ],
        "(version: 1, bodies: [(shape: sphere(radius_m: 3.0)), (name: \"b\", mass_kg: 4.0)], seed: 3)",
    );
    let gone =
        TextEdit::Set { group: "bodies[1]".to_owned(), key: "mass_kg".to_owned(), value: None };
    for (edit, path) in [
        (gone, "bodies[1].mass_kg"),
        (TextEdit::set("bodies[2]", "mass_kg", "1"), "bodies[2]"),
        (TextEdit::set("gravity", "on_at_start", "true"), "gravity"),
        (remove("bodies", 2), "bodies[2]"),
        (remove("springs", 0), "springs[0]"),
    ] {
        let error = rewrite("t", text, &[edit]).unwrap_err().to_string();
        assert!(error.starts_with(&format!("t: {path}: there is no such")), "{error}");
    }
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
