//! Grids, clouds and rings: places, names and draws.

use glam::DVec3;
use pick::Shape;

use crate::parse;

#[test]
fn a_grid_has_columns_along_x_and_rows_along_z_in_x_major_order() {
    let scene = parse(
        "grids: [(kind: cubes, columns: 2, rows: 3, spacing_m: (2, 5), origin_m: (1, 10, -1))]",
    );
    let places: Vec<_> = scene.bodies.iter().map(|body| body.position.to_array()).collect();
    let expected = [[1, -1], [1, 4], [1, 9], [3, -1], [3, 4], [3, 9]]
        .map(|[x, z]| [f64::from(x), 10.0, f64::from(z)]);
    assert_eq!(places, expected);
    assert_eq!(scene.names.get(3).as_deref(), Some("grid.x1.z0"));
    let cube = Shape::Cuboid { half_extents: DVec3::ONE };
    assert!(scene.bodies.iter().all(|body| body.shape == Some(cube) && body.checker));
    assert!(scene.bodies.iter().all(|body| body.inverse_mass == Some(10.0)));
}

#[test]
fn the_same_seed_gives_the_same_bodies_and_another_seed_others() {
    let with = |seed: u64| {
        parse(&format!(
            "seed: {seed}, grids: [(rows: 8, columns: 8)], clouds: [(count: 50, half_extents_m: (1, 1, 1), speed_m_s: 2)]"
        ))
        .bodies
    };
    assert_eq!(with(7), with(7));
    let (some, others) = (with(7), with(8));
    assert_ne!(some[..64], others[..64]);
    assert_ne!(some[64..], others[64..]);
}

#[test]
fn a_cloud_fills_its_box_at_its_speed() {
    let scene = parse(
        "seed: 3, clouds: [(count: 2000, center_m: (5, 0, 0), half_extents_m: (1, 2, 0), speed_m_s: 3, mass_kg: 0.25)]",
    );
    let (mut least, mut most, mut drift) = (DVec3::INFINITY, DVec3::NEG_INFINITY, DVec3::ZERO);
    for body in &scene.bodies {
        assert!((body.velocity.length() - 3.0).abs() < 1e-14);
        assert_eq!((body.shape, body.inverse_mass), (None, Some(4.0)));
        (least, most) = (least.min(body.position), most.max(body.position));
        drift += body.velocity / 2000.0;
    }
    assert!(
        least.cmpge(DVec3::new(4.0, -2.0, 0.0)).all()
            && most.cmple(DVec3::new(6.0, 2.0, 0.0)).all()
    );
    assert!((most - least).length() > 4.4, "{least} {most}");
    // Each component of a random direction has variance 1/3; five standard errors of the mean of 2000.
    assert!(drift.abs().max_element() < 5.0 * 3.0 / (3.0_f64 * 2000.0).sqrt(), "{drift}");
}

#[test]
fn a_cloud_with_a_radius_fills_its_ball() {
    let scene = parse("seed: 3, clouds: [(count: 2000, center_m: (5, 0, 0), radius_m: 2)]");
    let distances =
        scene.bodies.iter().map(|body| body.position.distance(DVec3::new(5.0, 0.0, 0.0)));
    assert!(distances.clone().all(|distance| distance < 2.0));
    // An eighth of the volume lies within half the radius: five standard errors of a count of 2000 are 74.
    let inner = distances.filter(|distance| *distance < 1.0).count();
    assert!((250 - 74..250 + 74).contains(&inner), "{inner}");
}

#[test]
fn the_particles_of_a_ring_are_on_its_circle_and_move_along_it_about_the_axis() {
    let scene = parse(
        "rings: [(count: 12, center_m: (1, 2, 3), radius_m: 2, axis: (0, 3, 4), speed_m_s: 5, mass_kg: 0.5), (count: 1, radius_m: 1)]",
    );
    let (center, axis) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.6, 0.8));
    let ring = &scene.bodies[..12];
    for (body, next) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        let spoke = body.position - center;
        assert!((spoke.length() - 2.0).abs() < 1e-14 && spoke.dot(axis).abs() < 1e-14);
        assert!((body.velocity - 2.5 * axis.cross(spoke)).length() < 1e-13);
        // The next is a twelfth of a turn ahead: sin 30° = 0.5.
        let sine = (next.position - center).dot(body.velocity) / (2.0 * 5.0);
        assert!((sine - 0.5).abs() < 1e-14, "{sine}");
        assert_eq!((body.shape, body.inverse_mass), (None, Some(2.0)));
    }
    assert_eq!(scene.names.iter().skip(11).collect::<Vec<_>>(), ["ring.11", "ring2.0"]);
}

#[test]
fn a_million_particles_are_not_a_million_names() {
    let scene = parse("clouds: [(count: 1000000, half_extents_m: (9, 9, 9), speed_m_s: 1)]");
    assert_eq!(scene.bodies.len(), 1_000_000);
    assert_eq!(scene.names.find("cloud.999999"), Some(999_999));
}
