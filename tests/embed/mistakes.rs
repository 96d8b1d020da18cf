//! Mistakes of programs that use `motion`: each is refused, or said, and leaves the world usable.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::clock::StepClock;
use motion::ledger::Ledger;
use motion::methods::{Integrator, RungeKutta4};
use motion::snapshot::{self, Mismatch, RestoreError, Snapshot};
use motion::{
    Damping, DampingRate, Drag, Elastic, Emitter, Evaluations, Forces, Gravity, Method,
    MutualGravity, OwnLaws, OwnSubsteps, PhysicsBody, PushQueue, Quarantine, Range, Request,
    Requests, RidingWell, SourceMass, SpeedLimit, Spring, StepSystems, Stepper, Substeps, TimeStep,
    Transform, Well, Wells, Wind,
};

use super::{ball, example, panic_of, state};
use crate::rigs::assert_expected;

/// Two bodies, a metre apart.
fn pair() -> (World, [Entity; 2]) {
    let mut world = World::new();
    let body = |x: f64| (Transform::at(DVec3::X * x), PhysicsBody::with_mass(1.0));
    let ends = [0.0, 1.0].map(|x| world.spawn(body(x)).id());
    (world, ends)
}

const ELASTIC: Elastic = Elastic::new(10.0, 0.5).damped(0.1);

fn emitter(pool: Vec<Entity>) -> Emitter {
    let launches = vec![DVec3::Y; pool.len()];
    Emitter { rate: 10.0, life: 1.0, position: DVec3::ZERO, pool, launches, inverse_mass: 1.0 }
}

#[test]
fn a_snapshot_is_refused_where_springs_or_the_integrator_are_others() {
    let (mut world, ends) = pair();
    let third = world.spawn(PhysicsBody::with_mass(1.0)).id();
    let spring = world.spawn(Spring { ends, elastic: ELASTIC }).id();
    let mut stepper = Stepper::new(&mut world, RungeKutta4::METHOD, TimeStep(0.01));
    stepper.tick(&mut world);
    let saved = snapshot::take(&world, &stepper);
    let refused =
        |world: &mut World, stepper: &mut Stepper| snapshot::restore(world, stepper, &saved).err();
    assert_eq!(refused(&mut world, &mut stepper), None);
    let stiffer = Elastic { stiffness: 2.0 * ELASTIC.stiffness, ..ELASTIC };
    world.entity_mut(spring).insert(Spring { ends, elastic: stiffer });
    assert_eq!(refused(&mut world, &mut stepper), Some(RestoreError::Springs));
    let elsewhere = Spring { ends: [ends[0], third], elastic: ELASTIC };
    world.entity_mut(spring).insert(elsewhere);
    assert_eq!(refused(&mut world, &mut stepper), Some(RestoreError::Springs));
    world.despawn(spring);
    assert_eq!(refused(&mut world, &mut stepper), Some(RestoreError::Springs));
    // A file keeps what they were.
    let file = saved.clone().with_names(|body| body.to_bits());
    let read: Snapshot<u64> = serde_json::from_str(&serde_json::to_string(&file).unwrap()).unwrap();
    let read = read.with_names(Entity::from_bits);
    let error = snapshot::restore(&mut world, &mut stepper, &read);
    assert_eq!(error, Err(RestoreError::Springs));
    // Another entity, but the same spring.
    world.spawn(Spring { ends, elastic: ELASTIC });
    assert_eq!(refused(&mut world, &mut stepper), None);
    // Any `Integrator` that a stepper is made of counts as one of your own.
    let mut mine = Stepper::of::<RungeKutta4>(&mut world, TimeStep(0.01));
    assert_eq!(refused(&mut world, &mut mine), Some(RestoreError::Integrator));
    let mut ours = snapshot::take(&world, &mine);
    assert_eq!(snapshot::restore(&mut world, &mut mine, &ours), Ok(()));
    ours.springs = None;
    assert_eq!(snapshot::restore(&mut world, &mut mine, &ours), Ok(()));
}

