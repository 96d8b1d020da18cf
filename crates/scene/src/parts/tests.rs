//! Which bodies are a part, and what goes with them.

use super::*;

fn parts(text: &str) -> Vec<Part> {
    Scene::parse("t", text).unwrap_or_else(|error| panic!("{error}")).parts()
}

fn shape(parts: &[Part]) -> Vec<(&str, &[u32], Vec<String>)> {
    let paths = |part: &Part| part.entries.iter().map(Entry::path).collect();
    parts.iter().map(|part| (part.name.as_str(), &part.bodies[..], paths(part))).collect()
}

const MANY: &str = r#"(version: 1, gravity: (), thrusts: [(body: "loose", curve: polynomial([(1, 0, 0)]))],
    wells: [(strength_m3_s2: 1, bodies: ["a", "loose"])],
    bodies: [
        (name: "floor", immovable: true),
        (name: "post", immovable: true, position_m: (0, 1, 0)),
        (name: "a", position_m: (1, 1, 0), label: "first"),
        (name: "loose", label: "free", locked_axes: [z]),
        (name: "b", position_m: (2, 1, 0)),
        (name: "wall", shape: sphere(radius_m: 1), scenery: true),
        (name: "c", position_m: (3, 1, 0)),
    ],
    clouds: [(count: 3)],
    emitters: [(rate_per_s: 2, life_s: 1, speed_m_s: 1)],
    springs: [
        (between: ("a", "post"), stiffness_n_m: 1),
        (between: ("b", "post"), stiffness_n_m: 2),
        (between: ("rope.2", "c"), stiffness_n_m: 3),
    ],
    soft_bodies: [
        chain(name: "thread", points: 2, to_m: (2, 0, 0), stiffness_n_m: 5),
        chain(name: "rope", points: 3, to_m: (2, 0, 0), stiffness_n_m: 4, pinned: [first]),
    ])"#;

#[test]
fn springs_join_what_moves_and_take_what_holds_along() {
    let parts = parts(MANY);
    let entries = |paths: &[&str]| paths.iter().map(|path| (*path).to_owned()).collect::<Vec<_>>();
    let expected: [(_, &[u32], _); 5] = [
        ("a", &[1, 2], entries(&["bodies[2]"])),
        ("b", &[1, 4], entries(&["bodies[4]"])),
        ("rope", &[6, 14, 15, 16], entries(&["bodies[6]", "soft_bodies[1]"])),
        ("thread", &[12, 13], entries(&["soft_bodies[0]"])),
        ("free bodies", &[3, 7, 8, 9, 10, 11], entries(&["bodies[3]", "clouds[0]", "emitters[0]"])),
    ];
    assert_eq!(shape(&parts), expected);

    let [a, _, rope, thread, free] = &parts[..] else { panic!("five") };
    assert_eq!(rope.scene.names.iter().collect::<Vec<_>>(), ["c", "rope.0", "rope.1", "rope.2"]);
    assert_eq!(rope.scene.springs.iter().map(|spring| spring.ends).collect::<Vec<_>>(), [[3, 0]]);
    assert_eq!(rope.scene.soft_bodies[0].points, 1..4);
    assert_eq!((thread.scene.soft_bodies[0].points.clone(), thread.scene.springs.len()), (0..2, 0));
    assert_eq!(a.scene.labels, [(1, "first".to_owned())]);
    assert_eq!(a.scene.own_laws.keys().copied().collect::<Vec<_>>(), [1]);
    let effects =
        |part: &Part| part.scene.declared.iter().map(|found| found.effect).collect::<Vec<_>>();
    assert_eq!(effects(a), [Effect::Gravity, Effect::Wells, Effect::Springs]);
    assert_eq!(effects(rope), [Effect::Gravity, Effect::Springs]);
    let of_free =
        [Effect::Gravity, Effect::Wells, Effect::Thrusts, Effect::AxisLocks, Effect::Emitters];
    assert_eq!(effects(free), of_free);
    assert_eq!(
        (free.scene.emitters[0].pool.clone(), free.scene.names.find("emitter.1")),
        (4..6, Some(5))
    );
    assert!(free.scene.springs.is_empty() && free.scene.soft_bodies.is_empty());
}

#[test]
fn an_entry_is_never_divided() {
    let parts = parts(
        "(version: 1, bodies: [(name: \"a\", position_m: (9, 0, 0))], grids: [(rows: 1, columns: 3)],
          clouds: [(count: 2)], springs: [(between: (\"a\", \"grid.x1.z0\"), stiffness_n_m: 1)])",
    );
    let expected: [(_, &[u32], _); 2] = [
        ("a and 3 more", &[0, 1, 2, 3], vec!["bodies[0]".to_owned(), "grids[0]".to_owned()]),
        ("free bodies", &[4, 5], vec!["clouds[0]".to_owned()]),
    ];
    assert_eq!(shape(&parts), expected);
    assert_eq!(parts[0].scene.names.find("grid.x2.z0"), Some(3));
}

#[test]
fn mutual_gravity_joins_everything_but_particles() {
    let parts = parts(
        "(version: 1, mutual_gravity: (), bodies: [(name: \"a\"), (name: \"rock\", immovable: true),
          (name: \"sun\", immovable: true, mass_kg: 5), (name: \"b\", position_m: (1, 0, 0))],
          emitters: [(rate_per_s: 2, life_s: 1, speed_m_s: 1, method: implicit_euler)])",
    );
    let shapes: Vec<_> =
        shape(&parts).into_iter().map(|(name, bodies, _)| (name, bodies)).collect();
    assert_eq!(shapes, [("a and 1 more", &[0, 2, 3][..]), ("free bodies", &[4, 5])]);
    assert!(parts[0].scene.mutual_gravity.is_some() && parts[1].scene.mutual_gravity.is_none());
    assert_eq!(parts[1].scene.method, motion::Method::ImplicitEuler);
    assert_eq!(parts[1].scene.bodies[0].method, None);
}

#[test]
fn what_moves_alike_has_its_setting_as_that_of_the_scene() {
    let parts =
        parts("(version: 1, substeps: 3, bodies: [(method: yoshida_4), (method: yoshida_4)])");
    assert_eq!((parts[0].scene.method, parts[0].scene.substeps), (motion::Method::Yoshida4, 3));
    assert!(parts[0].scene.bodies.iter().all(|body| body.method.is_none()));
    let parts = self::parts("(version: 1, bodies: [(method: yoshida_4), ()])");
    assert_eq!(parts[0].scene.bodies[0].method, Some(motion::Method::Yoshida4));
    assert_eq!(parts[0].scene.method, motion::Method::default());
}

#[test]
fn what_cannot_move_is_no_part() {
    assert!(parts("(version: 1)").is_empty());
    assert!(
        parts(
            "(version: 1, bodies: [(immovable: true), (shape: sphere(radius_m: 1), scenery: true)])"
        )
        .is_empty()
    );
}
