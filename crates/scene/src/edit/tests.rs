//! Keys put into texts of every style.

use super::*;

fn set(path: Option<&str>, method: Method, substeps: u32) -> Change {
    Change { path: path.map(str::to_owned), method, substeps }
}

#[track_caller]
fn edits(text: &str, changes: &[Change], expected: &str) {
    let edited = edit("t", text, changes).unwrap_or_else(|error| panic!("{error}"));
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
    // What holds anyway is not written.
    let text = "(version: 1, method: yoshida_4, bodies: [()])";
    edits(text, &[set(None, Method::Yoshida4, 1), set(Some("bodies[0]"), Method::Yoshida4, 1)], text);
    edits("(version: 1)", &[set(None, Method::default(), 1)], "(version: 1)");
}

#[test]
fn what_cannot_be_written_is_refused() {
    let refused = |text: &str, change| edit("t", text, &[change]).unwrap_err().to_string();
    let text = "(version: 1, bodies: [(), (verlet_previous_position_m: (1, 0, 0))], method: position_verlet)";
    for path in ["bodies[2]", "soft_bodies[0]", "springs[0]", "bodies", "bodies[0].mass_kg"] {
        assert_eq!(
            refused(text, set(Some(path), Method::Yoshida4, 1)),
            format!(
                "t: {path}: there is no such entry; give the path of a body, a grid, a cloud, an emitter or a soft body"
            )
        );
    }
    let error = refused(text, set(Some("bodies[1]"), Method::Yoshida4, 1));
    assert!(error.contains("yoshida_4 knows no previous position"), "{error}");
    assert!(refused(text, set(None, Method::PositionVerlet, 0)).contains("0 is not a number of substeps"));
    assert!(refused("(version: 1, bodies: [", set(None, Method::Yoshida4, 1)).contains("ends too early"));
    let joined = "(version: 1, soft_bodies: [chain(points: 2, to_m: (1, 0, 0), stiffness_n_m: 1)],
        bodies: [(name: \"a\")], springs: [(between: (\"a\", \"chain.1\"), stiffness_n_m: 1)])";
    assert!(refused(joined, set(Some("bodies[0]"), Method::Yoshida4, 1)).contains("of its group"));
}

#[test]
fn an_edit_that_would_change_more_is_found_out() {
    let parse = |text: &str| Scene::parse("t", text).unwrap();
    let before = parse("(version: 1, bodies: [(), ()])");
    let changes = [set(Some("bodies[0]"), Method::Yoshida4, 1)];
    let entries = [before.entries().first().cloned()];
    let result = |after: &str| check("t", before.clone(), parse(after), &changes, &entries);
    assert_eq!(result("(version: 1,\n bodies: [(method: yoshida_4), ()])"), Ok(()));
    for wrong in [
        "(version: 1, bodies: [(), ()])",
        "(version: 1, bodies: [(method: yoshida_4, substeps: 2), ()])",
        "(version: 1, bodies: [(method: yoshida_4), (method: yoshida_4)])",
        "(version: 1, bodies: [(method: yoshida_4, mass_kg: 2), ()])",
        "(version: 1, method: yoshida_4, bodies: [(), ()])",
    ] {
        assert!(result(wrong).unwrap_err().to_string().contains("by hand"), "{wrong}");
    }
}

#[test]
fn free_bodies_get_the_scenes_own_keys_unless_mutual_gravity_forbids_it() {
    let text = "(version: 1, bodies: [(name: \"a\"), (method: yoshida_4)],
        soft_bodies: [chain(points: 2, to_m: (1, 0, 0), stiffness_n_m: 1)])";
    let scene = Scene::parse("t", text).unwrap();
    let parts = scene.parts();
    let settings: Vec<_> =
        parts.iter().zip([(Method::ImplicitEuler, 1), (Method::SemiImplicitEuler, 2)]).collect();
    let expected = [
        set(None, Method::SemiImplicitEuler, 2),
        set(Some("soft_bodies[0]"), Method::ImplicitEuler, 1),
        set(Some("bodies[1]"), Method::SemiImplicitEuler, 2),
    ];
    assert_eq!(changes(&scene, &settings), expected);
    assert_eq!(changes(&scene, &[]), [set(None, scene.method, 1)]);

    let text = "(version: 1, mutual_gravity: (), bodies: [(name: \"a\")],
        emitters: [(rate_per_s: 1, life_s: 1, speed_m_s: 1)])";
    let scene = Scene::parse("t", text).unwrap();
    let parts = scene.parts();
    let settings: Vec<_> = parts.iter().zip([(Method::RungeKutta4, 1), (Method::ImplicitEuler, 1)]).collect();
    let changes = changes(&scene, &settings);
    let expected = [set(None, Method::RungeKutta4, 1), set(Some("emitters[0]"), Method::ImplicitEuler, 1)];
    assert_eq!(changes, expected);
    let edited = Scene::parse("t", &edit("t", text, &changes).unwrap()).unwrap();
    assert_eq!(edited.bodies[1].method, Some(Method::ImplicitEuler));
}
