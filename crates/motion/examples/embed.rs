//! `motion` in a schedule of one's own: a ball that falls through the wind.
//!
//! Run with `cargo run -p motion --example embed`.

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{
    Force, Forces, Gravity, PhysicsBody, TimeStep, Transform, apply_forces, clear_forces,
    insert_step_resources, integrate_acceleration, integrate_velocity, quarantine_bodies,
};

/// A system of one's own: forces are added in every tick, between `apply_forces` and the integration.
fn blow(mut forces: Forces, bodies: Query<Entity, With<PhysicsBody>>) {
    for body in &bodies {
        forces.add(body, Vector::X * 0.05);
    }
}

/// `Force` is readable until `clear_forces`.
fn watch(bodies: Query<(&Transform, &PhysicsBody, &Force)>) {
    for (transform, body, force) in &bodies {
        println!("{:>8.3} {:>8.3} {:>8.3}", transform.position.y, body.velocity.y, force.newtons().x);
    }
}

fn main() {
    let mut world = World::new();
    insert_step_resources(&mut world, TimeStep(1.0 / 120.0));
    world.insert_resource(Gravity::EARTH);
    world.spawn((Transform::at(Vector::Y * 10.0), PhysicsBody::with_mass(0.1)));

    let mut schedule = Schedule::default();
    schedule.add_systems(
        (
            apply_forces,
            blow,
            integrate_acceleration,
            integrate_velocity,
            watch,
            clear_forces,
            quarantine_bodies,
        )
            .chain(),
    );
    for _ in 0..12 {
        schedule.run(&mut world);
    }
}
