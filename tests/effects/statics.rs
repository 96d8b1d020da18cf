//! Bodies that are immovable and at rest cost a step nothing.

use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce as _;
use motion::clock::StepClock;
use motion::internals::{Bodies, Unmarked};
use motion::units::Vector;
use motion::{
    Damping, Drag, Elastic, Gravity, Method, PhysicsBody, PushQueue, Request, Static, Transform,
};

use crate::rigs::{H, Lab, Start};

fn is_static(lab: &Lab, body: Entity) -> bool {
    lab.world.get::<Static>(body).is_some()
}

#[test]
fn a_step_looks_at_no_body_that_is_immovable_and_at_rest() {
    for method in Method::ALL {
        let mut lab = Lab::new(method, H).with_gravity().with(Damping::TUTORIAL);
        lab.world.insert_resource(Drag::new(0.1, 0.1));
        let [floor, wall] = [(); 2].map(|()| lab.body(0.0, Vector::ZERO));
        let (gliding, falling) = (lab.body(0.0, Vector::X), lab.body(1.0, Vector::ZERO));
        lab.run(10);
        assert!(is_static(&lab, floor) && is_static(&lab, wall));
        assert!(!is_static(&lab, gliding) && !is_static(&lab, falling));
        let seen = lab
            .world
            .run_system_once(|bodies: Bodies<Unmarked>| {
                bodies.iter().map(|row| row.entity).collect::<Vec<_>>()
            })
            .unwrap();
        assert_eq!(seen.len(), 2);
        assert!(seen.contains(&gliding) && seen.contains(&falling), "{}", method.name());
        // What it is not looked at for did not change either.
        assert_eq!(lab.state(floor), (Vector::Y * 10.0, Vector::ZERO));
        assert!(lab.x(gliding).x > 0.05 && lab.x(falling).y < 10.0);
    }
}

#[test]
fn one_that_is_pushed_stays_and_leaves_no_force_behind() {
    let mut lab = Lab::tutorial();
    let floor = lab.body(0.0, Vector::ZERO);
    lab.run(1).push(floor, Vector::new(1e6, f64::NAN, 3.0)).run(2);
    assert!(is_static(&lab, floor) && lab.records().is_empty());
    assert_eq!(lab.state(floor), (Vector::Y * 10.0, Vector::ZERO));
    assert_eq!(lab.world.get::<motion::Force>(floor).unwrap().newtons(), Vector::ZERO);
    assert_eq!(lab.world.resource::<PushQueue>().waiting(), 0);
}

#[test]
fn one_that_is_given_a_velocity_or_a_mass_moves_from_then_on() {
    let mut lab = Lab::new(Method::SemiImplicitEuler, H);
    let [floor, wall] = [(); 2].map(|()| lab.body(0.0, Vector::ZERO));
    lab.run(1)
        .ask(Request::SetVelocity(floor, Vector::X))
        .ask(Request::SetInverseMass(wall, 0.5))
        .run(3);
    assert!(!is_static(&lab, floor) && !is_static(&lab, wall));
    assert_eq!(lab.x(floor).x, 3.0 * H);
    lab.push(wall, Vector::Z * 2.0).run(1);
    assert!(lab.v(wall).z > 0.0);
    // And back again.
    lab.ask(Request::SetVelocity(floor, Vector::ZERO)).run(1);
    assert!(is_static(&lab, floor));
    // An impulse does not move it, and moving it elsewhere leaves it at rest.
    lab.ask(Request::Impulse(floor, Vector::X)).ask(Request::SetPosition(floor, Vector::Z)).run(1);
    assert!(is_static(&lab, floor));
    assert_eq!(lab.state(floor), (Vector::Z, Vector::ZERO));
}

#[test]
fn code_that_gives_a_static_body_a_mass_or_a_velocity_moves_it() {
    type Write = fn(&mut World, Entity);
    let writes: [Write; 4] = [
        |world, body| {
            world.entity_mut(body).insert(PhysicsBody::with_mass(1.0));
        },
        |world, body| {
            world.entity_mut(body).insert(PhysicsBody::IMMOVABLE.moving_at(-Vector::Y));
        },
        |world, body| world.get_mut::<PhysicsBody>(body).unwrap().velocity = -Vector::Y,
        |world, body| {
            for mut state in
                world.query_filtered::<&mut PhysicsBody, With<Static>>().iter_mut(world)
            {
                state.inverse_mass = 1.0;
            }
            assert!(world.get::<PhysicsBody>(body).unwrap().inverse_mass > 0.0);
        },
    ];
    for method in Method::ALL {
        for (number, write) in writes.into_iter().enumerate() {
            let mut lab = Lab::new(method, H).with_gravity();
            let floor = lab.body(0.0, Vector::ZERO);
            lab.body(1.0, Vector::ZERO);
            lab.run(3);
            assert!(is_static(&lab, floor));
            write(&mut lab.world, floor);
            lab.run(2);
            assert!(!is_static(&lab, floor) && lab.x(floor).y < 10.0, "{method:?}, write {number}");
        }
    }
}

#[test]
fn an_anchor_that_is_given_a_mass_is_pulled_by_its_spring() {
    // At rest, and moving steadily.
    for velocity in [Vector::ZERO, Vector::Z] {
        let mut lab = Lab::new(Method::SemiImplicitEuler, H);
        let anchor = lab.body(0.0, velocity);
        let ball = lab.spawn(Start { x: Vector::new(2.0, 10.0, 0.0), v: Vector::ZERO, w: 1.0 });
        lab.spring([anchor, ball], Elastic::new(50.0, 1.0));
        lab.run(2);
        let state = PhysicsBody { velocity, inverse_mass: 1.0 };
        lab.world.entity_mut(anchor).insert(state);
        assert!(lab.run(2).v(anchor).x > 0.0, "{velocity}");
    }
}

#[test]
fn nothing_of_a_static_body_is_marked_as_moved() {
    let mut lab = Lab::tutorial();
    let (floor, ball) = (lab.body(0.0, Vector::ZERO), lab.body(1.0, Vector::ZERO));
    lab.run(2);
    lab.world.clear_trackers();
    lab.run(2);
    let changed: Vec<_> = lab
        .world
        .query::<(Entity, Ref<Transform>)>()
        .iter(&lab.world)
        .filter(|(_, transform)| transform.is_changed())
        .map(|(body, _)| body)
        .collect();
    assert!(changed.contains(&ball) && !changed.contains(&floor));
    assert_eq!(lab.world.resource::<StepClock>().ticks(), 4);
    assert!(lab.world.resource::<Gravity>().on && lab.world.get::<PhysicsBody>(floor).is_some());
}