#[test]
fn a_well_needs_one_place_and_is_refused_on_its_carrier() {
    let (mut world, [planet, moon]) = pair();
    let well = RidingWell::new(planet, 1.0, 0.0);
    world.entity_mut(moon).insert(OwnLaws::new(vec![Box::new(well.clone())]));
    let mut stepper = Stepper::new(&mut world, Method::VelocityVerlet, TimeStep(1e-3));
    stepper.tick(&mut world);
    // mu / r² in the direction of the planet.
    let pulled = world.get::<PhysicsBody>(moon).unwrap().velocity.x;
    assert!((pulled + 1e-3).abs() < 1e-8, "{pulled}");
    let said = panic_of(|| {
        world.entity_mut(planet).insert(OwnLaws::new(vec![Box::new(well)]));
    });
    assert!(said.contains("rides on the body") && said.contains("give it to others"), "{said}");
}

#[test]
fn numbers_out_of_their_range_are_refused_with_the_range() {
    type Mistake = fn(&mut World, [Entity; 2]);
    fn insert(world: &mut World, body: Entity, component: impl Bundle) {
        world.entity_mut(body).insert(component);
    }
    let mistakes: [Mistake; 24] = [
        |world, ends| {
            world.spawn(Spring { ends, elastic: Elastic { stiffness: -50.0, ..ELASTIC } });
        },
        |world, ends| {
            world.spawn(Spring { ends, elastic: Elastic { damping: -1.0, ..ELASTIC } });
        },
        |world, ends| {
            world.spawn(Spring { ends, elastic: Elastic { rest_length: -1.0, ..ELASTIC } });
        },
        |world, [one, _]| insert(world, one, DampingRate::new(-3.0)),
        |world, _| world.insert_resource(Damping { rate: -3.0, ..Damping::TUTORIAL }),
        |world, [one, _]| {
            world.spawn(Emitter { inverse_mass: -1.0, ..emitter(vec![one]) });
        },
        |world, [one, _]| {
            world.spawn(Emitter { rate: 0.0, ..emitter(vec![one]) });
        },
        |world, [one, _]| {
            world.spawn(Emitter { rate: f64::INFINITY, ..emitter(vec![one]) });
        },
        |world, [one, _]| {
            world.spawn(Emitter { life: -1.0, ..emitter(vec![one]) });
        },
        |world, [one, _]| {
            world.spawn(Emitter { life: f64::NAN, ..emitter(vec![one]) });
        },
        |world, [one, _]| {
            world.spawn(Emitter { launches: Vec::new(), ..emitter(vec![one]) });
        },
        |world, [one, _]| {
            (0..2).for_each(|_| {
                world.spawn(emitter(vec![one]));
            });
        },
        |world, [one, _]| {
            world.spawn(emitter(vec![one, one]));
        },
        |world, _| world.insert_resource(Substeps(3_000_000)),
        |world, _| world.insert_resource(Substeps(0)),
        |world, [one, _]| insert(world, one, OwnSubsteps(3_000_000)),
        |world, [one, _]| insert(world, one, SpeedLimit(-1.0)),
        |world, _| world.insert_resource(Drag::new(-0.1, 0.0)),
        |world, _| world.insert_resource(Drag::new(0.0, -0.1)),
        |world, _| {
            let wind = Some(Wind { gust: -1.0, ..Wind::default() });
            world.insert_resource(Drag { wind, ..Drag::new(0.1, 0.0) });
        },
        |world, _| {
            let well = Well { position: DVec3::ZERO, strength: 1.0, softening: -0.1 };
            world.insert_resource(Wells(vec![well]));
        },
        |world, _| world.insert_resource(MutualGravity { constant: 1.0, softening: -0.1 }),
        |world, _| {
            world.insert_resource(MutualGravity { constant: 1.0, softening: 0.1 });
            world.spawn((PhysicsBody::IMMOVABLE, SourceMass(-2.0)));
        },
        |world, _| world.insert_resource(Range { position: -1.0, ..Range::FINITE }),
    ];
    let said = mistakes.map(|mistake| {
        let (mut world, ends) = pair();
        let said = panic_of(|| {
            mistake(&mut world, ends);
            Stepper::new(&mut world, Method::default(), TimeStep(0.01)).tick(&mut world);
        });
        assert_eq!(world.get_resource::<StepClock>().map_or(0, StepClock::ticks), 0, "{said}");
        said + "\n"
    });
    assert_expected("numbers_out_of_range", &said.concat());
}

/// Log messages of all tests.
static LOGGED: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Log;

impl log::Log for Log {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        LOGGED.lock().unwrap().push(record.args().to_string());
    }

    fn flush(&self) {}
}

