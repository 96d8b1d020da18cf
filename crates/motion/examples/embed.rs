//! `motion` in a schedule of your own: a rocket, two balls on a spring and a fountain in a breeze.
//!
//! Run with `cargo run -p inertia-motion --example embed`.

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::units::Vector;
use motion::{
    Curve, Dormant, Elastic, Emitter, Force, Forces, Gravity, Method, OwnLaws, PhysicsBody, Spring,
    StableId, StepSystems, Stepper, Thrust, TimeStep, Transform,
};

/// Length of a tick.
pub const STEP: TimeStep = TimeStep(1.0 / 120.0);

/// A body that is printed.
#[derive(Component)]
struct Watched(&'static str);

/// What moves, and what moves it.
pub fn spawn(world: &mut World) {
    world.insert_resource(Gravity::EARTH);
    let at = |x: f64| Transform::at(Vector::new(x, 10.0, 0.0));
    // 40 N upward from 0.1 s to 0.35 s.
    let engine = Thrust::new(Curve::Polynomial(vec![Vector::Y * 40.0]), 0.1, 0.35);
    let engines = OwnLaws::new(vec![Box::new(engine)]);
    world.spawn((Watched("rocket"), StableId(0), at(0.0), PhysicsBody::with_mass(2.0), engines));
    let left = world.spawn((StableId(1), at(4.0), PhysicsBody::with_mass(1.0))).id();
    let right =
        world.spawn((Watched("right"), StableId(2), at(6.0), PhysicsBody::with_mass(1.0))).id();
    let elastic = Elastic::new(20.0, 1.0).damped(0.1);
    world.spawn(Spring { ends: [left, right], elastic });
    let mut ids = (3..).map(StableId);
    let launches = (0..20).map(|drop| Vector::new(0.1 * f64::from(drop), 6.0, 0.0)).collect();
    let fountain =
        Emitter::new(40.0, 0.5, launches).at(Vector::new(-4.0, 10.0, 0.0)).with_mass(0.01);
    let fountain = fountain
        .with_pool(|| world.spawn((ids.next().expect("endless"), PhysicsBody::IMMOVABLE)).id());
    world.spawn(fountain);
}

/// A system of your own that adds forces in every tick.
pub fn blow(
    clock: Res<StepClock>,
    mut forces: Forces,
    bodies: Query<Entity, (With<PhysicsBody>, Without<Dormant>)>,
) {
    for body in &bodies {
        forces.add(body, Vector::X * (0.05 * clock.scene_seconds()));
    }
}

/// `Force` can be read until it is cleared.
fn watch(bodies: Query<(&Watched, &Transform, &PhysicsBody, &Force)>) {
    for (Watched(name), Transform { position, .. }, body, force) in &bodies {
        println!(
            "{name:>8} {:>8.3} m {:>8.3} m/s {:>8.4} N",
            position.y,
            body.velocity.y,
            force.newtons().x
        );
    }
}

/// A world and a schedule of which each run is a tick.
pub fn embed(method: Method) -> (World, Schedule) {
    let mut world = World::new();
    spawn(&mut world);
    let mut schedule = Schedule::default();
    Stepper::new(&mut world, method, STEP).install(&mut world, &mut schedule);
    schedule.add_systems(blow.before(StepSystems::Integrate));
    (world, schedule)
}

fn main() {
    let (mut world, mut schedule) = embed(Method::SemiImplicitEuler);
    schedule.add_systems(watch.after(StepSystems::Integrate).before(StepSystems::ClearForces));
    for _ in 0..60 {
        schedule.run(&mut world);
        // As `bevy_app` does after every update.
        world.clear_trackers();
    }
}
