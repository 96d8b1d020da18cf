//! Pools and launches; faults are in `broken.txt`.

use glam::DVec3;

use crate::{EmitterSpec, parse};

fn emitter(keys: &str) -> EmitterSpec {
    parse(&format!("emitters: [({keys})]")).emitters.remove(0)
}

#[test]
fn a_pool_waits_at_rest_at_its_emitter() {
    let scene = parse(
        r#"bodies: [()], emitters: [(name: "fountain", rate_per_s: 500, position_m: (1, 2, 3), speed_m_s: 12, life_s: 3, capacity: 20, radius_m: 0.01, mass_kg: 0.25,
            color: (0, 0, 1), method: runge_kutta_4, substeps: 2)]"#,
    );
    let emitter = &scene.emitters[0];
    assert_eq!((emitter.name.as_str(), emitter.rate, emitter.life), ("fountain", 500.0, 3.0));
    assert_eq!((emitter.pool.clone(), emitter.launches.len()), (1..21, 20));
    assert_eq!((emitter.position, emitter.inverse_mass), (DVec3::new(1.0, 2.0, 3.0), 4.0));
    assert_eq!(emitter.radius, 0.01);
    for body in &scene.bodies[1..] {
        assert_eq!((body.position, body.velocity), (emitter.position, DVec3::ZERO));
        assert_eq!((body.inverse_mass, body.color), (Some(4.0), [0.0, 0.0, 1.0]));
        assert_eq!(
            (body.method, body.substeps),
            (Some(motion::Method::RungeKutta4), Some(2.into()))
        );
    }
    // Straight up unless it says otherwise.
    assert!(emitter.launches.iter().all(|launch| *launch == DVec3::Y * 12.0));
    assert_eq!(scene.names.get(20).unwrap(), "fountain.19");
}

#[test]
fn without_a_capacity_there_are_as_many_as_live_at_once() {
    assert_eq!(emitter("rate_per_s: 500, life_s: 3, speed_m_s: 1").launches.len(), 1500);
    assert_eq!(emitter("rate_per_s: 0.3, life_s: 5, speed_m_s: 1").launches.len(), 2);
    assert_eq!(emitter("rate_per_s: 0.01, life_s: 0.01, speed_m_s: 1").launches.len(), 1);
}

#[test]
fn launches_fill_their_cone_evenly() {
    for (spread, direction) in
        [(10.0, DVec3::X), (60.0, DVec3::new(1.0, -2.0, 0.5)), (180.0, DVec3::NEG_Z)]
    {
        let [x, y, z] = direction.to_array();
        let n = 5000;
        let emitter = emitter(&format!(
            "rate_per_s: 1, life_s: 1, speed_m_s: 8, capacity: {n}, direction: ({x}, {y}, {z}), spread_deg: {spread}"
        ));
        let along = direction.normalize();
        let edge = libm::cos(f64::to_radians(spread));
        let (mut sum, mut across) = (0.0, DVec3::ZERO);
        for launch in &emitter.launches {
            assert!((launch.length() - 8.0).abs() < 1e-14 * 8.0);
            let cosine = launch.dot(along) / 8.0;
            assert!(cosine >= edge - 1e-14, "{cosine} is outside of {spread} degrees");
            sum += cosine;
            across += (launch - along * launch.dot(along)) / 8.0;
        }
        // On a sphere the cosine is uniform between the edge and 1: five standard errors of its mean.
        let (mean, error) = (sum / f64::from(n), (1.0 - edge) / (12.0 * f64::from(n)).sqrt());
        assert!((mean - 0.5 * (1.0 + edge)).abs() < 5.0 * error, "{mean} for {spread} degrees");
        assert!((across / f64::from(n)).length() < 5.0 / f64::from(n).sqrt(), "{across}");
    }
}

#[test]
fn the_same_seed_gives_the_same_launches_and_leaves_other_draws_alone() {
    let text = |seed: u64, emitters: &str| {
        format!(
            "seed: {seed}, grids: [(rows: 4, columns: 4)], clouds: [(count: 9, half_extents_m: (1, 1, 1), speed_m_s: 1)] {emitters}"
        )
    };
    let keys = "rate_per_s: 1, life_s: 1, speed_m_s: 1, capacity: 30, spread_deg: 40";
    let emitters = format!(", emitters: [({keys}), ({keys})]");
    let (plain, one) = (parse(&text(7, "")), parse(&text(7, &emitters)));
    assert_eq!(one, parse(&text(7, &emitters)));
    assert_eq!(plain.bodies[..], one.bodies[..plain.bodies.len()]);
    assert_ne!(one.emitters[0].launches, one.emitters[1].launches);
    assert_ne!(one.emitters[0].launches, parse(&text(8, &emitters)).emitters[0].launches);
}
