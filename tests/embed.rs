//! The physics in a schedule of one's own: the example of an outside crate, tick by tick beside a [`Stepper`].

mod disabled;
mod installing;
mod mistakes;

#[path = "../crates/motion/examples/embed.rs"]
#[allow(dead_code, reason = "what the example prints")]
mod example;

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::clock::StepClock;
use motion::effects::{Effect, EffectState};
use motion::internals::Groups;
use motion::snapshot;
use motion::{
    Damping, DampingModel, DampingRate, Dormant, Drag, Emission, Evaluations, Forces, Laws, Method,
    MutualGravity, PhysicsBody, PushQueue, Request, Requests, StableId, StepSystems, Stepper,
    TimeStep, Transform, Well, Wells,
};

use crate::rigs::{Bits, bits};

/// The bits of every body, in stable-id order, and who of them lives.
fn state(world: &mut World) -> Vec<(StableId, Bits, bool)> {
    let mut bodies = world.query::<(&StableId, &Transform, &PhysicsBody, Has<Dormant>)>();
    let row = |(id, at, body, dormant): (&StableId, &Transform, &PhysicsBody, bool)| {
        (*id, bits(at.position, body.velocity), dormant)
    };
    let mut rows: Vec<_> = bodies.iter(world).map(row).collect();
    rows.sort_by_key(|(id, ..)| *id);
    rows
}

/// The same world with a stepper; forces are added before each tick.
struct Reference {
    world: World,
    stepper: Stepper,
    forces: Schedule,
}

impl Reference {
    fn new(method: Method) -> Self {
        let mut world = World::new();
        example::spawn(&mut world);
        let stepper = Stepper::new(&mut world, method, example::STEP);
        let mut forces = Schedule::default();
        forces.add_systems(example::blow);
        Self { world, stepper, forces }
    }

    fn tick(&mut self) {
        self.forces.run(&mut self.world);
        self.stepper.tick(&mut self.world);
    }
}

#[test]
fn a_schedule_of_ones_own_has_the_bits_of_a_stepper_with_thrust_spring_and_emitter() {
    for method in Method::ALL {
        let mut reference = Reference::new(method);
        let (mut world, mut schedule) = example::embed(method);
        let start = state(&mut world);
        for tick in 0..120 {
            if tick == 30 {
                for world in [&mut world, &mut reference.world] {
                    let body = world
                        .query::<(Entity, &StableId)>()
                        .iter(world)
                        .find(|(_, id)| id.0 == 2)
                        .unwrap()
                        .0;
                    world.resource_mut::<PushQueue>().push_once(body, DVec3::Y * 30.0);
                    world.resource_mut::<Requests>().ask(Request::SetVelocity(body, DVec3::Z));
                }
            }
            schedule.run(&mut world);
            reference.tick();
            assert_eq!(state(&mut world), state(&mut reference.world), "{method:?}, tick {tick}");
            assert_eq!(world.resource::<StepClock>(), reference.world.resource::<StepClock>());
        }
        let [ours, theirs] =
            [&world, &reference.world].map(|world| world.resource::<Evaluations>().accelerations());
        assert_eq!(ours, theirs, "{method:?}");
        // All three of them did something.
        let end = state(&mut world);
        let height = |row: &(StableId, Bits, bool)| f64::from_bits(row.1[1]);
        assert!(height(&end[0]) > height(&end[1]) + 1.0, "{method:?}: the engine burned");
        let apart = |rows: &[(StableId, Bits, bool)]| {
            f64::from_bits(rows[2].1[0]) - f64::from_bits(rows[1].1[0])
        };
        assert!((apart(&end) - apart(&start)).abs() > 0.01, "{method:?}: the spring pulled");
        assert!(world.query::<&Emission>().single(&world).unwrap().living() > 10, "{method:?}");
        assert_eq!(world.resource::<Groups>().springs(), 1);
    }
}

