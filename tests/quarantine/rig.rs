//! A shipped scene that is stepped with something between its systems.

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use motion::clock::StepClock;
use motion::systems::step_systems;
use motion::{
    Gravity, PhysicsBody, PreviousPosition, Quarantine, QuarantineRecord, Request, Requests, StableId,
    Stepper, TimeStep, Transform, remember_positions,
};
use scene::Scene;

/// What someone does to a world in the middle of a tick.
pub type Harm = Box<dyn Fn(&mut World) + Send + Sync>;

/// A world of a scene and its stepper.
pub struct Rig {
    pub world: World,
    pub stepper: Stepper,
    /// Every body by stable id.
    pub bodies: Vec<Entity>,
}

impl Rig {
    pub fn new(scene: &Scene) -> Self {
        let mut world = World::new();
        let bodies = scene.spawn(&mut world);
        if let Some(mut gravity) = world.get_resource_mut::<Gravity>() {
            gravity.on = true;
        }
        for body in &bodies {
            if let Some(at) = world.get::<Transform>(*body).copied() {
                world.entity_mut(*body).insert(PreviousPosition(at.position));
            }
        }
        let stepper = Stepper::new(&mut world, scene.method, TimeStep(1.0 / scene.step_hz));
        Self { world, stepper, bodies }
    }

    /// Names of the systems of a tick.
    pub fn systems(&mut self) -> Vec<String> {
        let mut names = self.stepper.systems();
        names.retain(|name| name != "apply_deferred");
        assert_eq!(names.len(), step_systems(&mut self.world, self.stepper.plan()).len(), "{names:?}");
        names
    }

    fn remember(&mut self) {
        self.world.run_system_cached(remember_positions).unwrap();
    }

    pub fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.remember();
            self.stepper.tick(&mut self.world);
        }
    }

    /// A tick with `harm` done before the system number `at`.
    pub fn run_harmed(&mut self, at: usize, harm: Harm) {
        self.remember();
        let mut systems = step_systems(&mut self.world, self.stepper.plan());
        systems.insert(at, (move |world: &mut World| harm(world)).into_configs());
        let mut systems = systems.into_iter();
        let first = systems.next().unwrap();
        let mut schedule = Schedule::default();
        schedule.set_executor(SingleThreadedExecutor::new());
        schedule.add_systems(systems.fold(first, |before, system| (before, system).chain()));
        schedule.run(&mut self.world);
        let TimeStep(step) = *self.world.resource::<TimeStep>();
        self.world.resource_mut::<StepClock>().count(step);
    }

    pub fn remove(&mut self, body: Entity) {
        self.world.resource_mut::<Requests>().ask(Request::Remove(body));
    }

    pub fn records(&self) -> Vec<QuarantineRecord> {
        self.world.resource::<Quarantine>().records().to_vec()
    }

    /// The state of every body with physics but one, bit for bit, by stable id.
    pub fn bits(&mut self, without: StableId) -> Vec<(StableId, [u64; 6])> {
        let mut bodies = self.world.query::<(&StableId, &Transform, &PhysicsBody)>();
        let mut all: Vec<_> = bodies
            .iter(&self.world)
            .filter(|(id, ..)| **id != without)
            .map(|(id, at, body)| {
                let ([a, b, c], [d, e, f]) = (at.position.to_array(), body.velocity.to_array());
                (*id, [a, b, c, d, e, f].map(f64::to_bits))
            })
            .collect();
        all.sort_unstable_by_key(|(id, _)| *id);
        all
    }

    /// Whether nothing of any body is anything but a number.
    pub fn is_finite(&mut self) -> bool {
        let mut bodies = self.world.query::<(&Transform, &PhysicsBody, Option<&PreviousPosition>)>();
        bodies.iter(&self.world).all(|(at, body, previous)| {
            at.position.is_finite()
                && body.velocity.is_finite()
                && body.inverse_mass.is_finite()
                && previous.is_none_or(|previous| previous.0.is_finite())
        })
    }
}

/// Every shipped scene that has bodies.
pub fn scenes() -> Vec<(&'static str, Scene)> {
    let all = scene::shipped().iter().map(|shipped| (shipped.name, shipped.load().unwrap()));
    all.filter(|(_, scene)| !scene.bodies.is_empty()).collect()
}
