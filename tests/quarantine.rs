//! Bodies that would turn non-finite or leave the range are quarantined and named; all others continue as if they had been
//! removed.

mod injection;
mod laws;
mod range;
mod rig;

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{
    AxisLocks, Cause, Damping, Fault, Gravity, Method, PhysicsBody, Quarantined, Request, StableId,
    Substeps, Transform,
};

use crate::rigs::{Lab, Start};

fn crowd(n: usize) -> Lab {
    let mut lab = Lab::tutorial();
    for i in 0..n {
        lab.body(10.0, Vector::new(i as f64, 1.0, -1.0));
    }
    lab.set_method(Method::SemiImplicitEuler);
    lab
}

#[test]
fn a_non_finite_push_quarantines_its_body_and_no_other() {
    for n in [7, 300] {
        for (force, component, fault) in [
            (Vector::new(f64::NAN, 0.0, 0.0), "Force", Fault::Found),
            (Vector::new(0.0, f64::INFINITY, 0.0), "Force", Fault::Found),
            (Vector::new(0.0, 0.0, f64::MAX), "PhysicsBody.velocity", Fault::Overflow),
        ] {
            for victim in [0, 3, n - 1] {
                let mut lab = crowd(n);
                lab.run(9);
                let before = lab.state(victim);
                let mut without = crowd(n);
                without.run(9);
                without.world.despawn(without.bodies[victim]);
                lab.push(victim, force).run(50);
                without.run(50);
                assert_eq!(lab.state(victim), before);
                assert_eq!(lab.all_bits(&[victim]), without.all_bits(&[victim]));
                let records = lab.records();
                assert_eq!(records.len(), 1);
                assert_eq!((records[0].body, records[0].tick), (lab.bodies[victim], 10));
                let cause = Cause { system: "integrate_acceleration", component, fault };
                assert_eq!(records[0].cause, cause);
                assert!(lab.is_quarantined(victim));
            }
        }
    }
}

#[test]
fn an_enormous_push_that_stays_finite_is_not_refused_before_the_position_overflows() {
    let mut lab = crowd(3);
    lab.world.remove_resource::<Damping>();
    lab.push(1, Vector::X * 1e307).run(1);
    assert!(lab.v(1).x > 1e305);
    for _ in 0..5 {
        lab.push(1, Vector::X * 1.7e308).run(1);
    }
    lab.run(200_000);
    let records = lab.records();
    assert_eq!((records.len(), records[0].body), (1, lab.bodies[1]));
    assert!(lab.x(1).is_finite() && lab.v(1).is_finite());
}

#[test]
fn growing_damping_of_the_tutorial_is_caught_before_it_is_infinite() {
    let mut lab = Lab::tutorial().with(Damping { rate: 600.0, ..Damping::TUTORIAL });
    lab.world.remove_resource::<Gravity>();
    let body = lab.body(1.0, Vector::X);
    // 1 - c h = -4: the speed doubles twice a tick and overflows after 512 of them.
    lab.run(600);
    assert!(lab.v(body).is_finite() && lab.x(body).is_finite());
    assert_eq!(lab.records().len(), 1);
}

#[test]
fn an_experiment_may_ask_for_nonsense_and_gets_a_quarantine() {
    for request in [Request::SetVelocity, Request::SetPosition, Request::Impulse] {
        let mut lab = crowd(2);
        lab.run(3);
        let before = lab.state(0);
        lab.ask(request(lab.bodies[0], Vector::NAN)).run(3);
        assert_eq!(lab.state(0), before);
        let record = lab.records()[0];
        assert_eq!(
            (record.body, record.cause.fault, record.tick),
            (lab.bodies[0], Fault::Request, 4)
        );
    }
}

#[test]
fn a_request_that_is_refused_is_named_by_what_it_set() {
    let asked = |request: fn(Entity) -> Request| {
        let mut lab = crowd(1);
        lab.ask(request(lab.bodies[0])).run(1);
        lab.records()[0].cause.what()
    };
    let says = |part: &str| format!("a request set an invalid {part}");
    assert_eq!(asked(|body| Request::SetVelocity(body, Vector::NAN)), says("velocity"));
    assert_eq!(asked(|body| Request::SetPosition(body, Vector::NAN)), says("position"));
    for request in
        [|body| Request::SetInverseMass(body, -1.0), |body| Request::SetInverseMass(body, f64::NAN)]
    {
        assert_eq!(asked(request), says("inverse mass"));
    }
}

