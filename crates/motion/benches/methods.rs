//! Every method after long decay beside a fresh start, and with two threads beside one.
//!
//! Ratios are medians inside interleaved rounds of thread CPU time; two threads are measured by the wall clock.
//! `-- --steps METHOD BODIES STEPS` does nothing but steps of a world, for an instruction counter: the difference between
//! two numbers of steps is free of the start.

#[path = "common/mod.rs"]
mod common;

use std::time::Instant;

use bevy_ecs::prelude::*;
use common::compare;
use motion::units::Vector;
use motion::{Drag, Gravity, METHODS, Method, PhysicsBody, Stepper, Threads, TimeStep, Transform};

const H: f64 = 1.0 / 120.0;
const C: f64 = 0.4;
const G: f64 = -9.8;

fn start(i: usize) -> ([f64; 3], [f64; 3], f64) {
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let at = i as f64;
    let movable = i % 64 != 63;
    (
        [at, 10.0, -at],
        if movable { [1.0, 2.0, 3.0] } else { [0.0; 3] },
        if movable { 10.0 } else { 0.0 },
    )
}

struct Ecs {
    world: World,
    stepper: Stepper,
}

impl Ecs {
    fn new(method: Method, n: usize) -> Self {
        let mut world = World::new();
        world.insert_resource(Gravity::new(Vector::new(0.0, G, 0.0)));
        world.insert_resource(Drag::new(C, 0.0));
        let body = |(x, v, inverse_mass): ([f64; 3], [f64; 3], f64)| {
            (
                Transform::at(Vector::from_array(x)),
                PhysicsBody { velocity: Vector::from_array(v), inverse_mass },
            )
        };
        world.spawn_batch((0..n).map(start).map(body).collect::<Vec<_>>());
        let stepper = Stepper::new(&mut world, method, TimeStep(H));
        Self { world, stepper }
    }

    fn tick(&mut self) {
        self.stepper.tick(&mut self.world);
    }
}

/// A step after 2,000 s of nothing but drag beside a fresh one, which does not grow old in the measurement.
fn decayed() {
    for claims in METHODS.iter() {
        let n = 1_000;
        let [mut fresh, mut old] = [0; 2].map(|_| {
            let mut ecs = Ecs::new(claims.method, n);
            ecs.world.remove_resource::<Gravity>();
            ecs
        });
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of ticks"
        )]
        let ticks = (2_000.0 / H) as u64;
        (0..ticks).for_each(|_| old.tick());
        compare(
            n,
            claims.name,
            &[None, Some(1.1)],
            vec![
                ("fresh", Box::new(|| fresh.tick())),
                ("after 2,000 s of drag", Box::new(|| old.tick())),
            ],
        );
    }
}

/// One thread against two, by the wall clock: the shortest of many rounds, because others use the machine too.
fn threads() {
    println!("\none thread over two, shortest of 15 interleaved rounds of 10 ticks, wall clock");
    for method in [Method::SemiImplicitEuler, Method::RungeKutta4] {
        let n = 1_000_000;
        let (mut one, mut two) = (Ecs::new(method, n), Ecs::new(method, n));
        two.world.insert_resource(Threads::new(2));
        let mut shortest = [f64::INFINITY; 2];
        for _ in 0..15 {
            for (ecs, shortest) in [&mut one, &mut two].into_iter().zip(&mut shortest) {
                let clock = Instant::now();
                (0..10).for_each(|_| ecs.tick());
                *shortest = shortest.min(clock.elapsed().as_secs_f64());
            }
        }
        let ratio = shortest[0] / shortest[1];
        let held = if ratio >= 1.35 { "held" } else { "MISSED" };
        println!("{:>22} {n:>9}  {ratio:6.3}  reach 1.35: {held}", method.name());
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(place) = arguments.iter().position(|argument| argument == "--steps") {
        let [method, bodies, steps] = &arguments[place + 1..place + 4] else {
            panic!("METHOD BODIES STEPS")
        };
        let method = Method::from_name(method).expect("a method");
        let mut ecs = Ecs::new(method, bodies.parse().expect("a number"));
        (0..steps.parse().expect("a number")).for_each(|_: u32| ecs.tick());
        return;
    }
    if !arguments.iter().any(|argument| argument == "--test") {
        decayed();
        threads();
    }
}
