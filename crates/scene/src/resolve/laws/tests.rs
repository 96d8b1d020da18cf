//! Values and defaults of the laws; their faults are in `broken.txt`.

use super::*;
use crate::parse;

#[test]
fn drag_has_the_coefficient_that_is_given_and_no_other() {
    let drag = |text| parse(&format!("drag: ({text})")).laws.drag;
    assert_eq!(drag("linear_per_s: 0.5"), Some(Drag::new(0.5, 0.0)));
    assert_eq!(drag("quadratic_per_m: 2"), Some(Drag::new(0.0, 2.0)));
    assert_eq!(drag("linear_per_s: 0"), Some(Drag::new(0.0, 0.0)));
    assert_eq!(parse("").laws.drag, None);
}

#[test]
fn a_well_is_at_the_origin_and_hard_unless_it_says_otherwise() {
    let scene = parse(
        "wells: [(strength_m3_s2: 2), (strength_m3_s2: -1, position_m: (1, 2, 3), softening_m: 0.5)]",
    );
    let expected = [
        Well { position: DVec3::ZERO, strength: 2.0, softening: 0.0 },
        Well { position: DVec3::new(1.0, 2.0, 3.0), strength: -1.0, softening: 0.5 },
    ];
    assert_eq!(scene.laws.wells.unwrap().0, expected);
    assert!(scene.own_laws.is_empty());
}

#[test]
fn a_well_that_names_bodies_is_theirs_alone() {
    let scene = parse(
        r#"bodies: [(name: "a"), (name: "b")], grids: [(rows: 2, columns: 2)],
        wells: [(strength_m3_s2: 1), (strength_m3_s2: 2, bodies: ["b", "grid.x1.z0"]), (strength_m3_s2: 3, bodies: ["b"])]"#,
    );
    let strengths = |wells: &[Well]| wells.iter().map(|well| well.strength).collect::<Vec<_>>();
    assert_eq!(strengths(&scene.laws.wells.unwrap().0), [1.0]);
    let own: Vec<_> =
        scene.own_laws.iter().map(|(id, laws)| (*id, strengths(&laws.wells))).collect();
    assert_eq!(own, [(1, vec![2.0, 3.0]), (4, vec![2.0])]);
    assert_eq!(scene.names.get(4).as_deref(), Some("grid.x1.z0"));
}

#[test]
fn a_well_that_names_an_entry_attracts_its_bodies_that_can_move_but_not_the_one_it_rides_on() {
    let scene = parse(
        r#"bodies: [(name: "a"), (name: "cloud")], grids: [(rows: 1, columns: 2)], clouds: [(count: 2)], rings: [(count: 2, radius_m: 1)],
        soft_bodies: [chain(name: "rope", points: 3, to_m: (1, 0, 0), stiffness_n_m: 1, pinned: [first])],
        wells: [(strength_m3_s2: 1, bodies: ["a", "ring", "rope"]), (rides_on: "grid.x0.z0", strength_m3_s2: 2, bodies: ["grid", "cloud"])]"#,
    );
    let own: Vec<_> = scene
        .own_laws
        .iter()
        .map(|(id, laws)| (*id, laws.wells.len(), laws.riding_wells.len()))
        .collect();
    // A body of that name comes before the entry. The first point of the rope is pinned.
    assert_eq!(own, [(0, 1, 0), (1, 0, 1), (3, 0, 1), (6, 1, 0), (7, 1, 0), (9, 1, 0), (10, 1, 0)]);
}

#[test]
fn thrusts_go_to_their_bodies_in_the_order_of_the_file() {
    let scene = parse(
        r#"bodies: [(name: "a"), (name: "ship")], clouds: [(count: 3)], thrusts: [
            (body: "ship", curve: polynomial([(1, 2, 3), (4, 5, 6)]), from_s: 1, until_s: 2),
            (body: "cloud.2", curve: sine(amplitude_n: (0, 1, 0), angular_frequency_rad_s: 3)),
            (body: "ship", curve: table([(0.5, (1, 0, 0)), (1, (2, 0, 0))]), from_s: -inf, until_s: inf),
        ]"#,
    );
    let (x, y) = (DVec3::X, DVec3::Y);
    let polynomial = Curve::Polynomial(vec![DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)]);
    let sine = Curve::Sine { amplitude: y, angular_frequency: 3.0, phase: 0.0 };
    let table = Curve::Table(vec![(0.5, x), (1.0, 2.0 * x)]);
    let always = |curve| Thrust::new(curve, f64::NEG_INFINITY, f64::INFINITY);
    let ids: Vec<u32> = scene.own_laws.keys().copied().collect();
    assert_eq!(ids, [1, 4]);
    assert_eq!(scene.own_laws[&1].thrusts, [Thrust::new(polynomial, 1.0, 2.0), always(table)]);
    assert_eq!(scene.own_laws[&4].thrusts, [always(sine)]);
}

#[test]
fn wind_is_what_drag_sees() {
    let wind = |text| {
        parse(&format!("drag: (linear_per_s: 1), wind: ({text})")).laws.drag.unwrap().wind.unwrap()
    };
    let x = DVec3::X;
    assert_eq!(wind("velocity_m_s: (1, 0, 0)"), Wind { velocity: x, gust: 0.0, gust_hz: 0.0 });
    let gusty = Wind { velocity: x, gust: 2.0, gust_hz: 0.5 };
    assert_eq!(wind("velocity_m_s: (1, 0, 0), gust_m_s: 2, gust_hz: 0.5"), gusty);
    assert_eq!(parse("drag: (linear_per_s: 1)").laws.drag.unwrap().wind, None);
}