#[test]
fn a_spring_to_a_particle_is_told_once() {
    // Another test may have been first.
    let _ = log::set_logger(&Log);
    log::set_max_level(log::LevelFilter::Warn);
    let (mut world, ends) = pair();
    let particle = world.spawn(PhysicsBody::with_mass(1.0)).id();
    world.spawn(emitter(vec![particle]));
    world.spawn(Spring { ends, elastic: ELASTIC });
    let spring = world.spawn(Spring { ends: [ends[0], particle], elastic: ELASTIC }).id();
    let mut stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
    for _ in 0..3 {
        world.spawn(PhysicsBody::with_mass(1.0));
        stepper.tick(&mut world);
    }
    let words =
        format!("the spring {spring} is inert: its end {particle} is a particle of an emitter");
    let told = LOGGED.lock().unwrap().iter().filter(|line| line.contains(&words)).count();
    assert_eq!(told, 1);
}

#[test]
fn a_law_that_panics_leaves_the_stepper_in_its_world() {
    for installed in [false, true] {
        let (mut world, body) = ball();
        world.insert_resource(Gravity::EARTH);
        let mut schedule = Schedule::default();
        let stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
        // A range that no body is within is found in the tick.
        world.insert_resource(Range { position: 0.0, ..Range::FINITE });
        let mut own = (!installed).then_some(stepper);
        if installed {
            let stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
            stepper.install(&mut world, &mut schedule);
        }
        let mut tick = |world: &mut World| match &mut own {
            Some(stepper) => stepper.tick(world),
            None => schedule.run(world),
        };
        assert!(catch_unwind(AssertUnwindSafe(|| tick(&mut world))).is_err());
        world.remove_resource::<Range>();
        if installed {
            let method = Stepper::installed(&mut world, |stepper, _| stepper.method());
            assert_eq!(method, Method::default());
        }
        (0..3).for_each(|_| tick(&mut world));
        let ticks = world.resource::<StepClock>().ticks();
        // A schedule skips what ran before the panic in its next run.
        assert_eq!(ticks, if installed { 2 } else { 3 });
        let fallen = world.get::<PhysicsBody>(body).unwrap().velocity.y;
        assert!((fallen + 9.8 * 0.01 * ticks as f64).abs() < 1e-12, "{fallen}");
    }
}

#[test]
fn a_schedule_is_rebuilt_in_one_world() {
    let (mut world, body) = ball();
    world.insert_resource(Gravity::EARTH);
    Stepper::new(&mut world, Method::VelocityVerlet, TimeStep(0.01))
        .install(&mut world, &mut Schedule::default());
    let mut stepper = Stepper::uninstall(&mut world);
    assert_eq!(stepper.method(), Method::VelocityVerlet);
    stepper.tick(&mut world);
    let mut schedule = Schedule::default();
    stepper.install(&mut world, &mut schedule);
    (0..2).for_each(|_| schedule.run(&mut world));
    assert_eq!(world.resource::<StepClock>().ticks(), 3);
    assert!((world.get::<PhysicsBody>(body).unwrap().velocity.y + 9.8 * 0.03).abs() < 1e-12);
    let said =
        panic_of(|| Stepper::installed(&mut world, |_, world| drop(Stepper::uninstall(world))));
    assert!(said.contains("inside the closure of `Stepper::installed`"), "{said}");
    drop(Stepper::uninstall(&mut world));
    assert!(
        panic_of(|| drop(Stepper::uninstall(&mut world))).contains("call `Stepper::install` first")
    );
}

#[derive(Resource)]
struct Paused(bool);

