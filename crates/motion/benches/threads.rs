//! Large groups on one thread and on two: mutual gravity of a cloud, and a lattice in which every point is joined to all
//! that share a cell with it. Wall-clock time of a tick; the median of interleaved rounds.

use std::time::Instant;

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{
    Elastic, Gravity, Link, Method, MutualGravity, PhysicsBody, SoftBody, StableId, Stepper,
    Threads, TimeStep, Transform,
};

const H: f64 = 1.0 / 240.0;
const ROUNDS: usize = 7;

/// `n` bodies at random places, by the generator of Lehmer (1951), multiplier 48271.
fn cloud(n: usize) -> World {
    let mut state = 12_345_u32;
    let mut random = || {
        state = u32::try_from(u64::from(state) * 48_271 % 0x7fff_ffff).expect("below the modulus");
        f64::from(state) / 2_147_483_647.0 - 0.5
    };
    let mut vector = |scale: f64| Vector::new(random(), random(), random()) * scale;
    let mut world = World::new();
    world.insert_resource(MutualGravity::new(1.0, 0.05));
    let body = |_| {
        (Transform::at(vector(100.0)), PhysicsBody { velocity: vector(1.0), inverse_mass: 1.0 })
    };
    world.spawn_batch((0..n).map(body).collect::<Vec<_>>());
    world
}

/// `n³` points, those of one side immovable.
fn lattice(n: usize) -> World {
    let mut world = World::new();
    world.insert_resource(Gravity::EARTH);
    let place = |i: usize| [i / (n * n), i / n % n, i % n];
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let point = |i: usize| {
        let [x, y, z] = place(i).map(|part| part as f64);
        let inverse_mass = if x > 0.0 { 1.0 } else { 0.0 };
        let id = StableId(u32::try_from(i).expect("small"));
        (
            id,
            Transform::at(Vector::new(x, y, z * 1.001)),
            PhysicsBody { velocity: Vector::ZERO, inverse_mass },
        )
    };
    let all = n * n * n;
    let points: Vec<_> = world.spawn_batch((0..all).map(point).collect::<Vec<_>>()).collect();
    let mut springs = Vec::new();
    for i in 0..all {
        // Of the 26 neighbors, the 13 that come later.
        for neighbor in 14..27 {
            let steps = [neighbor / 9, neighbor / 3 % 3, neighbor % 3];
            let moved = [0, 1, 2]
                .map(|axis| (place(i)[axis] + steps[axis]).checked_sub(1).filter(|x| *x < n));
            if let [Some(x), Some(y), Some(z)] = moved {
                let ends = [i, (x * n + y) * n + z].map(|end| u32::try_from(end).expect("small"));
                let away = steps.iter().filter(|step| **step != 1).count();
                let rest_length = f64::from(u32::try_from(away).expect("3 at most")).sqrt();
                let elastic = Elastic::new(1000.0, rest_length).damped(1.0);
                springs.push(Link { ends, elastic });
            }
        }
    }
    world.spawn(SoftBody::new(points, springs));
    world
}

fn compare(name: &str, method: Method, world: impl Fn() -> World) {
    let mut runs = [1, 2].map(|threads| {
        let mut world = world();
        world.insert_resource(Threads::new(threads));
        let mut stepper = Stepper::new(&mut world, method, TimeStep(H));
        stepper.tick(&mut world);
        (world, stepper)
    });
    let mut times = [const { Vec::new() }; 2];
    for _ in 0..ROUNDS {
        for ((world, stepper), times) in runs.iter_mut().zip(&mut times) {
            let start = Instant::now();
            stepper.tick(world);
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    let [one, two] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2]
    });
    println!("{name:>24}  {:<22} {one:>8.1} ms  {two:>8.1} ms  {:5.2}", method.name(), one / two);
}

fn main() {
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    println!("a tick on one thread, on two, and how many times as fast two are");
    compare("10,000 bodies attract", Method::SemiImplicitEuler, || cloud(10_000));
    for method in [
        Method::SemiImplicitEuler,
        Method::VelocityVerlet,
        Method::RungeKutta4,
        Method::ImplicitEuler,
    ] {
        compare("lattice of 100 cubed", method, || lattice(100));
    }
}
