//! Tests of ticks that need private items of this crate.

use bevy_ecs::prelude::*;

use crate::laws::{Well, Wells};
use crate::methods::table::Method;
use crate::schedule::stepper::Stepper;
use crate::state::clock::TimeStep;
use crate::state::components::{PhysicsBody, Transform};
use crate::state::method_state::LastAcceleration;
use crate::tick::quarantine::Quarantine;
use crate::units::Vector;

/// A cached acceleration only saves an evaluation: one that is not finite is evaluated again.
#[test]
fn a_nan_in_a_cached_acceleration_harms_no_body() {
    for method in [Method::VelocityVerlet, Method::Yoshida4] {
        let run = |spoils: bool| {
            let mut world = World::new();
            world.insert_resource(Wells(vec![Well {
                position: Vector::ZERO,
                strength: 5.0,
                softening: 0.1,
            }]));
            let bodies: [Entity; 10] = std::array::from_fn(|body| {
                let x = Vector::new(2.0, 0.3 * body as f64, -1.0);
                world
                    .spawn((
                        Transform::at(x),
                        PhysicsBody { velocity: Vector::Y, inverse_mass: 1.0 },
                    ))
                    .id()
            });
            let mut stepper = Stepper::new(&mut world, method, TimeStep(0.01));
            (0..3).for_each(|_| stepper.tick(&mut world));
            for body in bodies.iter().filter(|_| spoils) {
                world
                    .get_mut::<LastAcceleration>(*body)
                    .expect("it caches accelerations")
                    .0
                    .acceleration = [f64::NAN; 3];
            }
            (0..3).for_each(|_| stepper.tick(&mut world));
            assert!(world.resource::<Quarantine>().records().is_empty());
            bodies.map(|body| {
                (world.get::<Transform>(body).copied(), world.get::<PhysicsBody>(body).copied())
            })
        };
        assert_eq!(run(true), run(false), "{method:?}");
    }
}
