//! `motion` in an `App` without a window: balls fall through damped air, one is pushed, two hang on a spring, with a ledger.
//! At the end the same run by `Stepper::tick`, without an app, must have the same bits.
//!
//! Run with `cargo run --manifest-path examples/bevy/Cargo.toml`.

use bevy_app::FixedMain;
use bevy_app::prelude::*;
use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce;
use motion::clock::StepClock;
use motion::ledger::{Ledger, LedgerPlugin};
use motion::units::Vector;
use motion::{
    Damping, Elastic, Forces, Gravity, InertiaPlugin, Method, PhysicsBody, PushQueue, Spring,
    StableId, StepSystems, Stepper, TimeStep, Transform,
};

const TICKS: u64 = 64;
const TICKS_PER_FRAME: u64 = 2;

#[derive(Component)]
struct Name(&'static str);

fn spawn(mut commands: Commands) {
    commands.insert_resource(Gravity::EARTH);
    commands.insert_resource(Damping::TUTORIAL);
    let mut ball = |number: u32, name, x| {
        let body = (Transform::at(Vector::new(x, 10.0, 0.0)), PhysicsBody::with_mass(1.0));
        commands.spawn((StableId(number), Name(name), body)).id()
    };
    ball(0, "free", 0.0);
    ball(1, "pushed", 2.0);
    let ends = [ball(2, "left", 4.0), ball(3, "right", 6.0)];
    commands.spawn(Spring { ends, elastic: Elastic::new(20.0, 1.0).damped(0.1) });
}

/// 60 N upward for one tick, as a click would.
fn push(clock: Res<StepClock>, mut queue: ResMut<PushQueue>, bodies: Query<(Entity, &Name)>) {
    if clock.ticks() == 16 {
        let pushed = bodies.iter().filter(|(_, name)| name.0 == "pushed");
        pushed.for_each(|(body, _)| queue.push_once(body, Vector::Y * 60.0));
    }
}

/// A wind that grows.
fn blow(clock: Res<StepClock>, mut forces: Forces, bodies: Query<Entity, With<PhysicsBody>>) {
    bodies.iter().for_each(|body| forces.add(body, Vector::Z * clock.seconds()));
}

fn watch(clock: Res<StepClock>, bodies: Query<(&Name, &Transform, &PhysicsBody)>) {
    if clock.ticks().is_multiple_of(16) {
        for (Name(name), Transform { position }, body) in &bodies {
            let (seconds, [x, y, z]) = (clock.seconds(), position.to_array());
            println!(
                "{seconds:.2} s {name:>7} at {x:.3} {y:.3} {z:.3} m, {:.3} m/s",
                body.velocity.length()
            );
        }
    }
}

/// Stands for Bevy's `TimePlugin`, which runs [`FixedMain`] as often as the time that passed asks for.
fn pass_time(world: &mut World) {
    for _ in 0..TICKS_PER_FRAME {
        world.run_schedule(FixedMain);
    }
}

/// Bits of the position and velocity of each body, in order of their ids.
fn bits(world: &mut World) -> Vec<(StableId, [[u64; 3]; 2])> {
    let mut bodies = world.query::<(&StableId, &Transform, &PhysicsBody)>();
    let bits = |vector: Vector| vector.to_array().map(f64::to_bits);
    let rows =
        bodies.iter(world).map(|(id, at, body)| (*id, [bits(at.position), bits(body.velocity)]));
    let mut rows: Vec<_> = rows.collect();
    rows.sort_unstable_by_key(|(id, _)| *id);
    rows
}

fn main() {
    let mut app = App::new();
    app.add_plugins((InertiaPlugin::default(), LedgerPlugin::default()))
        .add_systems(Startup, spawn)
        .add_systems(RunFixedMainLoop, pass_time.in_set(RunFixedMainLoopSystems::FixedMainLoop))
        .add_systems(
            FixedUpdate,
            (
                push.before(StepSystems::ApplyForces),
                blow.before(StepSystems::Integrate),
                watch.after(StepSystems::Quarantine),
            ),
        );
    for _ in 0..TICKS / TICKS_PER_FRAME {
        app.update();
    }
    assert_eq!(app.world().resource::<StepClock>().ticks(), TICKS);
    let ledger = app.world().resource::<Ledger>();
    println!("the method invented {:.3} J", ledger.since_opening().energy.residual);

    let mut world = World::new();
    world.run_system_once(spawn).unwrap();
    let mut stepper = Stepper::new(&mut world, Method::default(), TimeStep(1.0 / 64.0));
    for _ in 0..TICKS {
        world.run_system_cached(push).unwrap();
        world.run_system_cached(blow).unwrap();
        stepper.tick(&mut world);
    }
    let [in_app, alone] = [bits(app.world_mut()), bits(&mut world)];
    assert_eq!(in_app, alone);
    // The push and the spring did something.
    let position = |body: usize, axis: usize| f64::from_bits(in_app[body].1[0][axis]);
    assert!(position(1, 1) > position(0, 1) + 0.5);
    assert!((position(3, 0) - position(2, 0) - 2.0).abs() > 0.1);
    println!("{TICKS} ticks in an App and by Stepper::tick: the same bits");
}
