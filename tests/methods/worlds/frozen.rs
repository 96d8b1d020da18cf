//! Quarantine under every method.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Damping, DampingModel, Fault, Gravity, Method, Quarantine, Quarantined, Request};

use super::{Environment, H, Start, engines, starts, wells};
use crate::harness::Lab;

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

fn crowd(scene: &Environment, method: Method) -> (Lab, Vec<Entity>) {
    let mut lab = scene.lab(method, H);
    let bodies: Vec<_> = starts().into_iter().map(|start| lab.spawn(start)).collect();
    lab.world.entity_mut(bodies[3]).insert(engines());
    (lab, bodies)
}

/// After a tick in which nothing but damping acted.
fn drifted(scene: &Environment, (x, v): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let mut lab = Environment { gravity: None, wells: None, ..scene.clone() }.lab(Method::ExplicitEuler, H);
    let body = lab.spawn(Start { x, v, w: 1.0 });
    lab.run(1);
    (lab.x(body), lab.v(body))
}

#[test]
fn a_body_that_turns_non_finite_is_frozen_and_no_other_notices() {
    let pushes =
        [DVec3::X * f64::NAN, DVec3::Y * f64::INFINITY, DVec3::splat(f64::MAX), DVec3::Z * -f64::MAX];
    for method in Method::ALL {
        for scene in scenes() {
            let (mut without, twins) = crowd(&scene, method);
            without.run(60);
            for push in pushes {
                for victim in [0, 3, 10] {
                    let what = format!("{method:?} {push} on {victim} {scene:?}");
                    let (mut lab, bodies) = crowd(&scene, method);
                    // What is light enough turns any large force into an infinite velocity.
                    let w = lab.world.get::<motion::PhysicsBody>(bodies[victim]).unwrap().inverse_mass;
                    lab.run(20);
                    let before = (lab.x(bodies[victim]), lab.v(bodies[victim]));
                    lab.push(bodies[victim], push * (1.0 / w) * 1e3);
                    lab.run(40);
                    // The first of explicit Euler's two updates is that of the position, which stays finite.
                    let stands = method == Method::ExplicitEuler && scene.substeps.unwrap_or(1) == 1;
                    let frozen = if stands { drifted(&scene, before) } else { before };
                    assert_eq!((lab.x(bodies[victim]), lab.v(bodies[victim])), frozen, "{what}");
                    let records = lab.world.resource::<Quarantine>().records();
                    assert_eq!(records.len(), 1, "{what}");
                    assert_eq!((records[0].body, records[0].tick), (bodies[victim], 21), "{what}");
                    for i in (0..bodies.len()).filter(|i| *i != victim) {
                        assert_eq!(lab.bits(bodies[i]), without.bits(twins[i]), "body {i}, {what}");
                    }
                }
            }
        }
    }
}

/// Velocities that are finite and carry a position, or an inner stage, out of all bounds.
#[test]
fn a_body_that_runs_out_of_numbers_is_frozen_where_it_last_was() {
    for method in Method::ALL {
        for scene in scenes() {
            let (mut lab, bodies) = crowd(&scene, method);
            let (mut without, twins) = crowd(&scene, method);
            lab.run(20);
            lab.ask(Request::SetPosition(bodies[1], DVec3::X * 1.79e308));
            lab.ask(Request::SetVelocity(bodies[1], DVec3::X * 1.7e308));
            lab.stepper.carry_out_requests(&mut lab.world);
            let before = (lab.x(bodies[1]), lab.v(bodies[1]));
            lab.run(40);
            without.run(60);
            // The first of semi-implicit Euler's two updates is that of the velocity, which stays finite.
            let kick = if method == Method::SemiImplicitEuler { 9.8 * H } else { 0.0 };
            assert_eq!(lab.x(bodies[1]), before.0, "{method:?} {scene:?}");
            assert!(lab.v(bodies[1]).distance(before.1) <= kick, "{method:?} {scene:?}");
            assert!(lab.world.get::<Quarantined>(bodies[1]).is_some(), "{method:?} {scene:?}");
            for i in (0..bodies.len()).filter(|i| *i != 1) {
                assert_eq!(lab.bits(bodies[i]), without.bits(twins[i]), "body {i}, {method:?} {scene:?}");
            }
        }
    }
}

/// What is frozen stays so when methods change, and is not turned round.
#[test]
fn a_frozen_body_is_left_alone_by_every_request() {
    for method in Method::ALL {
        let (mut lab, bodies) = crowd(&Environment::falling(), method);
        lab.run(5);
        lab.push(bodies[2], DVec3::X * f64::NAN);
        lab.run(1);
        let before = lab.bits(bodies[2]);
        for request in [
            Request::Impulse(bodies[2], DVec3::X),
            Request::SetVelocity(bodies[2], DVec3::X),
            Request::SetPosition(bodies[2], DVec3::X),
            Request::ReverseVelocities,
            Request::SwitchGravity(false),
            Request::SetBodyMethod(bodies[2], Some(method.next())),
            Request::SetBodyMethod(bodies[2], None),
        ] {
            lab.ask(request);
            lab.run(2);
            assert_eq!(lab.bits(bodies[2]), before, "{method:?} {request:?}");
        }
        lab.set_method(method.previous());
        lab.run(2);
        assert_eq!(lab.bits(bodies[2]), before, "{method:?}");
        assert_eq!(lab.world.resource::<Quarantine>().records().len(), 1);
    }
}

/// A request that is not finite says so in its record.
#[test]
fn a_request_that_is_not_finite_freezes_its_body() {
    for method in Method::ALL {
        let (mut lab, bodies) = crowd(&Environment::orbiting(), method);
        lab.run(5);
        let before = lab.bits(bodies[3]);
        lab.ask(Request::Impulse(bodies[3], DVec3::Y * f64::NAN));
        lab.run(5);
        assert_eq!(lab.bits(bodies[3]), before, "{method:?}");
        let records = lab.world.resource::<Quarantine>().records();
        assert_eq!((records[0].cause.fault, records[0].tick), (Fault::Request, 6), "{method:?}");
    }
}