#[test]
fn one_set_pauses_bodies_clock_emitters_engines_and_pushes() {
    let goes = |paused: Res<Paused>| !paused.0;
    for method in [Method::SemiImplicitEuler, Method::PositionVerlet, Method::RungeKutta4] {
        let (mut paused, mut schedule) = example::embed(method);
        paused.insert_resource(Paused(false));
        schedule.configure_sets(StepSystems::Tick.run_if(goes));
        let (mut world, mut other) = example::embed(method);
        let body = |world: &mut World| {
            world.query_filtered::<Entity, With<PhysicsBody>>().iter(world).next().unwrap()
        };
        let bodies = [body(&mut paused), body(&mut world)];
        for tick in 0..80 {
            paused.resource_mut::<Paused>().0 = true;
            let before = state(&mut paused);
            // What is pushed meanwhile waits.
            if tick == 20 {
                for (world, body) in [&mut paused, &mut world].into_iter().zip(bodies) {
                    world.resource_mut::<PushQueue>().push_once(body, DVec3::X * 100.0);
                }
            }
            let clock = *paused.resource::<StepClock>();
            (0..2).for_each(|_| schedule.run(&mut paused));
            assert_eq!((state(&mut paused), *paused.resource::<StepClock>()), (before, clock));
            paused.resource_mut::<Paused>().0 = false;
            schedule.run(&mut paused);
            other.run(&mut world);
            assert_eq!(paused.resource::<StepClock>().ticks(), tick + 1);
            assert_eq!(paused.resource::<StepClock>(), world.resource::<StepClock>());
        }
    }
}

#[test]
fn the_clock_waits_while_nothing_is_integrated() {
    let (mut world, body) = ball();
    world.insert_resource(Gravity::EARTH);
    let mut schedule = Schedule::default();
    Stepper::new(&mut world, Method::default(), TimeStep(0.01)).install(&mut world, &mut schedule);
    schedule.configure_sets(StepSystems::Integrate.run_if(|| false));
    (0..5).for_each(|_| schedule.run(&mut world));
    assert_eq!(world.resource::<StepClock>().ticks(), 0);
    assert_eq!(world.get::<PhysicsBody>(body).unwrap().velocity, DVec3::ZERO);
}

#[test]
fn a_snapshot_that_take_cannot_have_made_is_refused_and_changes_nothing() {
    let (mut world, ends) = pair();
    world.spawn(Spring { ends, elastic: ELASTIC });
    let particle = world.spawn(PhysicsBody::with_mass(1.0)).id();
    world.spawn(emitter(vec![particle]));
    let mut stepper = Stepper::new(&mut world, Method::PositionVerlet, TimeStep(0.01));
    (0..5).for_each(|_| stepper.tick(&mut world));
    let saved = snapshot::take(&world, &stepper);
    let stranger = world.spawn_empty().id();
    world.despawn(stranger);
    type Damage = fn(&mut Snapshot, Entity);
    let damages: [Damage; 13] = [
        |saved, _| saved.step = TimeStep(-1.0),
        |saved, _| saved.step = TimeStep(f64::NAN),
        |saved, _| saved.substeps = Substeps(0),
        |saved, _| {
            let body = saved.bodies[0];
            saved.own_substeps.push((body, OwnSubsteps(0)));
        },
        |saved, _| saved.transforms.truncate(1),
        |saved, _| saved.states.truncate(2),
        |saved, _| saved.states.push(PhysicsBody::IMMOVABLE),
        |saved, _| {
            let first = saved.bodies[0];
            saved.bodies.push(first);
            saved.transforms.push(Transform::default());
            saved.states.push(PhysicsBody::IMMOVABLE);
        },
        |saved, _| {
            let first = saved.last_steps[0];
            saved.last_steps.push(first);
        },
        |saved, _| {
            let first = saved.emissions[0].clone();
            saved.emissions.push(first);
        },
        |saved, stranger| saved.quarantined.push(stranger),
        |saved, stranger| saved.dormant.push(stranger),
        |saved, _| saved.effects.damping = Some(Damping { rate: -1.0, ..Damping::TUTORIAL }),
    ];
    let said = damages.map(|damage| {
        let mut damaged = saved.clone();
        damage(&mut damaged, stranger);
        let error = snapshot::restore(&mut world, &mut stepper, &damaged).unwrap_err();
        assert!(matches!(error, RestoreError::Invalid { .. }), "{error}");
        assert_eq!(snapshot::take(&world, &stepper), saved, "{error}");
        format!("{error}\n")
    });
    assert_expected("invalid_snapshots", &said.concat());
    snapshot::restore(&mut world, &mut stepper, &saved).unwrap();
    // A body that is gone is a mismatch, whatever it had; and an emitter is no body.
    world.entity_mut(saved.emissions[0].0).insert(PhysicsBody::with_mass(1.0));
    world.despawn(ends[0]);
    let error = snapshot::restore(&mut world, &mut stepper, &saved).unwrap_err();
    let RestoreError::Mismatch(Mismatch { missing, unknown }) = &error else { panic!("{error}") };
    assert_eq!((&missing[..], &unknown[..]), (&[ends[0]][..], &[saved.emissions[0].0][..]));
}