#[test]
fn non_finite_gravity_quarantines_what_it_acts_on_and_nothing_else() {
    let mut lab = crowd(300);
    let floor = lab.world.spawn((Transform::default(), PhysicsBody::IMMOVABLE)).id();
    lab.ask(Request::SetGravity(Vector::new(0.0, f64::NAN, 0.0))).run(2);
    assert_eq!(lab.records().len(), lab.bodies.len());
    assert!(lab.world.get::<Quarantined>(floor).is_none());
    assert!(lab.bodies.iter().all(|body| lab.x(*body).is_finite()));
}

#[test]
fn damping_that_is_not_a_number_quarantines_what_moves_where_it_is_and_an_infinite_rate_stops_it_where_it_can()
 {
    for rate in [f64::NAN, f64::INFINITY] {
        for model in motion::DampingModel::ALL {
            // The tutorial's factor 1 - c h is as infinite as the rate, the other two are 0.
            let stops = rate.is_infinite() && model != motion::DampingModel::Tutorial;
            for n in [1, 3, 4, 5, 8, 300] {
                let what = format!("{model:?} {rate} {n}");
                let mut lab = crowd(n);
                let floor = lab.world.spawn((Transform::default(), PhysicsBody::IMMOVABLE)).id();
                lab.run(2);
                let before = lab.states();
                lab.ask(Request::SetDamping(Damping { model, rate })).run(3);
                for (body, (before, _)) in lab.bodies.iter().zip(before) {
                    let rests = lab.v(*body) == Vector::ZERO;
                    assert_eq!(lab.is_quarantined(*body), !stops, "{what}");
                    assert!(lab.x(*body) == before && rests == stops, "{what}: {}", lab.v(*body));
                }
                assert!(lab.world.get::<Quarantined>(floor).is_none());
                let records = lab.records();
                assert_eq!(records.len(), if stops { 0 } else { n }, "{what}");
                assert!(records.iter().all(|record| record.tick == 3), "{what}");
            }
        }
    }
}

#[test]
fn records_are_in_the_order_of_ticks_and_within_a_tick_of_stable_ids() {
    let mut lab = crowd(300);
    // The last row of the table has the lowest id.
    for (id, body) in (0..).zip(lab.bodies.iter().rev()) {
        lab.world.entity_mut(*body).insert(StableId(id));
    }
    for broken in [&[250, 2, 7][..], &[], &[1, 299], &[0, 4]] {
        for id in broken {
            lab.push(299 - id, Vector::NAN);
        }
        lab.run(1);
    }
    let records = lab.records().iter();
    let records: Vec<_> = records.map(|record| (record.tick, record.id.unwrap().0)).collect();
    assert_eq!(records, [(1, 2), (1, 7), (1, 250), (3, 1), (3, 299), (4, 0), (4, 4)]);
}

#[test]
fn a_body_that_breaks_in_a_later_substep_stays_where_it_was_before_the_tick_in_both_kernels() {
    // It leaves the largest number in the third of four quarters of a second.
    let start = (Vector::new(1.7e308, 1.0, 2.0), Vector::new(1.6e307, 3.0, 4.0));
    for method in Method::ALL {
        for called in [false, true] {
            let mut lab = Lab::new(method, 1.0).with(Substeps(4));
            let body = lab.spawn(Start::of(1.0, start.0, start.1));
            let neighbour = lab.body(1.0, Vector::X);
            if called {
                // What a single body asks for is nothing for the kernel in registers.
                for body in [body, neighbour] {
                    lab.insert(body, AxisLocks::default());
                }
            }
            lab.recompile().run(1);
            assert!(lab.is_quarantined(body), "{method:?} {called}");
            assert_eq!(lab.state(body), start, "{method:?} {called}");
            assert_eq!(lab.x(neighbour).x, 1.0, "{method:?} {called}");
        }
    }
}
