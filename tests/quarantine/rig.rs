//! A shipped scene that is stepped with something between its systems.

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use history::Simulation;
use motion::clock::StepClock;
use motion::internals::step_systems;
use motion::{
    Gravity, PhysicsBody, PreviousPosition, Quarantine, QuarantineRecord, StableId, TimeStep,
    Transform, remember_positions,
};
use scene::Scene;

use crate::rigs::{Bits, all_bits};

/// What someone does to a world in the middle of a tick.
pub type Harm = Box<dyn Fn(&mut World) + Send + Sync>;

/// A simulation that draws between ticks, with gravity.
pub fn start(scene: &Scene) -> Simulation {
    Simulation::prepared(scene.clone(), |world, bodies| {
        if let Some(mut gravity) = world.get_resource_mut::<Gravity>() {
            gravity.on = true;
        }
        for body in bodies {
            if let Some(at) = world.get::<Transform>(*body).copied() {
                world.entity_mut(*body).insert(PreviousPosition(at.position));
            }
        }
    })
}

/// Names of the systems of a tick.
pub fn systems(rig: &mut Simulation) -> Vec<String> {
    let mut names = rig.stepper.systems();
    names.retain(|name| name != "apply_deferred");
    assert_eq!(names.len(), step_systems(&mut rig.world, rig.stepper.plan()).len(), "{names:?}");
    names
}

fn remember(rig: &mut Simulation) {
    rig.world.run_system_cached(remember_positions).unwrap();
}

pub fn run(rig: &mut Simulation, ticks: u64) {
    for _ in 0..ticks {
        remember(rig);
        rig.tick();
    }
}

/// A tick with `harm` done before the system number `at`.
pub fn run_harmed(rig: &mut Simulation, at: usize, harm: Harm) {
    remember(rig);
    let mut systems = step_systems(&mut rig.world, rig.stepper.plan());
    systems.insert(at, (move |world: &mut World| harm(world)).into_configs());
    let mut systems = systems.into_iter();
    let first = systems.next().unwrap();
    let mut schedule = Schedule::default();
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.add_systems(systems.fold(first, |before, system| (before, system).chain()));
    schedule.run(&mut rig.world);
    let TimeStep(step) = *rig.world.resource::<TimeStep>();
    rig.world.resource_mut::<StepClock>().count(step);
}

pub fn records(rig: &Simulation) -> Vec<QuarantineRecord> {
    rig.world.resource::<Quarantine>().records().to_vec()
}

/// The state of every body with physics but one, bit for bit, by stable id.
pub fn bits(rig: &Simulation, without: StableId) -> Vec<(u32, Bits)> {
    all_bits(rig.states().filter(|(id, ..)| *id != without.0))
}

/// Whether nothing of any body is anything but a number.
pub fn is_finite(rig: &mut Simulation) -> bool {
    let mut bodies = rig.world.query::<(&Transform, &PhysicsBody, Option<&PreviousPosition>)>();
    bodies.iter(&rig.world).all(|(at, body, previous)| {
        at.position.is_finite()
            && body.velocity.is_finite()
            && body.inverse_mass.is_finite()
            && previous.is_none_or(|previous| previous.0.is_finite())
    })
}

/// Every shipped scene that has bodies.
pub fn scenes() -> Vec<(&'static str, Scene)> {
    let all = scene::shipped().iter().map(|shipped| (shipped.name, shipped.load().unwrap()));
    all.filter(|(_, scene)| !scene.bodies.is_empty()).collect()
}
