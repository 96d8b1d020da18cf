//! What an installed stepper has beside its ticks: a ledger, removed components, and other schedules and steppers.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::clock::StepClock;
use motion::ledger::{Ledger, LedgerTotals};
use motion::{
    Gravity, Method, PhysicsBody, PushQueue, Request, Requests, StepSystems, Stepper, TimeStep,
    Transform,
};

use super::{Reference, example, state};

/// A world in which a ball falls.
fn falling() -> (World, Entity) {
    let (mut world, ball) = super::ball();
    world.insert_resource(Gravity::EARTH);
    (world, ball)
}

/// A ledger's totals: each of them, so that what is added to the totals is compared, too.
fn totals(ledger: &Ledger) -> [LedgerTotals; 3] {
    [ledger.last_tick().clone(), ledger.since_opening().clone(), ledger.last_second()]
}

#[test]
fn the_ledger_of_an_installed_stepper_is_that_of_a_stepper() {
    #[derive(Resource, Default)]
    struct Paused(bool);
    for method in Method::ALL {
        let mut reference = Reference::new(method);
        let mut ledger = Ledger::open(&reference.world);
        let (mut world, mut schedule) = example::embed(method);
        Ledger::install(&mut schedule);
        world.init_resource::<Paused>();
        schedule.configure_sets(StepSystems::Tick.run_if(|paused: Res<Paused>| !paused.0));
        for tick in 0..90 {
            for world in [&mut world, &mut reference.world].into_iter().filter(|_| tick == 30) {
                let body = world.query_filtered::<Entity, With<PhysicsBody>>().iter(world).nth(1);
                world.resource_mut::<PushQueue>().push_once(body.unwrap(), DVec3::Y * 30.0);
                let faster = Request::SetVelocity(body.unwrap(), DVec3::Z);
                world.resource_mut::<Requests>().ask(faster);
            }
            // Nothing moves, and nothing is entered, while the physics is paused.
            world.insert_resource(Paused(tick == 40));
            schedule.run(&mut world);
            reference.forces.run(&mut reference.world);
            if tick != 40 {
                ledger.tick(&mut reference.stepper, &mut reference.world);
            }
            let kept = world.resource::<Ledger>();
            assert_eq!(totals(kept), totals(&ledger), "{method:?}, tick {tick}");
            assert_eq!(kept.energies(), ledger.energies());
            assert_eq!(kept.relative_residual().to_bits(), ledger.relative_residual().to_bits());
        }
        assert!(ledger.since_opening().energy.pushes.abs() > 0.01, "{method:?}");
        assert_eq!(state(&mut world), state(&mut reference.world), "{method:?}");
        // A ledger that is taken away is opened again.
        world.remove_resource::<Ledger>();
        schedule.run(&mut world);
        assert!((world.resource::<Ledger>().seconds() / example::STEP.0 - 1.0).abs() < 1e-9);
    }
}

#[test]
fn a_stepper_that_is_installed_again_moves_everything_once() {
    let (mut world, _) = falling();
    let (mut here, mut there) = (Schedule::default(), Schedule::default());
    Stepper::new(&mut world, Method::default(), TimeStep(0.01)).install(&mut world, &mut here);
    Ledger::install(&mut here);
    let mut ticks = 0;
    let mut after = |world: &mut World, schedule: &mut Schedule, more: u64| {
        schedule.run(world);
        ticks += more;
        assert_eq!(world.resource::<StepClock>().ticks(), ticks);
        let ball = world.query::<&PhysicsBody>().single(world).unwrap();
        let fallen = Gravity::EARTH.acceleration * (0.01 * ticks as f64);
        assert!((ball.velocity - fallen).length() < 1e-12, "{} after {ticks}", ball.velocity);
    };
    after(&mut world, &mut here, 1);
    for _ in 0..2 {
        let stepper = Stepper::uninstall(&mut world);
        assert!(!Stepper::is_installed(&world));
        after(&mut world, &mut here, 0);
        stepper.install(&mut world, &mut here);
        after(&mut world, &mut here, 1);
    }
    Stepper::uninstall(&mut world).install(&mut world, &mut there);
    after(&mut world, &mut here, 0);
    after(&mut world, &mut there, 1);
    Stepper::uninstall(&mut world).install(&mut world, &mut here);
    after(&mut world, &mut there, 0);
    after(&mut world, &mut here, 1);
}

#[test]
fn ticks_leave_the_components_that_a_game_removed_to_its_systems() {
    #[derive(Component)]
    struct Tag;
    #[derive(Resource, Default)]
    struct Seen(usize);
    let mut world = World::new();
    example::spawn(&mut world);
    let mut stepper = Stepper::new(&mut world, Method::default(), example::STEP);
    let mut game = Schedule::default();
    game.add_systems(|mut gone: RemovedComponents<Tag>, mut seen: ResMut<Seen>| {
        seen.0 += gone.read().count();
    });
    world.init_resource::<Seen>();
    let tagged = [world.spawn(Tag).id(), world.spawn(Tag).id()];
    for body in tagged {
        world.despawn(body);
        // Particles are born in each of them.
        (0..3).for_each(|_| stepper.tick(&mut world));
    }
    game.run(&mut world);
    assert_eq!(world.resource::<Seen>().0, 2);
}

#[test]
fn steppers_that_take_turns_begin_with_velocities_of_the_time_of_the_positions() {
    // Falls g t²/2 for methods that are exact for a constant acceleration.
    let exact = [Method::PositionVerlet, Method::VelocityVerlet, Method::RungeKutta4];
    for first in exact {
        for second in exact {
            for hz in [100_u32, 1000] {
                let (mut world, ball) = falling();
                let step = TimeStep(1.0 / f64::from(hz));
                let start = world.get::<Transform>(ball).unwrap().position;
                let mut steppers = [first, second].map(|m| Stepper::new(&mut world, m, step));
                for tick in 0..hz {
                    if tick == hz / 2 {
                        // A new one in its place.
                        steppers[0] = Stepper::new(&mut world, first, step);
                    }
                    steppers[tick as usize / 7 % 2].tick(&mut world);
                }
                let fallen = world.get::<Transform>(ball).unwrap().position - start;
                let off = (fallen - Gravity::EARTH.acceleration / 2.0).length();
                assert!(off < 1e-9, "{first:?} and {second:?} at {hz} Hz: {off} m");
            }
        }
    }
}