#[test]
#[cfg(debug_assertions)]
fn a_resource_that_was_removed_is_named() {
    fn remove<R: Resource>(world: &mut World) {
        world.remove_resource::<R>();
    }
    let message = |remove: fn(&mut World), install: bool| {
        let mut world = World::new();
        let mut schedule = Schedule::default();
        let mut stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
        if install {
            stepper.install(&mut world, &mut schedule);
            remove(&mut world);
            return panic_of(|| schedule.run(&mut world));
        }
        remove(&mut world);
        panic_of(|| stepper.tick(&mut world))
    };
    let removals: [(&str, fn(&mut World)); 6] = [
        ("TimeStep", remove::<TimeStep>),
        ("StepClock", remove::<StepClock>),
        ("Evaluations", remove::<Evaluations>),
        ("PushQueue", remove::<PushQueue>),
        ("Quarantine", remove::<Quarantine>),
        ("Requests", remove::<Requests>),
    ];
    for (name, remove) in removals {
        for install in [false, true] {
            let said = message(remove, install);
            assert!(said.contains(&format!("the resource `{name}` was removed")), "{said}");
        }
    }
}

#[test]
fn a_checksum_of_springs_tells_two_that_changed_places() {
    let mut world = World::new();
    let bodies = [0.0, 1.0, 2.0]
        .map(|x| world.spawn((Transform::at(DVec3::X * x), PhysicsBody::with_mass(1.0))).id());
    let springs = [[0, 1], [1, 2]].map(|ends| {
        let ends = ends.map(|end| bodies[end]);
        (world.spawn(Spring { ends, elastic: ELASTIC }).id(), ends)
    });
    let stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
    let mut sums = std::collections::BTreeSet::new();
    for a in 1..20 {
        for b in 1..20 {
            for ((spring, ends), stiffness) in springs.iter().zip([a, b]) {
                let elastic = Elastic { stiffness: f64::from(stiffness), ..ELASTIC };
                world.entity_mut(*spring).insert(Spring { ends: *ends, elastic });
            }
            assert!(sums.insert(snapshot::take(&world, &stepper).springs), "{a} and {b}");
        }
    }
}

#[test]
fn a_rollback_undoes_spawns_and_disables_of_bodies_springs_and_emitters() {
    let (mut world, ends) = pair();
    world.insert_resource(Gravity::EARTH);
    let hook = world.spawn(Spring { ends, elastic: ELASTIC }).id();
    let pool = vec![world.spawn(PhysicsBody::with_mass(1.0)).id()];
    let fountain = world.spawn(emitter(pool)).id();
    for method in Method::ALL {
        let mut stepper = Stepper::new(&mut world, method, TimeStep(0.01));
        (0..5).for_each(|_| stepper.tick(&mut world));
        let saved = snapshot::take(&world, &stepper);
        let mut run = |world: &mut World, change: bool| {
            let mut later = Vec::new();
            for tick in 0..30 {
                if change && tick == 3 {
                    let added = world.spawn(PhysicsBody::with_mass(1.0)).id();
                    world.spawn(Spring { ends: [ends[0], added], elastic: ELASTIC });
                    for entity in [ends[1], hook, fountain] {
                        world.entity_mut(entity).insert(Disabled);
                    }
                    let pool = vec![world.spawn(PhysicsBody::with_mass(1.0)).id()];
                    world.spawn(emitter(pool));
                }
                stepper.tick(world);
                later = snapshot::take(world, &stepper).transforms;
            }
            snapshot::roll_back(world, &mut stepper, &saved).unwrap();
            assert_eq!(snapshot::take(world, &stepper), saved, "{method:?}");
            later
        };
        let undisturbed = run(&mut world, false);
        assert_ne!(run(&mut world, true), undisturbed);
        assert_eq!(run(&mut world, false), undisturbed, "{method:?}");
    }
    // A pool: what waits disabled is used, and what was spawned since is disabled already.
    let mut stepper = Stepper::new(&mut world, Method::PositionVerlet, TimeStep(0.01));
    let waiting =
        world.spawn((Transform::at(DVec3::Y), PhysicsBody::with_mass(3.0), Disabled)).id();
    let unplaced = world.spawn(PhysicsBody::with_mass(1.0)).remove::<Transform>().id();
    let saved = snapshot::take(&world, &stepper);
    world.entity_mut(waiting).remove::<Disabled>();
    // A body may be a spring as well.
    world.entity_mut(ends[0]).insert(Spring { ends, elastic: ELASTIC });
    (0..5).for_each(|_| stepper.tick(&mut world));
    assert_ne!(world.get::<Transform>(waiting).unwrap().position, DVec3::Y);
    let later = world.spawn((PhysicsBody::with_mass(1.0), Disabled)).id();
    let error = snapshot::roll_back(&mut world, &mut stepper, &saved);
    assert_eq!(error, Err(RestoreError::Springs), "the body has a spring that it had not");
    world.entity_mut(ends[0]).remove::<Spring>();
    snapshot::roll_back(&mut world, &mut stepper, &saved).unwrap();
    assert_eq!(snapshot::take(&world, &stepper), saved);
    assert_eq!(world.get::<Transform>(waiting).unwrap().position, DVec3::Y);
    assert!(world.entity(waiting).contains::<Disabled>() && world.get_entity(later).is_err());
    // Without a place it is no body, then as now.
    assert!(world.get_entity(unplaced).is_ok());
    // What is despawned cannot come back.
    let mut stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
    let saved = snapshot::take(&world, &stepper);
    world.despawn(ends[0]);
    let error = snapshot::roll_back(&mut world, &mut stepper, &saved).unwrap_err();
    assert!(matches!(error, RestoreError::Mismatch(_)), "{error}");
}

