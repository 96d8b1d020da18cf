//! Quarantine under every method.

use glam::DVec3;
use motion::{Damping, DampingModel, Fault, Gravity, Method, Request};

use super::{Environment, H, Start, crowd_with_engines, wells};

fn scenes() -> [Environment; 4] {
    let gravity = Some(Gravity::EARTH);
    let damping = Some(Damping { model: DampingModel::Tutorial, rate: 0.4 });
    [
        Environment::falling(),
        Environment { damping, ..Environment::falling() },
        Environment { gravity, wells: Some(wells()), ..Environment::default() },
        Environment { substeps: Some(3), ..Environment::orbiting() },
    ]
}

/// After a tick in which nothing but damping acted.
fn drifted(scene: &Environment, (x, v): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let mut lab =
        Environment { gravity: None, wells: None, ..scene.clone() }.lab(Method::ExplicitEuler, H);
    let body = lab.spawn(Start { x, v, w: 1.0 });
    lab.run(1);
    lab.state(body)
}

#[test]
fn a_body_that_turns_non_finite_is_quarantined_and_no_other_notices() {
    let pushes = [
        DVec3::X * f64::NAN,
        DVec3::Y * f64::INFINITY,
        DVec3::splat(f64::MAX),
        DVec3::Z * -f64::MAX,
    ];
    for method in Method::ALL {
        for scene in scenes() {
            let mut without = crowd_with_engines(&scene, method);
            without.run(60);
            for push in pushes {
                for victim in [0, 3, 10] {
                    let what = format!("{method:?} {push} on {victim} {scene:?}");
                    let mut lab = crowd_with_engines(&scene, method);
                    // What is light enough turns any large force into an infinite velocity.
                    let w = lab
                        .world
                        .get::<motion::PhysicsBody>(lab.bodies[victim])
                        .unwrap()
                        .inverse_mass;
                    lab.run(20);
                    let before = lab.state(victim);
                    lab.push(victim, push * (1.0 / w) * 1e3).run(40);
                    // The first of explicit Euler's two updates is that of the position, which stays finite.
                    let stands =
                        method == Method::ExplicitEuler && scene.substeps.unwrap_or(1) == 1;
                    let quarantined = if stands { drifted(&scene, before) } else { before };
                    assert_eq!(lab.state(victim), quarantined, "{what}");
                    let records = lab.records();
                    assert_eq!(records.len(), 1, "{what}");
                    assert_eq!(
                        (records[0].body, records[0].tick),
                        (lab.bodies[victim], 21),
                        "{what}"
                    );
                    assert_eq!(lab.all_bits(&[victim]), without.all_bits(&[victim]), "{what}");
                }
            }
        }
    }
}

/// Finite velocities that carry a position, or an inner stage, beyond every number.
#[test]
fn a_body_that_runs_out_of_numbers_is_quarantined_where_it_last_was() {
    for method in Method::ALL {
        for scene in scenes() {
            let mut lab = crowd_with_engines(&scene, method);
            let mut without = crowd_with_engines(&scene, method);
            lab.run(20);
            lab.ask(Request::SetPosition(lab.bodies[1], DVec3::X * 1.79e308));
            lab.have(Request::SetVelocity(lab.bodies[1], DVec3::X * 1.7e308));
            let before = lab.state(1);
            lab.run(40);
            without.run(60);
            // The first of semi-implicit Euler's two updates is that of the velocity, which stays finite.
            let kick = if method == Method::SemiImplicitEuler { 9.8 * H } else { 0.0 };
            assert_eq!(lab.x(1), before.0, "{method:?} {scene:?}");
            assert!(lab.v(1).distance(before.1) <= kick, "{method:?} {scene:?}");
            assert!(lab.is_quarantined(1), "{method:?} {scene:?}");
            assert_eq!(lab.all_bits(&[1]), without.all_bits(&[1]), "{method:?} {scene:?}");
        }
    }
}

#[test]
fn a_quarantined_body_is_left_alone_by_every_request() {
    for method in Method::ALL {
        let mut lab = crowd_with_engines(&Environment::falling(), method);
        lab.run(5).push(2, DVec3::X * f64::NAN).run(1);
        let before = lab.bits(2);
        for request in [
            Request::Impulse(lab.bodies[2], DVec3::X),
            Request::SetVelocity(lab.bodies[2], DVec3::X),
            Request::SetPosition(lab.bodies[2], DVec3::X),
            Request::ReverseVelocities,
            Request::SwitchGravity(false),
            Request::SetBodyMethod(lab.bodies[2], Some(method.next())),
            Request::SetBodyMethod(lab.bodies[2], None),
        ] {
            lab.ask(request).run(2);
            assert_eq!(lab.bits(2), before, "{method:?} {request:?}");
        }
        lab.set_method(method.previous());
        lab.run(2);
        assert_eq!(lab.bits(2), before, "{method:?}");
        assert_eq!(lab.records().len(), 1);
    }
}

#[test]
fn a_request_that_is_not_finite_quarantines_its_body() {
    for method in Method::ALL {
        let mut lab = crowd_with_engines(&Environment::orbiting(), method);
        lab.run(5);
        let before = lab.bits(3);
        lab.ask(Request::Impulse(lab.bodies[3], DVec3::Y * f64::NAN)).run(5);
        assert_eq!(lab.bits(3), before, "{method:?}");
        let records = lab.records();
        assert_eq!((records[0].cause.fault, records[0].tick), (Fault::Request, 6), "{method:?}");
    }
}
