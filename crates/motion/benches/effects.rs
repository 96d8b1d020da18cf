//! What an effect that is not there costs: nothing.
//!
//! `-- --steps WHAT BODIES STEPS` does nothing but steps of free bodies under gravity, for an instruction counter;
//! `scripts/absent-effects` counts and compares. WHAT is one of
//!
//! - `scene`: what a scene without any other effect runs, compiled by its stepper;
//! - `only`: a schedule of gravity's systems alone, put together by hand: nothing else is linked into the step;
//! - `off`: a scene that declares every effect and has all but gravity switched off.
//!
//! Without arguments it measures how long switching an effect takes, compiling the schedule again included, and what
//! births and static bodies cost a step.

use std::hint::black_box;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use cpu_time::ThreadTime;
use motion::effects::Effect;
use motion::internals::{
    apply_forces, clear_forces, insert_step_resources, integrate_in_one_pass, quarantine_bodies,
};
use motion::methods::SemiImplicitEuler;
use motion::units::Vector;
use motion::{
    AxisLocks, Damping, Dormant, Drag, Elastic, Emitter, Gravity, Method, MutualGravity,
    PhysicsBody, Request, Requests, SpeedLimit, Spring, StableId, Stepper, TimeStep, Transform,
    Well, Wells, Wind,
};

const H: f64 = 1.0 / 120.0;

/// Least thread CPU time of `what`, microseconds.
fn least(rounds: usize, mut what: impl FnMut()) -> f64 {
    (0..rounds)
        .map(|_| {
            let start = ThreadTime::now();
            what();
            start.elapsed().as_secs_f64() * 1e6
        })
        .fold(f64::INFINITY, f64::min)
}

fn free_bodies(count: u32) -> (World, Vec<Entity>) {
    let mut world = World::new();
    world.insert_resource(Gravity::EARTH);
    let bodies = (0..count)
        .map(|id| {
            let at = Transform::at(Vector::new(f64::from(id), 10.0, 0.0));
            world.spawn((StableId(id), at, PhysicsBody::with_mass(0.1))).id()
        })
        .collect();
    (world, bodies)
}

/// Free bodies in a scene that declares every effect; some of them are joined, limited and locked.
fn everything(count: u32) -> (World, Stepper) {
    let (mut world, bodies) = free_bodies(count);
    world.insert_resource(Damping::TUTORIAL);
    world.insert_resource(Drag::new(0.1, 0.01).in_wind(Wind::new(Vector::X).gusting(1.0, 1.0)));
    world.insert_resource(Wells(vec![Well::new(Vector::ZERO, 1.0).softened(1.0)]));
    let elastic = Elastic::new(10.0, 1.0).damped(0.1);
    for pair in bodies.chunks_exact(2) {
        world.spawn(Spring { ends: [pair[0], pair[1]], elastic });
    }
    for body in bodies.iter().step_by(10) {
        world
            .entity_mut(*body)
            .insert((SpeedLimit(100.0), AxisLocks { z: true, ..AxisLocks::default() }));
    }
    world.insert_resource(MutualGravity::new(1e-6, 1.0));
    let stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(H));
    (world, stepper)
}

fn switch(world: &mut World, stepper: &mut Stepper, effect: Effect, on: bool) {
    world.resource_mut::<Requests>().ask(Request::Switch(effect, on));
    stepper.carry_out_requests(world);
    stepper.recompile(world);
}

const SWITCHED: [Effect; 8] = [
    Effect::MutualGravity,
    Effect::Springs,
    Effect::Damping,
    Effect::Wind,
    Effect::Drag,
    Effect::Wells,
    Effect::SpeedLimits,
    Effect::AxisLocks,
];

fn steps(what: &str, bodies: u32, steps: u32) {
    match what {
        "scene" => {
            let (mut world, _) = free_bodies(bodies);
            let mut stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(H));
            (0..steps).for_each(|_| stepper.tick(&mut world));
            black_box(world);
        }
        "off" => {
            let (mut world, mut stepper) = everything(bodies);
            SWITCHED.iter().for_each(|effect| switch(&mut world, &mut stepper, *effect, false));
            (0..steps).for_each(|_| stepper.tick(&mut world));
            black_box(world);
        }
        "only" => {
            let (mut world, _) = free_bodies(bodies);
            insert_step_resources(&mut world, TimeStep(H));
            let mut schedule = Schedule::default();
            schedule.set_executor(SingleThreadedExecutor::new());
            schedule.add_systems(
                (
                    apply_forces,
                    integrate_in_one_pass::<SemiImplicitEuler>,
                    clear_forces,
                    quarantine_bodies,
                )
                    .chain(),
            );
            (0..steps).for_each(|_| schedule.run(&mut world));
            black_box(world);
        }
        _ => eprintln!("{what} is none of scene, off, only"),
    }
}

/// A step of so many living particles, with births and deaths and without.
fn births(count: usize, rate: f64, life: f64) {
    let mut world = World::new();
    world.insert_resource(Gravity::EARTH);
    let body = PhysicsBody::with_mass(1.0);
    let pool =
        (0..count).map(|_| world.spawn((Transform::default(), body, Dormant)).id()).collect();
    let launches = vec![Vector::Y; count];
    let mut emitter = Emitter::new(rate, life, launches);
    emitter.pool = pool;
    world.spawn(emitter);
    let mut stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(H));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a few seconds of ticks"
    )]
    (0..(life / H * 1.5) as u64).for_each(|_| stepper.tick(&mut world));
    let with = least(100, || stepper.tick(&mut world));
    let mut still = World::new();
    still.insert_resource(Gravity::EARTH);
    still.spawn_batch((0..count).map(move |_| (Transform::default(), body)));
    let mut stepper = Stepper::new(&mut still, Method::SemiImplicitEuler, TimeStep(H));
    let without = least(100, || stepper.tick(&mut still));
    println!(
        "{count} particles, {rate} births a second: {with:.0} us a step, without births {without:.0} us"
    );
}

/// A step beside so many bodies that are immovable and at rest.
fn statics(count: usize) {
    let time = |walls: usize| {
        let mut world = World::new();
        world.insert_resource(Gravity::EARTH);
        let body = PhysicsBody::with_mass(1.0).moving_at(Vector::X);
        world.spawn_batch((0..1_000).map(move |_| (Transform::default(), body)));
        world.spawn_batch((0..walls).map(|_| (Transform::default(), PhysicsBody::IMMOVABLE)));
        let mut stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(H));
        (0..10).for_each(|_| stepper.tick(&mut world));
        least(2_000, || stepper.tick(&mut world))
    };
    println!(
        "1000 bodies: {:.2} us a step, beside {count} static ones {:.2} us",
        time(0),
        time(count)
    );
}

/// Off and on, each with the new schedule.
fn switching(count: u32) {
    println!("switching at {count} bodies with every effect, microseconds, reach 1000");
    for effect in SWITCHED {
        let (mut world, mut stepper) = everything(count);
        (0..3).for_each(|_| stepper.tick(&mut world));
        let mut on = true;
        let time = least(40, || {
            on = !on;
            switch(&mut world, &mut stepper, effect, on);
        });
        println!(
            "  {:<16} {time:8.1}  {}",
            effect.name(),
            if time < 1e3 { "held" } else { "MISSED" }
        );
    }
}

fn main() {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    if let [flag, what, bodies, count] = &arguments[..]
        && flag == "--steps"
    {
        return steps(what, bodies.parse().expect("bodies"), count.parse().expect("steps"));
    }
    switching(1_000);
    births(100_000, 33_000.0, 3.0);
    statics(100_000);
}
