//! Carries a world from tick to tick.

use bevy_ecs::prelude::*;

use crate::clock::StepClock;
use crate::components::PhysicsBody;
use crate::requests::{self, Requests};
use crate::step::{Method, Passes, TimeStep, insert_step_resources, step_schedule};

/// The compiled schedule of a world, with what happens around it: requests before a tick, the count after it.
pub struct Stepper {
    method: Method,
    passes: Passes,
    schedule: Schedule,
}

impl Stepper {
    /// Prepares `world` for ticks of `step` and compiles the schedule of `method`.
    ///
    /// # Panics
    /// When two systems of the schedule touch the same data without a stated order, which is a fault of this
    /// crate.
    #[must_use]
    pub fn new(world: &mut World, method: Method, step: TimeStep) -> Self {
        insert_step_resources(world, step);
        world.init_resource::<StepClock>();
        world.init_resource::<Requests>();
        Self::compile(world, method)
    }

    fn compile(world: &mut World, method: Method) -> Self {
        let bodies = world.query::<&PhysicsBody>().iter(world).len();
        let passes = Passes::for_bodies(bodies);
        let mut schedule = step_schedule(method, passes);
        schedule.initialize(world).expect("the systems of a tick are totally ordered");
        Self { method, passes, schedule }
    }

    /// The method of the schedule.
    #[must_use]
    pub const fn method(&self) -> Method {
        self.method
    }

    /// How the two middle systems are run, decided by the number of bodies when the schedule was compiled.
    #[must_use]
    pub const fn passes(&self) -> Passes {
        self.passes
    }

    /// Compiles the schedule of another method; the state of the world stays as it is.
    ///
    /// # Panics
    /// As [`Stepper::new`].
    pub fn set_method(&mut self, world: &mut World, method: Method) {
        *self = Self::compile(world, method);
    }

    /// Simulates one tick.
    pub fn tick(&mut self, world: &mut World) {
        self.carry_out_requests(world);
        self.schedule.run(world);
        let TimeStep(step) = *world.resource::<TimeStep>();
        world.resource_mut::<StepClock>().count(step);
    }

    /// Carries out what was asked for without simulating: what a tick does first, for a world that is paused.
    pub fn carry_out_requests(&self, world: &mut World) {
        if !world.resource::<Requests>().is_empty() {
            requests::carry_out(world);
        }
    }

    /// Names of the systems of a tick in the order in which they run, read from the compiled schedule.
    ///
    /// # Panics
    /// Never: the schedule was initialized when it was compiled.
    #[must_use]
    pub fn systems(&self) -> Vec<String> {
        let systems = self.schedule.systems().expect("initialized when compiled");
        systems.map(|(_, system)| system.name().shortname().to_string()).collect()
    }
}
