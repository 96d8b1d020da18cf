//! Emitters: births and deaths at the right times and places, at every step size, from a fixed pool.

use std::collections::BTreeSet;

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::effects::Effect;
use motion::units::Vector;
use motion::{
    Dormant, Emission, Emitter, Gravity, Method, PhysicsBody, PreviousPosition, Request, StableId,
    Threads, Transform, Well, Wells,
};

use crate::rigs::{H, Lab};

pub(super) const AT: Vector = Vector::new(1.0, 2.0, 3.0);

pub(super) fn launch(slot: usize) -> Vector {
    Vector::new(0.1 * (slot % 7) as f64, 6.0, 0.01 * slot as f64)
}

/// An emitter whose pool of `count` is the bodies; `prepare` adds to the world before it has a stepper.
pub(super) fn fountain(
    count: usize,
    rate: f64,
    life: f64,
    method: Method,
    h: f64,
    prepare: impl FnOnce(&mut World),
) -> (Lab, Entity) {
    let mut world = World::new();
    let pool: Vec<_> = (0..count)
        .map(|slot| {
            let id = StableId(u32::try_from(slot).unwrap());
            world.spawn((id, Transform::at(AT), PhysicsBody::with_mass(0.5), Dormant)).id()
        })
        .collect();
    let launches = (0..count).map(launch).collect();
    let bodies = pool.clone();
    let emitter = Emitter { rate, life, position: AT, pool, launches, inverse_mass: 2.0 };
    let emitter = world.spawn(emitter).id();
    prepare(&mut world);
    (Lab { bodies, ..Lab::of(world, method, h) }, emitter)
}

/// The same by velocity Verlet, with nothing else in the world.
fn verlet(count: usize, rate: f64, life: f64, h: f64) -> (Lab, Entity) {
    fountain(count, rate, life, Method::VelocityVerlet, h, |_| ())
}

/// Slots whose bodies live.
pub(super) fn living(lab: &Lab) -> BTreeSet<usize> {
    let lives =
        |body: Entity| lab.world.get_entity(body).is_ok_and(|body| !body.contains::<Dormant>());
    (0..lab.bodies.len()).filter(|slot| lives(lab.bodies[*slot])).collect()
}

/// Time of the scene, s.
pub(super) fn now(lab: &Lab) -> f64 {
    lab.world.resource::<StepClock>().scene_seconds()
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
        let (mut lab, emitter) = verlet(count, rate, life, h);
        for tick in 0..200_u32 {
            let numbers = expected(count as u64, rate, life, now(lab.run(1)));
            let slots: BTreeSet<_> =
                numbers.iter().map(|number| (number % count as u64) as usize).collect();
            assert_eq!(living(&lab), slots, "tick {tick} of {h} s, {rate} a second");
            assert_eq!(lab.world.get::<Emission>(emitter).unwrap().living(), slots.len());
        }
    }
}

#[test]
fn what_is_not_alive_rests_at_its_emitter_and_is_counted_by_nothing() {
    let gravity = |world: &mut World| world.insert_resource(Gravity::EARTH);
    let (mut lab, _) = fountain(4, 1.0, 0.5, Method::VelocityVerlet, 0.25, gravity);
    // Alive at the end of one of four ticks.
    assert_eq!(lab.run(16).counts(), (4, vec![("gravity", 4)]));
    assert!(living(&lab).is_empty());
    assert_eq!(lab.totals(), motion::Totals::default());
    assert!(lab.states().into_iter().all(|state| state == (AT, Vector::ZERO)));
}

#[test]
fn a_particle_takes_nothing_of_another_life_with_it() {
    // Methods that keep something from tick to tick; a particle that dies, and one that is born again while it lives.
    for method in [Method::PositionVerlet, Method::VelocityVerlet, Method::Yoshida4] {
        for life_s in [0.5, 1.5] {
            let laws = |world: &mut World| {
                world.insert_resource(Gravity::EARTH);
                let well = Well { position: AT + Vector::X, strength: 5.0, softening: 0.5 };
                world.insert_resource(Wells(vec![well]));
            };
            let (mut lab, _) = fountain(1, 1.0, life_s, method, 0.125, laws);
            let body = lab.bodies[0];
            let life = |lab: &mut Lab| {
                [(); 3].map(|()| {
                    let state = lab.push(body, Vector::Z).run(1).state(body);
                    (state, lab.world.get::<PhysicsBody>(body).unwrap().inverse_mass)
                })
            };
            let first = life(&mut lab);
            // To one that dies in this tick the push comes too late.
            lab.push(body, Vector::X * 1e3).run(1);
            assert_eq!(lab.world.get::<Dormant>(body).is_some(), life_s == 0.5);
            assert_eq!(life(lab.run(4)), first, "{method:?}, {life_s} s");
        }
    }
}

#[test]
fn a_particle_is_not_drawn_from_where_another_life_left_it() {
    let (mut lab, _) = fountain(1, 1.0, 0.5, Method::PositionVerlet, 0.125, |_| ());
    let body = lab.bodies[0];
    let before = |lab: &Lab| lab.world.get::<PreviousPosition>(body).unwrap().0;
    // Born in the first tick of eight, dead after four.
    for ticks in [3, 1, 4, 1] {
        lab.insert(body, PreviousPosition(Vector::splat(1e3)));
        lab.run(ticks);
        let tick = (now(&lab) / 0.125).round();
        assert_eq!(before(&lab), if tick == 8.0 { Vector::splat(1e3) } else { AT }, "tick {tick}");
    }
}

