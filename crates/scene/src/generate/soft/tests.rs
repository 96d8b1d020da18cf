//! Chains, cloths and lattices against formulas; their faults are in `broken.txt`.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use crate::{Scene, SoftBodySpec, answers};

fn parse(text: &str) -> Scene {
    Scene::parse("t", &format!("(version: 1, soft_bodies: [{text}])"))
        .unwrap_or_else(|error| panic!("{error}"))
}

fn positions(scene: &Scene) -> Vec<DVec3> {
    let points = &scene.soft_bodies[0].points;
    scene.bodies[points.start as usize..points.end as usize]
        .iter()
        .map(|body| body.position)
        .collect()
}

/// Checks what holds for every soft body: springs at rest, each pair once, in the order of their points, and the
/// whole `mass`.
fn check(scene: &Scene, mass: f64) -> &SoftBodySpec {
    let (soft, places) = (&scene.soft_bodies[0], positions(scene));
    let mut pairs = HashSet::new();
    for link in soft.links.iter() {
        let [a, b] = link.ends;
        assert!(a < b, "{link:?}");
        assert!(pairs.insert(link.ends), "{link:?} is there twice");
        assert_eq!(link.elastic.rest_length, (places[b as usize] - places[a as usize]).length());
        assert!(link.elastic.rest_length > 0.0);
    }
    assert!(soft.links.is_sorted_by_key(|link| link.ends[0]));
    let count = places.len() as f64;
    for id in soft.points.clone() {
        let body = &scene.bodies[id as usize];
        let inverse_mass = body.inverse_mass.unwrap();
        assert!(inverse_mass == 0.0 || inverse_mass == count / mass, "{inverse_mass}");
    }
    soft
}

fn pinned(scene: &Scene) -> Vec<String> {
    let names = scene.soft_bodies[0].points.clone();
    let pinned = names.filter(|id| scene.bodies[*id as usize].inverse_mass == Some(0.0));
    pinned.map(|id| scene.names.get(id).unwrap().into_owned()).collect()
}

#[test]
fn a_chain_is_as_stiff_as_a_whole_whatever_its_points_are_and_a_cloth_by_its_kinds_of_springs() {
    for points in [2, 5, 40] {
        let scene = parse(&format!(
            "chain(points: {points}, to_m: (1, 0, 0), stiffness_of_whole_n_m: 100)"
        ));
        let softness: f64 =
            scene.soft_bodies[0].links.iter().map(|link| 1.0 / link.elastic.stiffness).sum();
        assert!((softness - 0.01).abs() < 1e-15, "{points} points");
    }
    let scene = parse(
        "cloth(rows: 4, columns: 5, along_m: (4, 0, 0), down_m: (0, -3, 0), stiffness_n_m: 100, shear_n_m: 20, bend: true)",
    );
    for link in scene.soft_bodies[0].links.iter() {
        let stiffness =
            if (link.elastic.rest_length - 2_f64.sqrt()).abs() < 1e-9 { 20.0 } else { 100.0 };
        assert_eq!(link.elastic.stiffness, stiffness, "{link:?}");
    }
    assert_eq!(scene.soft_bodies[0].links.len(), 31 + 24 + 2 * 5 + 3 * 4);
}

#[test]
fn a_chain_joins_neighbors_and_may_be_held_at_its_ends() {
    let scene = parse(
        r#"chain(name: "rope", points: 5, from_m: (1, 10, 0), to_m: (1, 2, 6), mass_kg: 2.5, stiffness_n_m: 100, damping_n_s_m: 3, pinned: [last],
            velocity_m_s: (0, 0, 7), color: (1, 0, 0), damping_per_s: 2, gravity_off: true, method: yoshida_4, substeps: 2)"#,
    );
    let soft = check(&scene, 2.5);
    assert_eq!((soft.name.as_str(), soft.sheet, soft.color), ("rope", false, [1.0, 0.0, 0.0]));
    let ends: Vec<_> = soft.links.iter().map(|link| link.ends).collect();
    assert_eq!(ends, [[0, 1], [1, 2], [2, 3], [3, 4]]);
    assert!(soft.links.iter().all(|link| (link.elastic.rest_length - 2.5).abs() < 1e-15));
    assert!(
        soft.links
            .iter()
            .all(|link| (link.elastic.stiffness, link.elastic.damping) == (100.0, 3.0))
    );
    assert!(soft.triangles.is_empty());
    let places = positions(&scene);
    assert_eq!((places[0], places[2]), (DVec3::new(1.0, 10.0, 0.0), DVec3::new(1.0, 6.0, 3.0)));
    assert_eq!(places[4], DVec3::new(1.0, 2.0, 6.0));
    assert_eq!(pinned(&scene), ["rope.4"]);
    // A pinned point does not move; everything else is as requested.
    let velocities: Vec<_> = scene.bodies.iter().map(|body| body.velocity.z).collect();
    assert_eq!(velocities, [7.0, 7.0, 7.0, 7.0, 0.0]);
    let body = &scene.bodies[1];
    assert_eq!((body.method, body.substeps), (Some(motion::Method::Yoshida4), Some(2.into())));
    assert_eq!(
        (body.damping_rate, body.gravity_off, body.color),
        (Some(2.0), true, [1.0, 0.0, 0.0])
    );
}

