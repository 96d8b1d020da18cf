//! Snapshots of any world: put back in place, they continue with the same bits.

use bevy_ecs::entity::{EntityHashMap, MapEntities as _};
use bevy_ecs::prelude::*;
use history::Simulation;
use motion::snapshot::{self, Mismatch, RestoreError, Snapshot};
use motion::units::Vector;
use motion::{Forces, Method, PhysicsBody, Stepper, TimeStep, Transform};

use super::interventions::{TICKS, act};
use super::outcome;
use crate::rigs::{bits, mixed};

/// The tick after which no body is removed any more.
const FIRST: u64 = 8;

/// One tick with what is asked for in it, also of the method.
fn go_on(run: &mut Simulation, tick: u64) {
    let method = run.scene.method;
    match tick {
        22 => run.set_method(if method == Method::PositionVerlet {
            Method::Yoshida4
        } else {
            Method::PositionVerlet
        }),
        26 => run.set_method(method),
        _ => {}
    }
    run.tick();
}

/// With its lists in the order of entities: a body that has changed its method may be in another table until the next
/// tick.
fn sorted(mut saved: Snapshot) -> Snapshot {
    let rows = saved.transforms.iter().zip(&saved.states);
    let mut rows: Vec<_> =
        saved.bodies.iter().zip(rows).map(|(body, (at, state))| (*body, *at, *state)).collect();
    rows.sort_unstable_by_key(|(body, ..)| *body);
    // It names bodies by their place in the list.
    saved.springs = None;
    saved.bodies = rows.iter().map(|(body, ..)| *body).collect();
    saved.transforms = rows.iter().map(|(_, at, _)| *at).collect();
    saved.states = rows.iter().map(|(.., state)| *state).collect();
    saved.previous_positions.sort_unstable_by_key(|(body, _)| *body);
    saved.last_steps.sort_unstable_by_key(|(body, _)| *body);
    saved.own_methods.sort_unstable_by_key(|(body, _)| *body);
    saved.own_substeps.sort_unstable_by_key(|(body, _)| *body);
    saved.quarantined.sort_unstable();
    saved.dormant.sort_unstable();
    saved
}

#[test]
fn a_world_that_goes_back_in_place_goes_on_with_the_same_bits() {
    for method in Method::ALL {
        let mut scene = mixed();
        scene.method = method;
        let mut run = Simulation::new(scene);
        let mut saved = Vec::new();
        for tick in 0..TICKS {
            let before = snapshot::take(&run.world, &run.stepper);
            act(&mut run, tick);
            saved.push((tick, before, snapshot::take(&run.world, &run.stepper)));
            go_on(&mut run, tick);
        }
        let expected = outcome(&mut run);
        let again = run.bodies.len() as u64;
        saved.retain(|(tick, ..)| *tick >= FIRST);
        let restore = |run: &mut Simulation, saved: &Snapshot| {
            snapshot::restore(&mut run.world, &mut run.stepper, saved).unwrap();
        };
        // Far back and a little forward, and the other way round.
        let ends = saved.len() - 1;
        for place in (0..=ends).flat_map(|i| [i, ends - i]) {
            let (from, before, waiting) = &saved[place];
            restore(&mut run, before);
            assert_eq!(sorted(snapshot::take(&run.world, &run.stepper)), sorted(before.clone()));
            act(&mut run, *from);
            for inputs_wait in [false, true] {
                if inputs_wait {
                    restore(&mut run, waiting);
                }
                go_on(&mut run, *from);
                for tick in from + 1..TICKS {
                    act(&mut run, tick);
                    go_on(&mut run, tick);
                }
                let what = format!("{} from tick {from}, waiting: {inputs_wait}", method.name());
                outcome(&mut run).assert_restored(&expected, again, &what);
            }
        }
    }
}

/// A pendulum and a ball without ids, and the bodies in the order of spawning.
fn world() -> (World, [Entity; 3]) {
    let mut world = World::new();
    world.insert_resource(motion::Gravity::EARTH);
    let at = |x: f64| Transform::at(Vector::X * x);
    let post = world.spawn((at(0.0), PhysicsBody::IMMOVABLE)).id();
    let [bob, ball] = [1.5, 4.0].map(|x| world.spawn((at(x), PhysicsBody::with_mass(0.5))).id());
    let elastic = motion::Elastic::new(30.0, 1.0).damped(0.1);
    world.spawn(motion::Spring { ends: [post, bob], elastic });
    (world, [post, bob, ball])
}

#[test]
fn forces_that_wait_for_a_tick_are_saved() {
    let (mut world, [.., ball]) = world();
    let mut stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
    stepper.tick(&mut world);
    world
        .run_system_cached_with(
            |In(body): In<Entity>, mut forces: Forces| forces.add(body, Vector::Z),
            ball,
        )
        .unwrap();
    let saved = snapshot::take(&world, &stepper);
    let mut two_ticks = || {
        (0..2).for_each(|_| stepper.tick(&mut world));
        let state = bits(
            world.get::<Transform>(ball).unwrap().position,
            world.get::<PhysicsBody>(ball).unwrap().velocity,
        );
        snapshot::restore(&mut world, &mut stepper, &saved).unwrap();
        state
    };
    let first = two_ticks();
    assert_eq!(f64::from_bits(first[5]), 0.02);
    assert_eq!(two_ticks(), first);
}

#[test]
fn a_snapshot_of_other_bodies_is_refused_and_changes_nothing() {
    let (mut world, [post, bob, ball]) = world();
    let mut stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
    let saved = snapshot::take(&world, &stepper);
    stepper.tick(&mut world);
    world.despawn(ball);
    let other = world.spawn(PhysicsBody::with_mass(1.0)).id();
    let before = snapshot::take(&world, &stepper);
    let error = snapshot::restore(&mut world, &mut stepper, &saved).unwrap_err();
    let RestoreError::Mismatch(Mismatch { missing, unknown }) = &error else { panic!("{error}") };
    assert_eq!((&missing[..], &unknown[..]), (&[ball][..], &[other][..]));
    assert!(error.to_string().contains("lacks 1 bodies or emitters"), "{error}");
    assert_eq!(snapshot::take(&world, &stepper), before);
    // With the other body in the place of the one that is gone it is accepted.
    let mut renamed = saved;
    renamed.map_entities(&mut EntityHashMap::from_iter([(post, post), (bob, bob), (ball, other)]));
    snapshot::restore(&mut world, &mut stepper, &renamed).unwrap();
    assert_eq!(world.get::<Transform>(other).unwrap().position.x, 4.0);
    assert!(world.get_entity(post).is_ok() && world.get_entity(bob).is_ok());
}