#[test]
fn laws_that_a_system_inserts_act_in_the_same_tick() {
    type Declare = fn(&mut World);
    const LAWS: [Declare; 4] = [
        |world| world.insert_resource(Drag::new(0.5, 0.1)),
        |world| {
            world.insert_resource(Wells(vec![Well {
                position: DVec3::X,
                strength: 30.0,
                softening: 1.0,
            }]));
        },
        |world| world.insert_resource(Laws(vec![Box::new(Drag::new(0.0, 0.3))])),
        |world| world.insert_resource(MutualGravity { constant: 5.0, softening: 1.0 }),
    ];
    for (number, declare) in LAWS.into_iter().enumerate() {
        for method in [Method::SemiImplicitEuler, Method::VelocityVerlet] {
            // Twice: what is declared for the second time adds no kind of entity.
            let mut reference = Reference::new(method);
            let (mut world, mut schedule) = example::embed(method);
            let act = move |world: &mut World, tick: u64| match tick {
                10 | 30 => declare(world),
                20 => remove(world),
                _ => {}
            };
            let system = move |world: &mut World| act(world, world.resource::<StepClock>().ticks());
            schedule.add_systems(system.before(StepSystems::ApplyForces));
            for tick in 0..40 {
                act(&mut reference.world, tick);
                reference.stepper.recompile(&mut reference.world);
                let before = state(&mut world);
                schedule.run(&mut world);
                reference.tick();
                let after = state(&mut world);
                assert_eq!(
                    after,
                    state(&mut reference.world),
                    "law {number}, {method:?}, tick {tick}"
                );
                assert_ne!(after, before);
            }
        }
    }
}

fn remove(world: &mut World) {
    world.remove_resource::<Drag>();
    world.remove_resource::<Wells>();
    world.remove_resource::<Laws>();
    world.remove_resource::<MutualGravity>();
}

#[test]
fn the_method_of_an_installed_stepper_can_be_changed() {
    let mut reference = Reference::new(Method::SemiImplicitEuler);
    let (mut world, mut schedule) = example::embed(Method::SemiImplicitEuler);
    for tick in 0..40 {
        if tick == 20 {
            Stepper::installed(&mut world, |stepper, world| {
                stepper.set_method(world, Method::PositionVerlet);
            });
            reference.stepper.set_method(&mut reference.world, Method::PositionVerlet);
        }
        schedule.run(&mut world);
        reference.tick();
        assert_eq!(state(&mut world), state(&mut reference.world), "tick {tick}");
    }
}

#[test]
fn an_installed_stepper_goes_back_to_a_snapshot() {
    for method in Method::ALL {
        let (mut world, mut schedule) = example::embed(method);
        let mut run = |world: &mut World, ticks| {
            (0..ticks).for_each(|_| schedule.run(world));
            state(world)
        };
        run(&mut world, 20);
        let saved = Stepper::installed(&mut world, |stepper, world| snapshot::take(world, stepper));
        let first = run(&mut world, 70);
        Stepper::installed(&mut world, |stepper, world| snapshot::restore(world, stepper, &saved))
            .unwrap();
        assert_eq!(world.resource::<StepClock>().ticks(), 20);
        assert_eq!(run(&mut world, 70), first, "{method:?}");
    }
}

/// A world with a ball, to misuse.
fn ball() -> (World, Entity) {
    let mut world = World::new();
    let ball = world.spawn(PhysicsBody::with_mass(2.0)).id();
    (world, ball)
}

/// What `misuse` panics with.
#[track_caller]
fn panic_of(misuse: impl FnOnce()) -> String {
    let payload = std::panic::catch_unwind(std::panic::AssertUnwindSafe(misuse)).unwrap_err();
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap()
}

#[test]
fn a_tick_of_negative_or_infinite_length_is_refused() {
    let cure = "give a finite `TimeStep` above 0";
    for step in [-0.01, f64::NAN, f64::INFINITY] {
        let (mut world, _) = ball();
        let said = panic_of(|| drop(Stepper::new(&mut world, Method::default(), TimeStep(step))));
        assert!(said.contains(&format!("{step} s")) && said.contains(cure), "{said}");
        let (mut world, _) = ball();
        let mut stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.01));
        world.insert_resource(TimeStep(step));
        assert!(panic_of(|| stepper.tick(&mut world)).contains(cure));
        assert_eq!(world.resource::<StepClock>().ticks(), 0);
    }
}

#[test]
fn a_world_has_one_installed_stepper() {
    let (mut world, _) = ball();
    let mut schedule = Schedule::default();
    let stepper = |world: &mut World| Stepper::new(world, Method::default(), TimeStep(0.01));
    stepper(&mut world).install(&mut world, &mut schedule);
    let second = stepper(&mut world);
    let said = panic_of(|| second.install(&mut world, &mut Schedule::default()));
    assert!(said.contains("installed in this world already"), "{said}");
    let mut second = stepper(&mut world);
    assert!(panic_of(|| second.tick(&mut world)).contains("run the schedule"));
    schedule.run(&mut world);
    assert_eq!(world.resource::<StepClock>().ticks(), 1);
}

