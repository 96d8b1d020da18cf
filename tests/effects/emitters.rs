//! Emitters: births and deaths at the right times and places, at every step size, from a fixed pool.

use std::collections::BTreeSet;

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::effects::Effect;
use motion::snapshot::LastStep;
use motion::units::Vector;
use motion::{
    Dormant, Emission, Emitter, Evaluations, Gravity, Method, PhysicsBody, PreviousPosition, Request,
    Requests, StableId, Stepper, Threads, TimeStep, Transform,
};

use super::run;
use crate::harness::{H, close, world_bits};

pub(super) const AT: Vector = Vector::new(1.0, 2.0, 3.0);

pub(super) fn launch(slot: usize) -> Vector {
    Vector::new(0.1 * (slot % 7) as f64, 6.0, 0.01 * slot as f64)
}

/// An emitter with a pool of `count`.
pub(super) fn fountain(count: usize, rate: f64, life: f64) -> (World, Entity) {
    let mut world = World::new();
    let pool: Vec<_> = (0..count)
        .map(|slot| {
            let id = StableId(u32::try_from(slot).unwrap());
            world.spawn((id, Transform::at(AT), PhysicsBody::with_mass(0.5), Dormant)).id()
        })
        .collect();
    let launches = (0..count).map(launch).collect();
    let emitter = Emitter { rate, life, position: AT, pool, launches, inverse_mass: 2.0 };
    let emitter = world.spawn(emitter).id();
    (world, emitter)
}

fn stepper(world: &mut World, h: f64) -> Stepper {
    Stepper::new(world, Method::VelocityVerlet, TimeStep(h))
}

/// Slots whose bodies live.
pub(super) fn living(world: &World, emitter: Entity) -> BTreeSet<usize> {
    let pool = &world.get::<Emitter>(emitter).unwrap().pool;
    let lives = |body: Entity| world.get_entity(body).is_ok_and(|body| !body.contains::<Dormant>());
    (0..pool.len()).filter(|slot| lives(pool[*slot])).collect()
}

/// Numbers of the particles that live at `now`, the end of a tick: born before it, and not dead by then.
pub(super) fn expected(count: u64, rate: f64, life: f64, now: f64) -> Vec<u64> {
    let due = (now * rate - 1e-6).ceil() as u64;
    let lives = |number: &u64| *number as f64 / rate + life > now + 1e-6 / rate;
    (due.saturating_sub(count)..due).filter(lives).collect()
}

#[test]
fn particles_are_born_and_taken_back_on_time_at_every_step_size() {
    for (h, rate, life, count) in [
        (H, 100.0, 0.25, 40),
        (1.0 / 7.0, 100.0, 0.25, 10),
        (H, 10.0, 0.05, 3),
        (0.5, 3.0, 0.1, 2),
        (H, 120.0, 0.5, 60),
    ] {
        let (mut world, emitter) = fountain(count, rate, life);
        let mut steps = stepper(&mut world, h);
        for tick in 0..200_u32 {
            steps.tick(&mut world);
            let now = world.resource::<StepClock>().scene_seconds();
            let numbers = expected(count as u64, rate, life, now);
            let slots: BTreeSet<_> = numbers.iter().map(|number| (number % count as u64) as usize).collect();
            assert_eq!(living(&world, emitter), slots, "tick {tick} of {h} s, {rate} a second");
            assert_eq!(world.get::<Emission>(emitter).unwrap().living(), slots.len());
        }
    }
}

#[test]
fn what_is_not_alive_rests_at_its_emitter_and_is_counted_by_nothing() {
    let (mut world, emitter) = fountain(4, 1.0, 0.5);
    world.insert_resource(Gravity::EARTH);
    let mut steps = stepper(&mut world, 0.25);
    // Alive at the end of one of four ticks.
    run(&mut world, &mut steps, 16);
    assert_eq!(world.resource::<Evaluations>().accelerations(), 4);
    assert_eq!(world.resource::<Evaluations>().laws(), [("gravity", 4)]);
    assert!(living(&world, emitter).is_empty());
    assert_eq!(motion::totals(&mut world), motion::Totals::default());
    for body in &world.get::<Emitter>(emitter).unwrap().pool {
        assert_eq!(world.get::<Transform>(*body).unwrap().position, AT);
        assert_eq!(world.get::<PhysicsBody>(*body).unwrap().velocity, Vector::ZERO);
    }
}

#[test]
fn a_particle_takes_nothing_of_another_life_with_it() {
    let (mut world, emitter) = fountain(1, 1.0, 0.5);
    let body = world.get::<Emitter>(emitter).unwrap().pool[0];
    world.entity_mut(body).insert(PreviousPosition(AT));
    let mut steps = Stepper::new(&mut world, Method::PositionVerlet, TimeStep(0.125));
    world.insert_resource(Gravity::EARTH);
    run(&mut world, &mut steps, 3);
    let first = (*world.get::<Transform>(body).unwrap(), *world.get::<PhysicsBody>(body).unwrap());
    assert_eq!(world.get::<LastStep>(body), Some(&LastStep(0.125)));
    run(&mut world, &mut steps, 1);
    assert!(world.get::<Dormant>(body).is_some());
    assert_eq!(world.get::<PreviousPosition>(body), Some(&PreviousPosition(AT)));
    run(&mut world, &mut steps, 4 + 3);
    let second = (*world.get::<Transform>(body).unwrap(), *world.get::<PhysicsBody>(body).unwrap());
    assert_eq!(first, second);
    assert_eq!(world.get::<PreviousPosition>(body), Some(&PreviousPosition(AT)));
}

