//! Bodies by their rows, in a world of their own.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::clock::StepClock;
use motion::methods::Integrator;
use motion::{
    Damping, Evaluations, Law, Laws, Method, PhysicsBody, PushQueue, Quarantine, Request, Requests,
    Stepper, Substeps, TimeStep, Transform,
};

use crate::rigs::Start;

/// Bodies by their rows, and copies of their states after the last tick.
pub struct Bare {
    pub positions: Vec<[f64; 3]>,
    /// Velocity, m/s, and inverse mass, 1/kg.
    pub bodies: Vec<[f64; 4]>,
    world: World,
    stepper: Stepper,
    rows: Vec<Entity>,
    /// Whether the stepper is of the caller's own method.
    has_own_method: bool,
    is_outdated: bool,
}

impl Bare {
    pub fn new(method: Method, step: f64) -> Self {
        let mut world = World::new();
        let stepper = Stepper::new(&mut world, method, TimeStep(step));
        Self {
            positions: Vec::new(),
            bodies: Vec::new(),
            world,
            stepper,
            rows: Vec::new(),
            has_own_method: false,
            is_outdated: true,
        }
    }

    fn with(mut self, resource: impl Resource) -> Self {
        self.world.insert_resource(resource);
        self.is_outdated = true;
        self
    }

    /// With a law that acts on every body.
    pub fn with_law(mut self, law: impl Law) -> Self {
        self.world.get_resource_or_init::<Laws>().0.push(Box::new(law));
        self.is_outdated = true;
        self
    }

    pub fn with_damping(self, damping: Damping) -> Self {
        self.with(damping)
    }

    pub fn with_substeps(self, substeps: u32) -> Self {
        self.with(Substeps(substeps))
    }

    /// Returns the row of the body.
    pub fn add(&mut self, position: [f64; 3], velocity: [f64; 3], inverse_mass: f64) -> usize {
        let [x, v] = [position, velocity].map(DVec3::from_array);
        let body = self.world.spawn(Start { x, v, w: inverse_mass }.components()).id();
        self.rows.push(body);
        self.is_outdated = true;
        self.look();
        self.rows.len() - 1
    }

    /// Pushes a body during the next tick.
    pub fn push(&mut self, body: usize, newtons: [f64; 3]) {
        let newtons = DVec3::from_array(newtons);
        self.world.resource_mut::<PushQueue>().push_once(self.rows[body], newtons);
    }

    pub fn set_step(&mut self, step: f64) {
        self.world.insert_resource(TimeStep(step));
    }

    /// Replaces all laws. Position Verlet begins again, from velocities at the time of the positions.
    pub fn set_laws(&mut self, laws: Vec<Box<dyn Law>>) {
        if self.stepper.method() == Method::PositionVerlet && !self.has_own_method {
            self.set_method(Method::VelocityVerlet);
            self.set_method(Method::PositionVerlet);
        }
        self.world.insert_resource(Laws(laws));
        self.is_outdated = true;
    }

    pub fn set_method(&mut self, method: Method) {
        assert!(!self.has_own_method, "the caller's own method stays");
        self.recompile();
        self.stepper.set_method(&mut self.world, method);
        self.look();
    }

    pub fn reverse_velocities(&mut self) {
        self.recompile();
        self.world.resource_mut::<Requests>().ask(Request::ReverseVelocities);
        self.stepper.carry_out_requests(&mut self.world);
        self.look();
    }

    pub fn tick(&mut self) {
        self.recompile();
        self.stepper.tick(&mut self.world);
        self.look();
    }

    /// A tick by the caller's own method.
    pub fn tick_with<M: Integrator>(&mut self) {
        if !self.has_own_method {
            let step = *self.world.resource::<TimeStep>();
            self.stepper = Stepper::of::<M>(&mut self.world, step);
            (self.has_own_method, self.is_outdated) = (true, true);
        }
        self.tick();
    }

    fn recompile(&mut self) {
        if std::mem::take(&mut self.is_outdated) {
            self.stepper.recompile(&mut self.world);
        }
    }

    fn look(&mut self) {
        self.positions.clear();
        self.bodies.clear();
        for body in &self.rows {
            let (at, body) = self.world.entity(*body).components::<(&Transform, &PhysicsBody)>();
            let DVec3 { x, y, z } = body.velocity;
            self.positions.push(at.position.to_array());
            self.bodies.push([x, y, z, body.inverse_mass]);
        }
    }

    pub fn time(&self) -> f64 {
        self.world.resource::<StepClock>().scene_seconds()
    }

    /// Newton iterations so far, and steps that did not converge.
    pub fn newton(&self) -> (u64, u64) {
        let evaluations = self.world.resource::<Evaluations>();
        (evaluations.newton_iterations(), evaluations.unconverged_steps())
    }

    pub fn has_failed(&self) -> bool {
        !self.world.resource::<Quarantine>().records().is_empty()
    }
}
