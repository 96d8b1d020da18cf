//! Emitters and wells that ride on bodies.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::ledger::Ledger;
use motion::{
    Evaluations, Gravity, Law, Method, OwnLaws, PhysicsBody, Request, RidesOn, RidingWell,
    StableId, Transform, Well, Wells,
};

use super::emitters::{fountain, living, now};
use crate::rigs::{Environment, Lab, Net, Start};

const START: DVec3 = DVec3::new(1.0, -2.0, 4.0);
const SPEED: DVec3 = DVec3::new(0.5, 3.0, -1.0);

/// A carrier with twenty particles per second that live for 0.7 s.
fn carried(method: Method, h: f64, gravity: Option<Gravity>) -> (Lab, Entity) {
    let (mut lab, emitter) = fountain(16, 20.0, 0.7, method, h, |world| {
        gravity.into_iter().for_each(|gravity| world.insert_resource(gravity));
    });
    let body = PhysicsBody { velocity: SPEED, inverse_mass: 0.1 };
    let carrier = lab.world.spawn((StableId(99), Transform::at(START), body)).id();
    lab.world.entity_mut(emitter).insert(RidesOn(carrier));
    lab.recompile();
    (lab, carrier)
}

fn x(lab: &Lab, body: Entity) -> DVec3 {
    lab.world.get::<Transform>(body).unwrap().position
}

fn v(lab: &Lab, body: Entity) -> DVec3 {
    lab.world.get::<PhysicsBody>(body).unwrap().velocity
}

#[test]
fn particles_begin_at_their_carrier_with_its_velocity() {
    for method in Method::ALL {
        let (mut lab, _) = carried(method, 1.0 / 60.0, None);
        let (mut still, _) = fountain(16, 20.0, 0.7, method, 1.0 / 60.0, |_| ());
        for _ in 0..90 {
            lab.run(1);
            still.run(1);
            assert_eq!(living(&lab), living(&still), "{method:?}");
            for slot in living(&lab) {
                // As seen from the carrier nothing tells that it moves.
                let [moving, still] =
                    [&lab, &still].map(|lab| (x(lab, lab.bodies[slot]), v(lab, lab.bodies[slot])));
                let carrier = START + SPEED * now(&lab);
                assert!(
                    (moving.0 - carrier).distance(still.0) < 1e-13,
                    "{method:?} {slot}: {moving:?} {still:?}"
                );
                assert!(
                    (moving.1 - SPEED).distance(still.1) < 1e-14,
                    "{method:?} {slot}: {moving:?} {still:?}"
                );
            }
        }
    }
}

#[test]
fn a_falling_carrier_and_its_particles_fall_alike() {
    let off = |hz: u32| {
        let (mut lab, carrier) =
            carried(Method::RungeKutta4, 1.0 / f64::from(hz), Some(Gravity::EARTH));
        let (mut still, _) =
            fountain(16, 20.0, 0.7, Method::RungeKutta4, 1.0 / f64::from(hz), |_| ());
        lab.run(u64::from(hz));
        still.run(u64::from(hz));
        let errors = living(&lab).into_iter().map(|slot| {
            let body = lab.bodies[slot];
            (x(&lab, body) - x(&lab, carrier)).distance(x(&still, still.bodies[slot]))
        });
        errors.fold(0.0, f64::max)
    };
    // Within a tick of a birth the carrier counts as moving uniformly.
    let [coarse, fine] = [off(70), off(140)];
    assert!(coarse < 0.1 && coarse / fine > 1.8, "{coarse} {fine}");
}

#[test]
fn nothing_is_born_without_the_carrier_and_what_lives_lives_on() {
    let (mut lab, carrier) = carried(Method::VelocityVerlet, 1.0 / 60.0, None);
    lab.run(60);
    let before = living(&lab);
    lab.ask(Request::Remove(carrier)).run(30);
    let after = living(&lab);
    assert!(
        !after.is_empty() && after.is_subset(&before) && after.len() < before.len(),
        "{after:?} {before:?}"
    );
    assert_eq!(living(lab.run(30)).len(), 0);
}