#[test]
fn copies_of_a_chain_are_alike_have_roots_and_fill_their_room_evenly() {
    const COPIES: usize = 400;
    let scene = parse(
        r#"chain(name: "grass", points: 4, from_m: (0, -1, 0), to_m: (0, 2, 0), copies: 400, over_m: (8, 0.5, 4), width_m: 0.02,
            stiffness_n_m: 60, bend_n_m: 20, pinned: [root])"#,
    );
    let soft = check(&scene, 1.0);
    assert_eq!(soft.links.len(), COPIES * (3 + 2));
    let stiff = |reach: u32, stiffness: f64| {
        let of = |link: &&motion::Link| link.ends[1] - link.ends[0] == reach;
        soft.links.iter().filter(of).all(|link| link.elastic.stiffness == stiffness)
    };
    assert!(stiff(1, 60.0) && stiff(2, 20.0));
    let blades = soft.blades.unwrap();
    assert_eq!((blades.points, blades.width), (4, 0.02));
    assert_eq!(pinned(&scene)[..3], ["grass.r0.c0", "grass.r0.c1", "grass.r1.c0"]);
    assert_eq!(pinned(&scene).len(), 2 * COPIES);

    let places = positions(&scene);
    assert_eq!(places[0], DVec3::NEG_Y, "the first one is where it was without copies");
    let mut of_cell = [0; 16];
    for blade in places.chunks_exact(4) {
        for (point, place) in (0..).zip(blade) {
            assert!((*place - blade[0] - DVec3::Y * f64::from(point)).length() < 1e-12);
        }
        let root = (blade[0] + DVec3::Y) / DVec3::new(8.0, 0.5, 4.0) + 0.5;
        assert!(root.cmpge(DVec3::ZERO).all() && root.cmplt(DVec3::ONE).all(), "{root}");
        of_cell[(4.0 * root.x) as usize * 4 + (4.0 * root.z) as usize] += 1;
    }
    // Random places would differ by 5 from cell to cell.
    assert!(of_cell.iter().all(|count| (21..=29).contains(count)), "{of_cell:?}");
}

#[test]
fn a_cloth_has_as_many_springs_and_triangles_as_formulas_say() {
    for (rows, columns) in [(2, 2), (2, 5), (7, 2), (3, 3), (6, 9)] {
        for (shear, bend) in [(false, false), (true, false), (false, true), (true, true)] {
            let scene = parse(&format!(
                "cloth(rows: {rows}, columns: {columns}, corner_m: (1, 2, 3), along_m: (3, 0, 0), down_m: (0, -2, 0), mass_kg: 0.5, stiffness_n_m: 1,
                 shear: {shear}, bend: {bend})"
            ));
            let soft = check(&scene, 0.5);
            let (r, c) = (rows as usize, columns as usize);
            let structural = r * (c - 1) + (r - 1) * c;
            let diagonals = if shear { 2 * (r - 1) * (c - 1) } else { 0 };
            let bends = if bend { r * (c - 2) + (r - 2) * c } else { 0 };
            assert_eq!(soft.links.len(), structural + diagonals + bends, "{rows} x {columns}");
            assert_eq!(soft.triangles.len(), 2 * (r - 1) * (c - 1));

            let places = positions(&scene);
            let mut area = DVec3::ZERO;
            for corners in &soft.triangles {
                let [a, b, c] = corners.map(|corner| places[corner as usize]);
                let part = 0.5 * (b - a).cross(c - a);
                assert!(part.z > 0.0, "all of them face the same way");
                area += part;
            }
            assert!((area - DVec3::Z * 6.0).length() < 1e-12, "{area}");
        }
    }
}

