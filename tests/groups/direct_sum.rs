//! Mutual gravity of many bodies: the sum over all pairs, bit for bit, with any number of threads.

use glam::DVec3;
use motion::{Method, MutualGravity, SourceMass, Threads};

use crate::rigs::{Dice, Environment, Net, Start, net::H};

/// Not a multiple of the bodies that are computed at once, and enough for several threads.
const BODIES: usize = 411;

/// Bodies whose masses differ, two at the same position, and one that is immovable with a mass as a source.
fn cloud() -> Vec<Start> {
    let mut dice = Dice(11);
    let mut bodies: Vec<_> = (0..BODIES)
        .map(|_| Start { x: dice.vector() * 5.0, v: DVec3::ZERO, w: 1.0 + 0.5 * dice.number() })
        .collect();
    bodies[200].x = bodies[7].x;
    bodies[BODIES - 1].w = 0.0;
    bodies
}

/// The velocities after a step of semi-implicit Euler from rest, pair by pair: force and opposite force.
fn pair_by_pair(law: MutualGravity, bodies: &[Start], source: f64) -> Vec<DVec3> {
    let mut forces = vec![DVec3::ZERO; bodies.len()];
    let mass = |body: &Start| if body.w > 0.0 { 1.0 / body.w } else { source };
    for a in 0..bodies.len() {
        for b in a + 1..bodies.len() {
            let r = bodies[b].x - bodies[a].x;
            if r != DVec3::ZERO {
                let inverse = 1.0 / (r.dot(r) + law.softening * law.softening).sqrt();
                let masses = law.constant * mass(&bodies[a]) * mass(&bodies[b]);
                let force = r * (masses * inverse * inverse * inverse);
                forces[a] += force;
                forces[b] += -force;
            }
        }
    }
    bodies.iter().zip(forces).map(|(body, force)| force * body.w * H).collect()
}

#[test]
fn it_is_the_sum_over_all_pairs_with_any_number_of_threads() {
    let (bodies, source) = (cloud(), 40.0);
    for softening in [0.0, 0.3] {
        let law = MutualGravity { constant: 0.7, softening };
        let around = Environment { attraction: Some(law), ..Environment::default() };
        let expected = pair_by_pair(law, &bodies, source);
        for threads in [1, 2, 3] {
            let mut lab = Net::free(&bodies[..]).lab(&around, Method::SemiImplicitEuler, H);
            lab.insert(BODIES - 1, SourceMass(source));
            lab.world.insert_resource(Threads::new(threads));
            lab.run(1);
            for (body, expected) in expected.iter().enumerate() {
                assert_eq!(
                    lab.v(body),
                    *expected,
                    "{body} by {threads} threads, softened by {softening} m"
                );
            }
        }
    }
}
