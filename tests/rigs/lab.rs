//! A world of bodies that is stepped and looked at, and how near numbers are.

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{
    Damping, Elastic, Evaluations, Gravity, Method, PhysicsBody, PushQueue, Quarantine,
    QuarantineRecord, Quarantined, Request, Requests, Spring, StableId, Stepper, TimeStep, Totals,
    Transform, totals,
};

use crate::rigs::Start;

/// The tutorial's tick, s.
pub const H: f64 = 1.0 / 120.0;

/// Gravity of the tutorial, m/s².
pub const G: f64 = -9.8;

/// Position and velocity of a body, bit for bit.
pub type Bits = [u64; 6];

pub fn bits(x: Vector, v: Vector) -> Bits {
    [x.x, x.y, x.z, v.x, v.y, v.z].map(f64::to_bits)
}

/// The same of every body of `states`, as [`Simulation::states`](history::Simulation::states) gives them.
pub fn all_bits(states: impl IntoIterator<Item = (u32, Vector, Vector)>) -> Vec<(u32, Bits)> {
    states.into_iter().map(|(id, x, v)| (id, bits(x, v))).collect()
}

/// The same of every body with physics in `world`, in stable-id order.
pub fn world_bits(world: &mut World) -> Vec<(u32, Bits)> {
    let mut bodies = world.query::<(&StableId, &Transform, &PhysicsBody)>();
    let mut all =
        all_bits(bodies.iter(world).map(|(id, at, body)| (id.0, at.position, body.velocity)));
    all.sort_unstable();
    all
}

/// A world that is built by hand and its stepper, its bodies and springs in the order that they came in.
pub struct Lab {
    pub world: World,
    pub stepper: Stepper,
    pub bodies: Vec<Entity>,
    pub springs: Vec<Entity>,
}

/// A body of a [`Lab`]: itself, or its place among the bodies.
pub trait Which {
    fn of(self, lab: &Lab) -> Entity;
}

impl Which for Entity {
    fn of(self, _: &Lab) -> Entity {
        self
    }
}

impl Which for usize {
    fn of(self, lab: &Lab) -> Entity {
        lab.bodies[self]
    }
}

impl Lab {
    pub fn new(method: Method, h: f64) -> Self {
        Self::of(World::new(), method, h)
    }

    /// With what is in `world` already.
    pub fn of(mut world: World, method: Method, h: f64) -> Self {
        let stepper = Stepper::new(&mut world, method, TimeStep(h));
        Self { world, stepper, bodies: Vec::new(), springs: Vec::new() }
    }

    pub fn tutorial() -> Self {
        Self::new(Method::SemiImplicitEuler, H).with_gravity().with(Damping::TUTORIAL)
    }

    pub fn with_gravity(self) -> Self {
        self.with(Gravity::EARTH)
    }

    pub fn with(mut self, resource: impl Resource) -> Self {
        self.world.insert_resource(resource);
        self
    }

    pub fn spawn(&mut self, start: Start) -> Entity {
        let body = self.world.spawn(start.components()).id();
        self.bodies.push(body);
        body
    }

    /// A body of that inverse mass at a height of 10 m.
    pub fn body(&mut self, inverse_mass: f64, velocity: Vector) -> Entity {
        self.spawn(Start { x: Vector::Y * 10.0, v: velocity, w: inverse_mass })
    }

    pub fn spring<T: Which>(&mut self, ends: [T; 2], elastic: Elastic) -> Entity {
        let ends = ends.map(|end| end.of(self));
        let spring = self.world.spawn(Spring { ends, elastic }).id();
        self.springs.push(spring);
        spring
    }

    pub fn insert(&mut self, body: impl Which, components: impl Bundle) {
        let body = body.of(self);
        self.world.entity_mut(body).insert(components);
    }

    pub fn recompile(&mut self) -> &mut Self {
        self.stepper.recompile(&mut self.world);
        self
    }

    pub fn push(&mut self, body: impl Which, newtons: Vector) -> &mut Self {
        let body = body.of(self);
        self.world.resource_mut::<PushQueue>().push_once(body, newtons);
        self
    }

    pub fn ask(&mut self, request: Request) -> &mut Self {
        self.world.resource_mut::<Requests>().ask(request);
        self
    }

    /// Asks and has it carried out, without a tick.
    pub fn have(&mut self, request: Request) {
        self.ask(request);
        self.stepper.carry_out_requests(&mut self.world);
    }

    pub fn set_method(&mut self, method: Method) {
        self.stepper.set_method(&mut self.world, method);
    }

    pub fn run(&mut self, ticks: u64) -> &mut Self {
        (0..ticks).for_each(|_| self.stepper.tick(&mut self.world));
        self
    }

    pub fn x(&self, body: impl Which) -> Vector {
        self.world.get::<Transform>(body.of(self)).unwrap().position
    }

    pub fn v(&self, body: impl Which) -> Vector {
        self.world.get::<PhysicsBody>(body.of(self)).unwrap().velocity
    }

    /// Position and velocity.
    pub fn state(&self, body: impl Which + Copy) -> (Vector, Vector) {
        (self.x(body), self.v(body))
    }

    pub fn states(&self) -> Vec<(Vector, Vector)> {
        self.bodies.iter().map(|body| self.state(*body)).collect()
    }

    pub fn bits(&self, body: impl Which + Copy) -> Bits {
        bits(self.x(body), self.v(body))
    }

    /// Bits of all bodies but some.
    pub fn all_bits(&self, but: &[usize]) -> Vec<Bits> {
        (0..self.bodies.len())
            .filter(|body| !but.contains(body))
            .map(|body| self.bits(body))
            .collect()
    }

    pub fn is_quarantined(&self, body: impl Which) -> bool {
        self.world.get::<Quarantined>(body.of(self)).is_some()
    }

    /// Records of the bodies that were quarantined, in the order of events.
    pub fn records(&self) -> &[QuarantineRecord] {
        self.world.resource::<Quarantine>().records()
    }

    pub fn evaluations(&self) -> &Evaluations {
        self.world.resource()
    }

    /// Evaluations of accelerations, in all and by law.
    pub fn counts(&self) -> (u64, Vec<(&'static str, u64)>) {
        let mut laws = self.evaluations().laws().to_vec();
        laws.sort_unstable();
        (self.evaluations().accelerations(), laws)
    }

    pub fn totals(&self) -> Totals {
        totals(&self.world)
    }

    /// Kinetic and potential energy, J.
    pub fn energy(&mut self) -> f64 {
        let sum = self.totals();
        sum.kinetic_energy + sum.potential_energy
    }
}

/// Fails unless `actual` is within `relative` of `expected`.
#[track_caller]
pub fn close(actual: f64, expected: f64, relative: f64) {
    let error = (actual - expected).abs();
    assert!(
        error <= relative * expected.abs(),
        "{actual} is not {expected} (error {error:e}, allowed {relative:e})"
    );
}

/// Fails unless `actual` rounds to the digits of `expected`.
#[track_caller]
pub fn digits(actual: f64, expected: &str) {
    let decimals = expected.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    assert_eq!(format!("{actual:.decimals$}"), expected);
}
