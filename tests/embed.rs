//! The physics in a schedule of one's own: the example of an outside crate, tick by tick beside a [`Stepper`].

#[path = "../crates/motion/examples/embed.rs"]
#[allow(dead_code, reason = "what the example prints")]
mod example;

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::clock::StepClock;
use motion::groups::Groups;
use motion::{
    Dormant, Drag, Emission, Evaluations, Laws, Method, PhysicsBody, PushQueue, Request, Requests, StableId,
    StepSystems, Stepper, Transform, Well, Wells,
};

use crate::harness::{Bits, bits};

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
                    let body =
                        world.query::<(Entity, &StableId)>().iter(world).find(|(_, id)| id.0 == 2).unwrap().0;
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
        let apart =
            |rows: &[(StableId, Bits, bool)]| f64::from_bits(rows[2].1[0]) - f64::from_bits(rows[1].1[0]);
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
            world.insert_resource(Wells(vec![Well { position: DVec3::X, strength: 30.0, softening: 1.0 }]));
        },
        |world| world.insert_resource(Laws(vec![Box::new(Drag::new(0.0, 0.3))])),
        |world| world.insert_resource(motion::MutualGravity { constant: 5.0, softening: 1.0 }),
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
                assert_eq!(after, state(&mut reference.world), "law {number}, {method:?}, tick {tick}");
                assert_ne!(after, before);
            }
        }
    }
}

fn remove(world: &mut World) {
    world.remove_resource::<Drag>();
    world.remove_resource::<Wells>();
    world.remove_resource::<Laws>();
    world.remove_resource::<motion::MutualGravity>();
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