#[test]
fn a_force_acts_in_one_tick_whenever_a_system_adds_it() {
    fn push(clock: Res<StepClock>, mut forces: Forces, bodies: Query<Entity, With<PhysicsBody>>) {
        if clock.ticks() == 3 {
            bodies.iter().for_each(|body| forces.add(body, DVec3::X * 60.0));
        }
    }
    let speed = |order: fn(&mut Schedule)| {
        let (mut world, ball) = ball();
        let mut schedule = Schedule::default();
        Stepper::new(&mut world, Method::default(), TimeStep(0.01))
            .install(&mut world, &mut schedule);
        order(&mut schedule);
        (0..8).for_each(|_| schedule.run(&mut world));
        world.get::<PhysicsBody>(ball).unwrap().velocity
    };
    let orders: [fn(&mut Schedule); 5] = [
        |schedule| {
            schedule.add_systems(push.before(StepSystems::ApplyForces));
        },
        |schedule| {
            schedule.add_systems(push.before(StepSystems::Integrate));
        },
        |schedule| {
            let late = push.after(StepSystems::Integrate).before(StepSystems::ClearForces);
            schedule.add_systems(late);
        },
        |schedule| {
            let late = push.after(StepSystems::ClearForces).before(StepSystems::Quarantine);
            schedule.add_systems(late);
        },
        |schedule| {
            schedule.add_systems(push.after(StepSystems::Quarantine));
        },
    ];
    for (number, order) in orders.into_iter().enumerate() {
        assert_eq!(speed(order), DVec3::X * 60.0 * 0.5 * 0.01, "order {number}");
    }
}

#[test]
fn a_damping_rate_damps_in_a_world_that_declares_no_damping() {
    for declared in [None, Some(Damping { model: DampingModel::default(), rate: 0.0 })] {
        let (mut world, ball) = ball();
        declared.into_iter().for_each(|damping| world.insert_resource(damping));
        let state = PhysicsBody::with_mass(1.0).moving_at(DVec3::X);
        let damped = world.spawn((state, DampingRate::new(2.0))).id();
        world.get_mut::<PhysicsBody>(ball).unwrap().velocity = DVec3::X;
        let mut stepper = Stepper::new(&mut world, Method::default(), TimeStep(0.1));
        (0..10).for_each(|_| stepper.tick(&mut world));
        let speed = |body| world.get::<PhysicsBody>(body).unwrap().velocity.x;
        assert!((speed(damped) - (-2.0_f64).exp()).abs() < 1e-12, "{}", speed(damped));
        assert_eq!(speed(ball), 1.0);
    }
}

#[test]
fn a_rate_does_not_switch_on_damping_that_is_off() {
    let (mut world, _) = ball();
    world.insert_resource(Damping::TUTORIAL);
    motion::effects::switch(&mut world, Effect::Damping, false).unwrap();
    world.spawn((PhysicsBody::with_mass(1.0), DampingRate::new(2.0)));
    assert_eq!(motion::effects::state(&world, Effect::Damping), EffectState::Off);
}

#[test]
fn a_mass_that_is_written_in_a_group_attracts_as_one_that_was_there() {
    let run = |written: bool| {
        let mut world = World::new();
        world.insert_resource(MutualGravity { constant: 1.0, softening: 0.1 });
        let mass = |heavy: bool| PhysicsBody::with_mass(if heavy { 8.0 } else { 2.0 });
        let at = |x: f64| Transform::at(DVec3::X * x);
        let heavy = world.spawn((mass(!written), at(0.0))).id();
        let light = world.spawn((mass(false), at(3.0))).id();
        let mut stepper = Stepper::new(&mut world, Method::VelocityVerlet, TimeStep(0.01));
        if written {
            world.get_mut::<PhysicsBody>(heavy).unwrap().inverse_mass = 1.0 / 8.0;
        }
        (0..50).for_each(|_| stepper.tick(&mut world));
        [heavy, light].map(|body| *world.get::<Transform>(body).unwrap())
    };
    assert_eq!(run(true), run(false));
}