#[test]
fn springs_of_a_cloth_reach_next_neighbors_diagonals_and_the_next_but_one() {
    let scene = parse(
        "cloth(rows: 5, columns: 5, along_m: (4, 0, 0), down_m: (0, -4, 0), stiffness_n_m: 1, shear: true, bend: true)",
    );
    let mut reaches: HashMap<(u32, u32), usize> = HashMap::new();
    for link in check(&scene, 1.0).links.iter() {
        let [(r, c), (s, d)] = link.ends.map(|end| (end / 5, end % 5));
        *reaches.entry((r.abs_diff(s), c.abs_diff(d))).or_default() += 1;
    }
    let expected = [((0, 1), 20), ((1, 0), 20), ((1, 1), 32), ((0, 2), 15), ((2, 0), 15)];
    assert_eq!(reaches, HashMap::from(expected));
    // Rows go down from the corner.
    assert_eq!(positions(&scene)[5], DVec3::NEG_Y);
    assert_eq!(scene.names.get(5).unwrap(), "cloth.r1.c0");
}

#[test]
fn a_lattice_has_as_many_springs_and_triangles_as_formulas_say() {
    for cells in [[1, 1, 1], [3, 1, 1], [1, 2, 4], [3, 3, 3]] {
        let [x, y, z] = cells;
        let scene = parse(&format!(
            "lattice(cells: ({x}, {y}, {z}), center_m: (0, 5, 0), size_m: (1, 2, 3), mass_kg: 6, stiffness_n_m: 500, velocity_m_s: (1, 0, 0))"
        ));
        let soft = check(&scene, 6.0);
        assert_eq!(soft.points.len(), (x + 1) * (y + 1) * (z + 1));
        let edges = x * (y + 1) * (z + 1) + (x + 1) * y * (z + 1) + (x + 1) * (y + 1) * z;
        let faces = x * y * (z + 1) + x * (y + 1) * z + (x + 1) * y * z;
        assert_eq!(soft.links.len(), edges + 2 * faces + 4 * x * y * z, "{cells:?}");
        assert_eq!(soft.triangles.len(), 4 * (x * y + y * z + z * x));
        assert!(scene.bodies.iter().all(|body| body.velocity == DVec3::X));
    }
}

#[test]
fn the_surface_of_a_lattice_is_closed_and_faces_outward() {
    let scene = parse(
        "lattice(cells: (2, 3, 4), center_m: (7, -5, 2), size_m: (1, 2, 3), stiffness_n_m: 1)",
    );
    let (soft, places) = (&scene.soft_bodies[0], positions(&scene));
    let mut edges: HashSet<(u32, u32)> = HashSet::new();
    let mut volume = 0.0;
    for corners in &soft.triangles {
        for i in 0..3 {
            assert!(
                edges.insert((corners[i], corners[(i + 1) % 3])),
                "an edge belongs to two of one side"
            );
        }
        let [a, b, c] = corners.map(|corner| places[corner as usize]);
        let normal = (b - a).cross(c - a);
        assert!(normal.dot(a - DVec3::new(7.0, -5.0, 2.0)) > 0.0, "{corners:?} faces inward");
        volume += a.cross(b).dot(c) / 6.0;
    }
    assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))), "there is a hole");
    assert!((volume - 6.0).abs() < 1e-12, "{volume}");
}

#[test]
fn cloths_and_lattices_are_held_where_they_say() {
    answers("generate/soft/held.txt", |text| pinned(&parse(text)).join(" "));
}

#[test]
fn a_large_cloth_is_made_in_a_blink_and_named_on_demand() {
    let scene = parse(
        "cloth(rows: 300, columns: 1000, along_m: (10, 0, 0), down_m: (0, -3, 0), stiffness_n_m: 1, shear: true, bend: true)",
    );
    assert_eq!(scene.bodies.len(), 300_000);
    assert_eq!(scene.names.find("cloth.r299.c999"), Some(299_999));
}
