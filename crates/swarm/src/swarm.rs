//! Swarms in a world: the component of an emitter, and the system that enters births, deaths and laws into the log.

use std::sync::Arc;

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use motion::clock::StepClock;
use motion::internals::{DueParticles, ParticleBackend, due_particles, emitters_changed, values};
use motion::snapshot::Off;
use motion::units::Vector;
use motion::{Emitter, Method, Substeps, TimeStep};

use crate::laws::{SwarmLaws, single};
use crate::log::{SwarmLog, SwarmTick};

/// Puts the particles of an [`Emitter`], whose `pool` must be empty, on a graphics device. A component of the emitter's
/// entity, which then has a [`SwarmLog`].
///
/// Positions are stored in single precision and count from `anchor`. A swarm obeys gravity, the laws of every body, each of
/// which needs a [`device_form`](motion::Law::device_form), and damping. Springs, mutual gravity, own laws of bodies, a range and
/// pushes do not act on a swarm, and ledgers leave it out.
#[derive(Component, Clone, Debug, PartialEq)]
#[component(immutable, on_insert = inserted, on_discard = emitters_changed)]
#[require(SwarmLog)]
pub struct Swarm {
    /// One of [`Swarm::METHODS`].
    pub method: Method,
    /// Substeps per tick, from 1 to [`Substeps::MOST`]; `None` for those of the world.
    pub substeps: Option<u32>,
    /// The place from which positions count, m.
    pub anchor: Vector,
    /// Velocity at birth of the particle in each slot, m/s: particle number k is in slot `k % n` of n.
    pub launches: Arc<[[f32; 3]]>,
}

/// Makes swarms a part of the ticks of `world`.
fn inserted(mut world: DeferredWorld, context: HookContext) {
    world.commands().insert_resource(BACKEND);
    emitters_changed(world, context);
}

impl Swarm {
    /// The methods of swarms. Position Verlet keeps two positions and no velocity, the others a position and a velocity.
    pub const METHODS: [Method; 3] =
        [Method::PositionVerlet, Method::SemiImplicitEuler, Method::VelocityVerlet];

    /// Most particles that live at once in the swarm of a file.
    pub const MOST: u64 = 4_000_000;

    /// Bytes of a particle on the device: two rows of three numbers with the number of the particle, and the velocity with
    /// which it is born.
    pub const PARTICLE_BYTES: u64 = 2 * 16 + 12;

    /// Most bytes of the states of all swarms that a device keeps for going back.
    pub const KEPT_BYTES: u64 = 256 << 20;

    /// Bytes that a step reads and writes per particle: two rows are read, and position Verlet writes one of them.
    #[must_use]
    pub fn bytes_per_step(&self) -> u64 {
        if self.method == Method::PositionVerlet { 3 * 16 } else { 4 * 16 }
    }

    /// Bytes of all particles on the device, without the states that are kept for going back.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.slots() * Self::PARTICLE_BYTES
    }

    /// The same swarm, whose particles are born with these velocities, m/s.
    #[must_use]
    pub fn born_with(&self, launches: impl Iterator<Item = Vector>) -> Self {
        let launches = launches.map(|launch| single(launch.to_array())).collect();
        Self { launches, ..self.clone() }
    }

    /// The same swarm, whose positions count from `anchor`, m.
    #[must_use]
    pub fn anchored_at(&self, anchor: Vector) -> Self {
        Self { anchor, ..self.clone() }
    }

    /// Number of slots.
    #[must_use]
    pub fn slots(&self) -> u64 {
        self.launches.len() as u64
    }

    /// # Panics
    /// If no device can integrate it; the message says why.
    fn check(&self, emitter: Option<&Emitter>) {
        let Self { method, anchor, .. } = self;
        assert!(
            Self::METHODS.contains(method),
            "a swarm cannot be integrated by {}; give one of `Swarm::METHODS`",
            method.name()
        );
        if let Some(substeps) = self.substeps {
            Substeps::check(substeps);
        }
        assert!(anchor.is_finite(), "the anchor of a swarm is at {anchor}; give a finite place");
        let pool = emitter.map_or(0, |emitter| emitter.pool.len());
        assert!(pool == 0, "the emitter of a swarm has {pool} bodies in its pool; leave it empty");
    }
}

/// What swarms do in a world.
const BACKEND: ParticleBackend = ParticleBackend {
    prepare,
    system: || advance_swarms.into_configs(),
    reverse: |world| {
        world.query::<&mut SwarmLog>().iter_mut(world).for_each(|mut log| log.reversed ^= true);
    },
    bytes: |world| values::<SwarmLog>(world).map(SwarmLog::bytes).sum(),
};

/// Enters the tick into the log of every swarm: births, deaths and laws.
pub fn advance_swarms(
    world: &mut World,
    swarms: &mut QueryState<(Entity, &Swarm)>,
    mut found: Local<Vec<(Entity, Swarm)>>,
) {
    let start = world.get_resource::<StepClock>().copied().unwrap_or_default().scene_seconds();
    let TimeStep(step) = world.get_resource().copied().unwrap_or(TimeStep(0.0));
    let Substeps(substeps) = world.get_resource().copied().unwrap_or_default();
    found.extend(swarms.iter(world).map(|(entity, swarm)| (entity, swarm.clone())));
    for (entity, swarm) in found.drain(..) {
        let before =
            world.get::<SwarmLog>(entity).and_then(|log| log.ticks.back()).map(|tick| &tick.laws);
        let (laws, phase) = SwarmLaws::of(world, swarm.anchor, start, before);
        let due = due_particles(world, entity, swarm.slots());
        let Some(mut log) = world.get_mut::<SwarmLog>(entity) else { continue };
        // If its emitter was removed, so were its particles.
        if due.as_ref().is_none_or(|due| due.restarted) {
            *log = SwarmLog::default();
        }
        // Nothing moves in a tick without a length.
        let Some(due) = due.filter(|_| step != 0.0) else { continue };
        let DueParticles { births, first_birth, between, dead, position, velocity, born, .. } = due;
        let [step, first_birth, between] = single([step, first_birth, between]);
        log.enter(SwarmTick {
            key: 0,
            step,
            substeps: swarm.substeps.unwrap_or(substeps),
            births: [births.start, births.end],
            born,
            first_birth,
            between,
            source: single((position - swarm.anchor).to_array()),
            carried: single(velocity.to_array()),
            dead,
            other_laws: false,
            reversed: false,
            phase,
            laws,
        });
    }
}

/// Checks the swarms of `world`. Returns whether there are any.
///
/// # Panics
/// If a number of a swarm is out of its range.
fn prepare(world: &mut World) -> bool {
    let mut swarms = world.query::<(&Swarm, Option<&Emitter>, Option<&Off<Emitter>>)>();
    let swarms = swarms.iter(world);
    swarms.map(|(swarm, on, off)| swarm.check(on.or(off.map(|off| &off.0)))).count() > 0
}
