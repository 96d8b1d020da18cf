//! Ends and lengths of springs, and bodies that may differ; what is refused is in `broken.txt`.

use motion::{Elastic, Method};

use crate::parse;

#[test]
fn a_spring_is_as_long_as_it_is_at_the_start_unless_it_says_otherwise() {
    let scene = parse(
        r#"bodies: [(name: "ship", position_m: (1, 1, 0)), (name: "rock", position_m: (4, 5, 0), immovable: true)],
        springs: [(between: ("ship", "rock"), stiffness_n_m: 50),
                  (between: ("rock", "ship"), stiffness_n_m: 0, damping_n_s_m: 2, rest_length_m: 0, color: (1, 0, 0))]"#,
    );
    let [one, other] = scene.springs[..] else { panic!("{:?}", scene.springs) };
    assert_eq!(one.ends, [0, 1]);
    assert_eq!(
        one.elastic,
        Elastic { stiffness: 50.0, damping: 0.0, rest_length: 5.0, pull_only: false }
    );
    assert_eq!((other.ends, other.color), ([1, 0], [1.0, 0.0, 0.0]));
    assert_eq!(
        other.elastic,
        Elastic { stiffness: 0.0, damping: 2.0, rest_length: 0.0, pull_only: false }
    );
}

#[test]
fn springs_hold_generated_bodies_too() {
    let scene = parse(
        r#"grids: [(rows: 2, columns: 2, spacing_m: (3, 3))], clouds: [(count: 2)],
        soft_bodies: [chain(name: "rope", points: 8, to_m: (7, 0, 0), stiffness_n_m: 1),
                      cloth(name: "flag", rows: 3, columns: 6, along_m: (1, 0, 0), down_m: (0, -1, 0), stiffness_n_m: 1)],
        springs: [(between: ("rope.7", "grid.x1.z0"), stiffness_n_m: 1), (between: ("flag.r2.c5", "cloud.1"), stiffness_n_m: 1)]"#,
    );
    let names: Vec<_> =
        scene.springs.iter().map(|s| s.ends.map(|id| scene.names.get(id).unwrap())).collect();
    assert_eq!(names, [["rope.7", "grid.x1.z0"], ["flag.r2.c5", "cloud.1"]]);
    assert_eq!(scene.springs[0].elastic.rest_length, 4.0);
}

#[test]
fn groups_that_touch_only_in_what_cannot_move_may_differ() {
    let scene = parse(
        r#"method: velocity_verlet, bodies: [(name: "post", immovable: true), (name: "a", method: implicit_euler), (name: "b"), (name: "c", substeps: 7)],
        soft_bodies: [chain(name: "rope", points: 3, to_m: (1, 0, 0), stiffness_n_m: 1, method: runge_kutta_4, pinned: [first])],
        springs: [(between: ("a", "post"), stiffness_n_m: 1), (between: ("post", "b"), stiffness_n_m: 1), (between: ("c", "rope.0"), stiffness_n_m: 1)]"#,
    );
    assert_eq!((scene.springs.len(), scene.bodies[1].method), (3, Some(Method::ImplicitEuler)));
}

#[test]
fn a_method_that_is_the_scenes_by_name_is_no_other() {
    parse(
        r#"method: yoshida_4, substeps: 2, bodies: [(name: "a", method: yoshida_4), (name: "b", substeps: 2)],
        springs: [(between: ("a", "b"), stiffness_n_m: 1)]"#,
    );
}

#[test]
fn mutual_gravity_has_the_real_constant_unless_it_says_otherwise_and_sources_have_their_mass() {
    let scene = parse(
        "mutual_gravity: (), bodies: [(immovable: true, mass_kg: 20), (immovable: true), (mass_kg: 4)]",
    );
    let gravity = scene.mutual_gravity.unwrap();
    assert_eq!((gravity.constant, gravity.softening), (6.674_30e-11, 0.0));
    let sources: Vec<_> =
        scene.bodies.iter().map(|body| (body.inverse_mass, body.source_mass)).collect();
    assert_eq!(sources, [(Some(0.0), Some(20.0)), (Some(0.0), None), (Some(0.25), None)]);
    let gravity =
        parse("mutual_gravity: (constant_m3_kg_s2: -2, softening_m: 0.5)").mutual_gravity.unwrap();
    assert_eq!((gravity.constant, gravity.softening), (-2.0, 0.5));
}