#[test]
fn an_emitter_that_comes_in_the_place_of_another_emits() {
    let (mut lab, emitter) = verlet(20, 50.0, 0.3, H);
    let world = &mut lab.run(12).world;
    let again = world.entity_mut(emitter).take::<Emitter>().unwrap();
    world.despawn(emitter);
    let world = &mut lab.run(2).world;
    let first = world.spawn(again.clone()).id();
    world.spawn(Emitter { rate: 25.0, pool: Vec::new(), ..again });
    assert_eq!(lab.run(12).world.get::<Emission>(first).unwrap().living(), 5);
}

#[test]
fn particles_of_an_emitter_that_is_gone_are_dormant() {
    type Act = fn(&mut World, Entity);
    let ends: [Act; 3] = [
        |world, emitter| assert!(world.despawn(emitter)),
        |world, emitter| {
            world.entity_mut(emitter).remove::<Emitter>();
        },
        |world, emitter| {
            motion::effects::switch(world, Effect::Emitters, false).unwrap();
            assert!(world.despawn(emitter));
        },
    ];
    for end in ends {
        let (mut lab, emitter) = verlet(20, 50.0, 0.3, H);
        assert!(living(lab.run(12)).len() > 3);
        end(&mut lab.world, emitter);
        let before = lab.run(1).states();
        assert!(living(&lab).is_empty());
        assert_eq!(lab.run(3).states(), before);
    }
}

#[test]
fn an_emitter_may_be_given_another_pool() {
    let (mut lab, emitter) = verlet(20, 50.0, 0.3, H);
    lab.run(12);
    let pool: Vec<_> = (0..4).map(|_| lab.world.spawn(PhysicsBody::with_mass(1.0)).id()).collect();
    let other =
        Emitter { pool: pool.clone(), ..lab.world.get::<Emitter>(emitter).unwrap().clone() };
    lab.world.entity_mut(emitter).insert(other);
    lab.run(40);
    assert!(living(&lab).is_empty());
    let above = |body: &Entity| lab.world.get::<Transform>(*body).unwrap().position.y > AT.y;
    assert!(pool.iter().all(above), "each of them was born");
}

#[test]
fn bodies_of_a_pool_wait_for_their_birth_whether_spawned_dormant_or_not() {
    let run = |prepare: fn(&mut World)| {
        let (mut lab, _) = fountain(20, 50.0, 0.3, Method::VelocityVerlet, H, prepare);
        (living(&lab), lab.run(9).states(), living(&lab))
    };
    let awake = run(|world| {
        world.insert_resource(Gravity::EARTH);
        for body in world.query_filtered::<Entity, With<Dormant>>().iter(world).collect::<Vec<_>>()
        {
            world.entity_mut(body).remove::<Dormant>();
        }
    });
    assert!(awake.0.is_empty() && !awake.2.is_empty());
    assert_eq!(awake, run(|world| world.insert_resource(Gravity::EARTH)));
}

#[test]
fn slots_of_removed_and_quarantined_bodies_stay_empty() {
    let (mut lab, _) = verlet(3, 10.0, 0.2, 0.1);
    lab.run(1);
    lab.ask(Request::Remove(lab.bodies[1]));
    lab.ask(Request::SetVelocity(lab.bodies[0], Vector::NAN));
    let quarantined = lab.run(1).x(0);
    assert_eq!(lab.run(20).x(0), quarantined);
    assert!(lab.world.get_entity(lab.bodies[1]).is_err());
    assert_eq!(lab.records().len(), 1);
}

#[test]
fn a_scene_that_restarts_emits_again() {
    let (mut lab, _) = verlet(20, 50.0, 0.3, H);
    lab.run(30);
    let (first, slots) = (lab.all_bits(&[]), living(&lab));
    lab.run(17).world.resource_mut::<StepClock>().begin_scene();
    lab.run(30);
    assert_eq!(living(&lab), slots);
    assert_eq!(lab.all_bits(&[]), first);
}

#[test]
fn particles_of_an_emitter_that_is_switched_off_live_out_their_lives_and_then_no_system_is_left() {
    let (mut lab, emitter) = verlet(50, 100.0, 0.2, H);
    let emits =
        |lab: &Lab| lab.stepper.systems().iter().any(|system| system.contains("emit_particles"));
    assert!(emits(lab.run(60)));
    lab.ask(Request::Switch(Effect::Emitters, false));
    let alive = |lab: &Lab| lab.world.get::<Emission>(emitter).unwrap().living();
    let before = alive(&lab);
    lab.run(12);
    assert!(alive(&lab) > 0 && alive(&lab) < before && emits(&lab));
    assert_eq!(alive(lab.run(15)), 0);
    assert!(!emits(lab.run(1)) && !lab.stepper.plan().emits);
    // Nothing is made up for when it continues.
    lab.ask(Request::Switch(Effect::Emitters, true));
    assert!(emits(lab.run(1)));
    assert!(alive(&lab) <= 1, "{}", alive(&lab));
    lab.run(12);
    assert!((9..=11).contains(&alive(&lab)), "{}", alive(&lab));
}

#[test]
fn a_large_fountain_comes_out_the_same_with_any_number_of_threads() {
    let run_with = |threads| {
        let prepare = |world: &mut World| {
            world.insert_resource(Gravity::EARTH);
            world.insert_resource(Threads::new(threads));
        };
        let (mut lab, _) = fountain(30_000, 33_000.0, 0.8, Method::VelocityVerlet, H, prepare);
        lab.run(110).all_bits(&[])
    };
    let one = run_with(1);
    assert_eq!(one.len(), 30_000);
    assert!(one == run_with(2));
}