/// A planet and its moon, both with this velocity besides; the moon's well rides on the planet, or stays at the origin.
fn moon(method: Method, h: f64, velocity: DVec3, gravity: Option<Gravity>, rides: bool) -> Lab {
    let planet = Start::of(9.0, DVec3::ZERO, velocity);
    let moon = Start::of(1.0, DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.1, 1.3, 0.2) + velocity);
    let mut lab = Net::free([planet, moon]).lab(
        &Environment { gravity, ..Environment::default() },
        method,
        h,
    );
    let law: Box<dyn Law> = match rides {
        true => Box::new(RidingWell::new(lab.bodies[0], 2.0, 0.3)),
        false => {
            Box::new(Wells(vec![Well { position: DVec3::ZERO, strength: 2.0, softening: 0.3 }]))
        }
    };
    lab.insert(1, OwnLaws::new(vec![law]));
    lab.recompile();
    lab
}

#[test]
fn a_well_that_moves_uniformly_is_as_one_at_rest() {
    for method in Method::ALL {
        let mut riding = moon(method, 1.0 / 60.0, SPEED, None, true);
        let mut still = moon(method, 1.0 / 60.0, DVec3::ZERO, None, false);
        for tick in 0..240 {
            let [moving, still] = [&mut riding, &mut still].map(|lab| lab.run(1).states()[1]);
            let carried = SPEED * now(&riding);
            assert!(
                (moving.0 - carried).distance(still.0) < 1e-11,
                "{method:?} {tick}: {moving:?} {still:?}"
            );
            assert!(
                (moving.1 - SPEED).distance(still.1) < 1e-11,
                "{method:?} {tick}: {moving:?} {still:?}"
            );
        }
    }
}

#[test]
fn on_a_carrier_that_falls_methods_are_of_order_2_at_most() {
    // All fall alike, so that the moon goes round its planet as round a planet at rest.
    let error = |hz: u32| {
        let h = 1.0 / f64::from(hz);
        let mut falling = moon(Method::RungeKutta4, h, SPEED, Some(Gravity::EARTH), true);
        let mut still = moon(Method::RungeKutta4, h, DVec3::ZERO, None, false);
        let [falling, still] =
            [&mut falling, &mut still].map(|lab| lab.run(u64::from(hz)).states());
        (falling[1].0 - falling[0].0).distance(still[1].0)
    };
    let [coarse, fine] = [error(120), error(240)];
    let order = (coarse / fine).log2();
    assert!((order - 2.0).abs() < 0.1, "{coarse:e} {fine:e}: {order}");
}

#[test]
fn the_work_of_a_riding_well_is_a_line_of_the_ledger() {
    let mut lab = moon(Method::RungeKutta4, 1.0 / 240.0, SPEED, None, true);
    let mut ledger = Ledger::open(&lab.world);
    (0..480).for_each(|_| ledger.tick(&mut lab.stepper, &mut lab.world));
    let energy = &ledger.since_opening().energy;
    assert!(energy.law("wells").abs() > 0.3 && energy.residual.abs() < 1e-8, "{energy:?}");
    assert!(ledger.since_opening().momentum.residual.length() < 1e-8);
}

#[test]
fn a_well_whose_carrier_is_gone_attracts_nothing() {
    let mut lab = moon(Method::VelocityVerlet, 1.0 / 60.0, SPEED, None, true);
    let carrier = lab.bodies[0];
    lab.run(60).ask(Request::Remove(carrier)).run(1);
    let before = v(&lab, lab.bodies[1]);
    lab.run(60);
    assert_eq!(v(&lab, lab.bodies[1]), before);
}

#[test]
fn a_riding_well_costs_those_that_it_attracts_one_more_evaluation_and_no_others() {
    let mut lab = moon(Method::VelocityVerlet, 1.0 / 60.0, SPEED, None, true);
    lab.world.insert_resource(Wells(vec![Well {
        position: DVec3::ZERO,
        strength: 1.0,
        softening: 0.5,
    }]));
    lab.recompile();
    lab.run(10);
    let before = lab.world.resource::<Evaluations>().accelerations();
    lab.run(100);
    // The planet starts a tick with its last acceleration; the moon's was along the course of the last tick.
    assert_eq!(lab.world.resource::<Evaluations>().accelerations() - before, 300);
}
