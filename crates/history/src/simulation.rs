//! A scene that runs.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::ledger::Ledger;
use motion::units::Vector;
use motion::{
    Cause, Evaluations, Method, PhysicsBody, PushQueue, Quarantine, Quarantined, Request, Requests,
    Stepper, TimeStep, Transform, own_method,
};
use scene::{Scene, Substepping};
use xxhash_rust::xxh3::Xxh3;

/// The first quarantine of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstQuarantine {
    /// Stable id of the body, if it has one.
    pub body: Option<u32>,
    /// The tick in which it was quarantined.
    pub tick: u64,
    /// The cause of the quarantine.
    pub cause: Cause,
}

impl FirstQuarantine {
    /// Name of the body in `scene`.
    #[must_use]
    pub fn name(self, scene: &Scene) -> String {
        let name = self.body.and_then(|id| scene.names.get(id));
        name.map_or_else(|| "a body".to_owned(), Cow::into_owned)
    }
}

/// A running scene: its world, the stepper of that world, and its bodies.
///
/// The fields are public for queries, resources and measurements. Change a body by requests and pushes, which keep
/// the method state valid.
pub struct Simulation {
    /// The scene that the world was spawned from.
    pub scene: Arc<Scene>,
    /// The world.
    pub world: World,
    /// Its stepper.
    pub stepper: Stepper,
    /// Its bodies by stable id, as [`Scene::spawn`] returned them; some may have been removed.
    pub bodies: Vec<Entity>,
}

impl Simulation {
    /// A simulation at the start of `scene`.
    #[must_use]
    pub fn new(scene: impl Into<Arc<Scene>>) -> Self {
        Self::prepared(scene, |_, _| ())
    }

    /// A simulation at the start of `scene`, whose spawned world and bodies `prepare` may change before it has a stepper.
    #[must_use]
    pub fn prepared(
        scene: impl Into<Arc<Scene>>,
        prepare: impl FnOnce(&mut World, &[Entity]),
    ) -> Self {
        let scene = scene.into();
        let mut world = World::new();
        let bodies = scene.spawn(&mut world);
        prepare(&mut world, &bodies);
        let stepper = Stepper::new(&mut world, scene.method, TimeStep(1.0 / scene.step_hz));
        Self { scene, world, stepper, bodies }
    }

    /// The method of all bodies that have none of their own.
    #[must_use]
    pub const fn method(&self) -> Method {
        self.stepper.method()
    }

    /// Substeps of all bodies that have none of their own.
    #[must_use]
    pub fn substeps(&self) -> Substepping {
        Substepping::of(&self.world)
    }

    /// Ticks simulated so far.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.world.resource::<StepClock>().ticks()
    }

    /// How often laws were evaluated so far, and what solvers did.
    #[must_use]
    pub fn evaluations(&self) -> &Evaluations {
        self.world.resource()
    }

    /// Changes the method of all bodies that have none of their own: see [`Stepper::set_method`].
    pub fn set_method(&mut self, method: Method) {
        self.stepper.set_method(&mut self.world, method);
    }

    /// Simulates one tick.
    pub fn tick(&mut self) {
        self.stepper.tick(&mut self.world);
        self.world.clear_trackers();
    }

    /// Simulates one tick, with the same bits, and adds it to `ledger`.
    pub fn tick_with(&mut self, ledger: &mut Ledger) {
        ledger.tick(&mut self.stepper, &mut self.world);
        self.world.clear_trackers();
    }

    /// Simulates a number of ticks.
    pub fn run(&mut self, ticks: u64) {
        (0..ticks).for_each(|_| self.tick());
    }

    /// The body of that stable id, unless it was removed.
    #[must_use]
    pub fn body(&self, id: u32) -> Option<Entity> {
        let body = *self.bodies.get(id as usize)?;
        self.world.get_entity(body).is_ok().then_some(body)
    }

    /// The body of that name, unless it was removed.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<Entity> {
        self.body(self.scene.names.find(name)?)
    }

    /// The bodies that were not removed, in stable-id order.
    pub fn remaining_bodies(&self) -> impl Iterator<Item = Entity> + '_ {
        self.bodies.iter().copied().filter(|body| self.world.get_entity(*body).is_ok())
    }

    /// Number of bodies that forces move, per method, in the order of [`motion::METHODS`].
    #[must_use]
    pub fn bodies_per_method(&self) -> Vec<(Method, usize)> {
        // The variants of `Method` are in the order of the table.
        let mut counts = BTreeMap::new();
        for body in self.bodies.iter().filter_map(|body| self.world.get_entity(*body).ok()) {
            let state = body.get::<PhysicsBody>().filter(|_| !body.contains::<Quarantined>());
            if state.is_some_and(|state| state.inverse_mass > 0.0) {
                *counts.entry(own_method(body).unwrap_or(self.method())).or_default() += 1;
            }
        }
        counts.into_iter().collect()
    }

    /// Simulated time, s. Time and ticks continue when a run replaces its world, after a reset or for another scene.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.world.resource::<StepClock>().seconds()
    }

    /// Pushes `body` in the coming tick, N.
    pub fn push(&mut self, body: Entity, newtons: Vector) {
        self.world.resource_mut::<PushQueue>().push_once(body, newtons);
    }

    /// Requests a change before the coming tick.
    pub fn request(&mut self, request: Request) {
        self.world.resource_mut::<Requests>().ask(request);
    }

    /// Carries out the pending requests at once.
    pub fn carry_out_requests(&mut self) {
        self.stepper.carry_out_requests(&mut self.world);
    }

    /// Stable id, position, m, and velocity, m/s, of every body with physics, in stable-id order.
    pub fn states(&self) -> impl Iterator<Item = (u32, Vector, Vector)> + '_ {
        let bodies = (0..).zip(&self.bodies);
        bodies.filter_map(|(id, body)| {
            let body = self.world.get_entity(*body).ok()?;
            Some((id, body.get::<Transform>()?.position, body.get::<PhysicsBody>()?.velocity))
        })
    }

    /// The first quarantine, if a body was quarantined.
    #[must_use]
    pub fn failure(&self) -> Option<FirstQuarantine> {
        let record = self.world.resource::<Quarantine>().records().first()?;
        Some(FirstQuarantine {
            body: record.id.map(|id| id.0),
            tick: record.tick,
            cause: record.cause,
        })
    }

    /// Hash of the state, as summaries have it: see [`Snapshot::state_hash`](crate::Snapshot::state_hash).
    #[must_use]
    pub fn hash(&self) -> u64 {
        hash_of_states(
            self.states().map(|(_, position, velocity)| (position.to_array(), velocity.to_array())),
        )
    }
}

/// XXH3-64 over the little-endian f64 bits of each position, m, and velocity, m/s, in the order that they come in.
pub(crate) fn hash_of_states(states: impl IntoIterator<Item = ([f64; 3], [f64; 3])>) -> u64 {
    let mut hash = Xxh3::new();
    for (position, velocity) in states {
        for number in position.into_iter().chain(velocity) {
            hash.update(&number.to_bits().to_le_bytes());
        }
    }
    hash.digest()
}