#[test]
fn an_emitter_that_comes_in_the_place_of_another_emits() {
    let (mut world, emitter) = fountain(20, 50.0, 0.3);
    let mut steps = stepper(&mut world, H);
    run(&mut world, &mut steps, 12);
    let again = world.entity_mut(emitter).take::<Emitter>().unwrap();
    world.despawn(emitter);
    run(&mut world, &mut steps, 2);
    let (first, second) =
        (world.spawn(again.clone()).id(), world.spawn(Emitter { rate: 25.0, ..again }).id());
    world.entity_mut(second).get_mut::<Emitter>().unwrap().pool.clear();
    run(&mut world, &mut steps, 12);
    assert_eq!(world.get::<Emission>(first).unwrap().living(), 5);
}

#[test]
fn a_clock_that_begins_again_leaves_no_births_behind() {
    let (mut world, emitter) = fountain(4, 4.0, 9.0);
    // Born in the middle of the tick.
    let body = world.get::<Emitter>(emitter).unwrap().pool[1];
    let mut steps = stepper(&mut world, 0.5);
    run(&mut world, &mut steps, 1);
    world.entity_mut(emitter).remove::<Emitter>();
    world.insert_resource(StepClock::default());
    let before = world.get::<Transform>(body).unwrap().position;
    run(&mut world, &mut steps, 1);
    let moved = world.get::<Transform>(body).unwrap().position - before;
    close(moved.y, 0.5 * launch(1).y, 1e-12);
}

#[test]
fn slots_of_removed_and_quarantined_bodies_stay_empty() {
    let (mut world, emitter) = fountain(3, 10.0, 0.2);
    let pool = world.get::<Emitter>(emitter).unwrap().pool.clone();
    let mut steps = stepper(&mut world, 0.1);
    run(&mut world, &mut steps, 1);
    world.resource_mut::<Requests>().ask(Request::Remove(pool[1]));
    world.resource_mut::<Requests>().ask(Request::SetVelocity(pool[0], Vector::NAN));
    run(&mut world, &mut steps, 1);
    let frozen = *world.get::<Transform>(pool[0]).unwrap();
    run(&mut world, &mut steps, 20);
    assert_eq!(*world.get::<Transform>(pool[0]).unwrap(), frozen);
    assert!(world.get_entity(pool[1]).is_err());
    assert_eq!(world.resource::<motion::Quarantine>().records().len(), 1);
}

#[test]
fn a_scene_that_begins_anew_emits_anew() {
    let (mut world, emitter) = fountain(20, 50.0, 0.3);
    let mut steps = stepper(&mut world, H);
    run(&mut world, &mut steps, 30);
    let (first, slots) = (world_bits(&mut world), living(&world, emitter));
    run(&mut world, &mut steps, 17);
    world.resource_mut::<StepClock>().begin_scene();
    run(&mut world, &mut steps, 30);
    assert_eq!(living(&world, emitter), slots);
    for ((_, a), (_, b)) in world_bits(&mut world).into_iter().zip(first) {
        // The scene's time is a difference of times by now.
        a.into_iter().zip(b).for_each(|(a, b)| close(f64::from_bits(a), f64::from_bits(b), 1e-12));
    }
}

#[test]
fn particles_of_an_emitter_that_is_switched_off_live_out_their_lives_and_then_no_system_is_left() {
    let (mut world, emitter) = fountain(50, 100.0, 0.2);
    let mut steps = stepper(&mut world, H);
    let emits = |steps: &Stepper| steps.systems().iter().any(|system| system.contains("emit_particles"));
    run(&mut world, &mut steps, 60);
    assert!(emits(&steps));
    world.resource_mut::<Requests>().ask(Request::Switch(Effect::Emitters, false));
    let alive = |world: &World| world.get::<Emission>(emitter).unwrap().living();
    let before = alive(&world);
    run(&mut world, &mut steps, 12);
    assert!(alive(&world) > 0 && alive(&world) < before && emits(&steps));
    run(&mut world, &mut steps, 15);
    assert_eq!(alive(&world), 0);
    run(&mut world, &mut steps, 1);
    assert!(!emits(&steps) && !steps.plan().emits);
    // Nothing is made up for when it goes on.
    world.resource_mut::<Requests>().ask(Request::Switch(Effect::Emitters, true));
    run(&mut world, &mut steps, 1);
    assert!(emits(&steps));
    assert!(alive(&world) <= 1, "{}", alive(&world));
    run(&mut world, &mut steps, 12);
    assert!((9..=11).contains(&alive(&world)), "{}", alive(&world));
}

#[test]
fn a_large_fountain_comes_out_the_same_with_any_number_of_threads() {
    let run_with = |threads| {
        let (mut world, _) = fountain(30_000, 33_000.0, 0.8);
        world.insert_resource(Gravity::EARTH);
        world.insert_resource(Threads::new(threads));
        let mut steps = stepper(&mut world, H);
        run(&mut world, &mut steps, 110);
        world_bits(&mut world)
    };
    let one = run_with(1);
    assert_eq!(one.len(), 30_000);
    assert!(one == run_with(2));
}
