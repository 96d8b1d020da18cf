//! Tests that its line in the list of laws is all that a law needs.

use std::f64::consts::PI;

use bevy_ecs::prelude::*;

use super::Bare;
use crate::kernels::evaluations::Evaluations;
use crate::laws::{LAWS, Lift};
use crate::methods::table::Method;
use crate::schedule::effects::{Effect, EffectState, state, switch};
use crate::schedule::stepper::Stepper;
use crate::state::clock::TimeStep;
use crate::state::components::{PhysicsBody, Transform};
use crate::tick::quarantine::{Cause, Fault, Quarantine};
use crate::units::Vector;

/// [`Lift`] is named by its file and by the list, and nowhere else.
#[test]
fn a_law_in_the_list_acts_is_counted_copied_switched_and_diagnosed() {
    const TICKS: u32 = 256;
    let method = Method::RungeKutta4;
    let mut world = World::new();
    world.insert_resource(Lift { turn: Vector::Z * 2.0 });
    let body = PhysicsBody { velocity: Vector::X * 3.0, inverse_mass: 1.0 };
    let body = world.spawn((Transform::at(Vector::ZERO), body)).id();
    let mut stepper = Stepper::new(&mut world, method, TimeStep(PI / f64::from(TICKS)));
    let position = |world: &World| world.get::<Transform>(body).expect("it is there").position;
    let velocity = |world: &World| world.get::<PhysicsBody>(body).expect("it is there").velocity;
    let mut arrays = Bare::of_world(&mut world, method, &|_| Vec::new(), Vec::new())
        .expect("it has a time step");

    // A circle of radius v / w and period 2 pi / w.
    for _ in 0..TICKS / 2 {
        stepper.tick(&mut world);
        arrays.tick();
    }
    assert!((position(&world) - Vector::Y * 3.0).length() < 1e-6, "{}", position(&world));
    for _ in 0..TICKS / 2 {
        stepper.tick(&mut world);
        arrays.tick();
    }
    assert!(position(&world).length() < 1e-6, "{}", position(&world));
    assert_eq!(arrays.positions, [position(&world).to_array()]);

    assert!(LAWS.iter().any(|(name, _)| *name == "lift"));
    let evaluations = u64::from(TICKS) * 4;
    assert!(world.resource::<Evaluations>().laws().contains(&("lift", evaluations)));

    assert_eq!(Effect::from_name("lift"), Some(Effect::Lift));
    switch(&mut world, Effect::Lift, false).expect("it is declared");
    stepper.recompile(&mut world);
    assert_eq!(state(&mut world, Effect::Lift), EffectState::Off);
    let straight = velocity(&world);
    stepper.tick(&mut world);
    assert_eq!(velocity(&world), straight);
    switch(&mut world, Effect::Lift, true).expect("it is declared");
    stepper.recompile(&mut world);
    stepper.tick(&mut world);
    assert_ne!(velocity(&world), straight);

    world.resource_mut::<Lift>().turn.z = f64::NAN;
    stepper.tick(&mut world);
    let records = world.resource::<Quarantine>().records();
    assert_eq!((records[0].cause.component, records[0].cause.fault), ("Lift", Fault::Found));
    assert!(Cause::names().any(|name| name == "Lift"));
}