#[test]
fn a_body_that_is_disabled_is_in_no_sum_and_costs_the_ledger_nothing() {
    let (mut world, [one, other]) = pair();
    world.insert_resource(Gravity::EARTH);
    let mut stepper = Stepper::new(&mut world, Method::VelocityVerlet, TimeStep(0.01));
    let mut ledger = Ledger::open(&world);
    let mut run = |world: &mut World| {
        for _ in 0..10 {
            ledger.tick(&mut stepper, world);
        }
        ledger.relative_residual()
    };
    assert!(run(&mut world) < 1e-9);
    world.entity_mut(one).insert(Disabled);
    let alone = motion::totals(&world);
    let kinetic = world.get::<PhysicsBody>(other).unwrap().kinetic_energy();
    assert!((alone.kinetic_energy - kinetic).abs() < 1e-12);
    assert!(run(&mut world) < 1e-9);
    world.entity_mut(one).remove::<Disabled>();
    assert!(run(&mut world) < 1e-9);
}

#[test]
fn a_force_on_a_disabled_body_is_over_when_it_is_enabled() {
    let (mut world, body) = ball();
    let mut stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
    let push = |world: &mut World| {
        world.run_system_cached_with(
            |In(body): In<Entity>, mut forces: Forces| forces.add(body, DVec3::X * 7.0),
            body,
        )
    };
    push(&mut world).unwrap();
    world.entity_mut(body).insert(Disabled);
    stepper.tick(&mut world);
    push(&mut world).unwrap();
    stepper.tick(&mut world);
    world.entity_mut(body).remove::<Disabled>();
    (0..3).for_each(|_| stepper.tick(&mut world));
    assert_eq!(world.get::<PhysicsBody>(body).unwrap().velocity, DVec3::ZERO);
}

#[test]
fn a_body_that_is_inserted_again_starts_its_method() {
    for method in Method::ALL {
        let end = |inserts: bool| {
            let (mut world, body) = ball();
            world.insert_resource(Gravity::EARTH);
            let mut stepper = Stepper::new(&mut world, method, TimeStep(0.01));
            (0..50).for_each(|_| stepper.tick(&mut world));
            let up = DVec3::new(1.0, 4.0, 0.0);
            if inserts {
                world.entity_mut(body).insert(PhysicsBody::with_mass(2.0).moving_at(up));
            } else {
                world.resource_mut::<Requests>().ask(Request::SetVelocity(body, up));
            }
            (0..50).for_each(|_| stepper.tick(&mut world));
            world.get::<Transform>(body).unwrap().position
        };
        assert_eq!(end(true), end(false), "{method:?}");
    }
}
