//! Coupled bodies against the digits and closed forms of theory.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Elastic, METHODS, Method, PhysicsBody, Spring, StableId, Stepper, TimeStep, Transform, totals};

/// A world of bodies (position, velocity, inverse mass) and springs between them.
fn world(bodies: &[(DVec3, DVec3, f64)], springs: &[([usize; 2], Elastic<f64>)]) -> (World, Vec<Entity>) {
    let mut world = World::new();
    let entities: Vec<_> = (0..)
        .zip(bodies)
        .map(|(id, (position, velocity, inverse_mass))| {
            let body = PhysicsBody { velocity: *velocity, inverse_mass: *inverse_mass };
            world.spawn((StableId(id), Transform::at(*position), body)).id()
        })
        .collect();
    for (ends, elastic) in springs {
        world.spawn(Spring { ends: ends.map(|end| entities[end]), elastic: *elastic });
    }
    (world, entities)
}

fn elastic(stiffness: f64, rest_length: f64) -> Elastic<f64> {
    Elastic { stiffness, damping: 0.0, rest_length }
}

#[test]
fn a_mass_on_a_spring_swings_as_the_closed_form() {
    // w = 2, x0 = 1 beyond the rest length, v0 = 0.5.
    let exact = |t: f64| (2.0 * t).cos() + 0.25 * (2.0 * t).sin();
    for claims in METHODS {
        let error = |steps: u32| {
            let bodies = [(DVec3::ZERO, DVec3::ZERO, 0.0), (DVec3::X * 3.0, DVec3::X * 0.5, 0.5)];
            let (mut world, entities) = world(&bodies, &[([0, 1], elastic(8.0, 2.0))]);
            let h = 2.0 / f64::from(steps);
            let mut stepper = Stepper::new(&mut world, claims.method, TimeStep(h));
            (0..steps).for_each(|_| stepper.tick(&mut world));
            (world.get::<Transform>(entities[1]).unwrap().position.x - 2.0 - exact(2.0)).abs()
        };
        let (coarse, fine) = (error(512), error(1024));
        println!("{:24} {coarse:e} {fine:e} {}", claims.name, (coarse / fine).log2());
        let order = (coarse / fine).log2();
        assert!((order - f64::from(claims.position_order)).abs() < 0.1, "{}: {order}", claims.name);
    }
}

#[test]
fn momentum_is_kept() {
    let v = DVec3::new(0.5, 0.0, 0.0);
    let corners = [DVec3::ZERO, DVec3::X * 1.25, DVec3::Y * 1.25, DVec3::Z * 1.25];
    let bodies: Vec<_> = (1..)
        .zip(corners)
        .map(|(m, at)| (at, if m == 1 { v } else { DVec3::ZERO }, 1.0 / f64::from(m)))
        .collect();
    let springs: Vec<_> =
        (0..4).flat_map(|a| (a + 1..4).map(move |b| ([a, b], elastic(50.0, 1.0)))).collect();
    for method in Method::ALL {
        let (mut world, entities) = world(&bodies, &springs);
        let mut stepper = Stepper::new(&mut world, method, TimeStep(1.0 / 512.0));
        (0..1024).for_each(|_| stepper.tick(&mut world));
        let at = world.get::<Transform>(entities[0]).unwrap().position;
        println!("{method:?} {at} {:?}", totals(&mut world));
        let sum = totals(&mut world);
        assert!((sum.momentum - v).length() < 1e-13, "{method:?}");
    }
}
