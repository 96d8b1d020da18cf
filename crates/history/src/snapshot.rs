//! Snapshots of scenes: a [`motion::snapshot::Snapshot`] by stable id instead of entity, for files and for new worlds of the
//! same scene.
//!
//! This is the only way to copy a simulation: twins, seeks and bundles all restore a snapshot.

mod id_ranges;
mod restore;

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use motion::internals::values;
use motion::snapshot;
use motion::units::Vector;
use motion::{Evaluations, Method, PhysicsBody, QuarantineRecord, StableId, Transform};
use scene::lists::list_bytes;
use scene::{EmitterSpec, FileIndex, Part, Scene, Substepping};
use serde::{Deserialize, Serialize};
use swarm::SwarmLog as Log;

use crate::simulation::{Simulation, hash_of_states};

use id_ranges::IdRanges;
pub use restore::BadSnapshot;

/// The state of a simulation between two ticks: bodies by their stable ids, emitters by their places in the scene file, and
/// all things that exist, ascending.
///
/// Numbers are those of the world, bit for bit, also in a file. Unknown keys of a file are ignored, and absent ones
/// are empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Snapshot {
    pub(crate) state: snapshot::Snapshot<u32, IdRanges, Log>,
}

impl Simulation {
    /// Keys of the logs of emitters whose particles are on a graphics device: equal keys mean the same particles.
    #[must_use]
    pub fn particle_keys(&self) -> Vec<u64> {
        values::<Log>(&self.world).map(|log| log.key).collect()
    }

    /// Takes a snapshot of the simulation. Call it between two ticks.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let state = snapshot::take_with(&self.world, &self.stepper);
        let mut things: Vec<_> = values::<StableId>(&self.world).map(|id| id.0).collect();
        things.sort_unstable();
        let id = |body: Entity| self.id(body);
        let ranges = |bodies: Vec<Entity>| IdRanges::of(bodies.into_iter().filter_map(id));
        let index = |emitter: Entity| self.world.get::<FileIndex>(emitter).map(|index| index.0);
        // The body may have been removed since, but the record has its id.
        let record = |record: QuarantineRecord| {
            let (body, StableId(id)) = (record.body, record.id?);
            let other_end = record.other_end.map_or(u32::MAX, |id| id.0);
            let renamed = record.rename(|entity| if entity == body { id } else { other_end });
            Some(QuarantineRecord { id: None, other_end: None, ..renamed })
        };
        let state = state.rename(ranges, id, index, record);
        Snapshot { state: snapshot::Snapshot { things: IdRanges::of(things), ..state } }
    }
}

impl Snapshot {
    /// Ticks simulated before the snapshot.
    #[must_use]
    pub const fn ticks(&self) -> u64 {
        self.state.clock.ticks
    }

    /// XXH3-64 over the little-endian f64 bits of position and velocity of every body with physics in stable-id
    /// order, as summaries have it.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let snapshot::Snapshot { bodies, transforms, states, .. } = &self.state;
        let mut rows: Vec<_> = bodies.ids().zip(transforms.iter().zip(states)).collect();
        rows.sort_unstable_by_key(|(id, _)| *id);
        let arrays = |(_, (at, state)): (u32, (&Transform, &PhysicsBody))| {
            (at.position.to_array(), state.velocity.to_array())
        };
        hash_of_states(rows.into_iter().map(arrays))
    }

    /// Bytes of memory of the snapshot, lists as they are allocated.
    #[must_use]
    pub fn bytes(&self) -> usize {
        // A field that is not named here does not compile.
        let snapshot::Snapshot {
            clock: _,
            step: _,
            method: _,
            integrator: _,
            springs: _,
            membership: _,
            substeps: _,
            effects,
            evaluations,
            things,
            bodies,
            transforms,
            states,
            previous_positions,
            quarantined,
            dormant,
            own_methods,
            own_substeps,
            auto_substeps,
            last_steps,
            records,
            emissions,
            logs,
            forces,
            pushes,
            sustained,
            requests,
        } = &self.state;
        let slots = emissions.iter().map(|(_, emission)| list_bytes(&emission.slots));
        size_of::<Self>()
            + list_bytes(&effects.off)
            + evaluations.list_bytes()
            + [things, bodies].map(IdRanges::bytes).iter().sum::<usize>()
            + list_bytes(transforms)
            + list_bytes(states)
            + list_bytes(previous_positions)
            + [quarantined, dormant].map(list_bytes).iter().sum::<usize>()
            + list_bytes(own_methods)
            + list_bytes(own_substeps)
            + list_bytes(auto_substeps)
            + list_bytes(last_steps)
            + list_bytes(records)
            + list_bytes(emissions)
            + slots.sum::<usize>()
            + list_bytes(logs)
            + logs.iter().map(|(_, log)| log.bytes()).sum::<usize>()
            + [forces, pushes, sustained].map(list_bytes).iter().sum::<usize>()
            + list_bytes(requests)
    }

    /// Drops the inputs that wait for the next tick: pushes and requests.
    pub(crate) fn without_inputs(mut self) -> Self {
        self.state.pushes.clear();
        self.state.sustained.clear();
        self.state.requests.clear();
        self
    }

    /// Drops the counts of evaluations and the records of quarantined bodies.
    pub(crate) fn without_history(mut self) -> Self {
        self.state.evaluations = Evaluations::default();
        self.state.records.clear();
        self
    }

    /// The state of `part` of `scene`, without inputs, counts and records. The emission of an emitter with a part of its pool begins
    /// again.
    #[must_use]
    pub fn of_part(&self, scene: &Scene, part: &Part) -> Self {
        let id =
            |id: u32| part.bodies.binary_search(&id).ok().and_then(|at| u32::try_from(at).ok());
        let emitter = |index: u32| {
            let pool = &scene.emitters.get(index as usize)?.pool;
            let is_whole = |own: &EmitterSpec| {
                id(pool.start) == Some(own.pool.start) && own.pool.len() == pool.len()
            };
            u32::try_from(part.scene.emitters.iter().position(is_whole)?).ok()
        };
        let list = |all: IdRanges| IdRanges::of(all.ids().filter_map(id));
        let state = self.clone().without_inputs().without_history().state;
        let mut state = state.rename(list, id, emitter, |_| None);
        state.forces.clear();
        let kept = self.states().filter(|(body, ..)| id(*body).is_some());
        (state.transforms, state.states) = kept
            .map(|(_, x, velocity, inverse_mass)| {
                (Transform::at(x), PhysicsBody { velocity, inverse_mass })
            })
            .unzip();
        Self { state }
    }

    /// Length of the next tick, s.
    #[must_use]
    pub const fn tick_seconds(&self) -> f64 {
        self.state.step.0
    }

    /// The settings of every body with physics: stable id, method and substeps.
    pub fn settings(&self) -> impl Iterator<Item = (u32, Method, Substepping)> + '_ {
        let snapshot::Snapshot {
            method,
            substeps,
            own_methods,
            own_substeps,
            auto_substeps,
            bodies,
            ..
        } = &self.state;
        let methods: HashMap<_, _> = own_methods.iter().copied().collect();
        let numbers: HashMap<_, _> = own_substeps.iter().copied().collect();
        let choices: HashMap<_, _> = auto_substeps.iter().copied().collect();
        bodies.ids().map(move |id| {
            let number = || numbers.get(&id).map_or(substeps.0, |own| own.0).max(1).into();
            let own = choices.get(&id).map_or_else(number, |choice| Substepping::from(*choice));
            (id, methods.get(&id).copied().unwrap_or(*method), own)
        })
    }

    /// Stable id, position, m, velocity, m/s, and inverse mass, 1/kg, of every body with physics.
    pub fn states(&self) -> impl Iterator<Item = (u32, Vector, Vector, f64)> + '_ {
        let snapshot::Snapshot { bodies, transforms, states, .. } = &self.state;
        let rows = bodies.ids().zip(transforms.iter().zip(states));
        rows.map(|(id, (at, body))| (id, at.position, body.velocity, body.inverse_mass))
    }

    /// Turns the snapshot into the start of `scene`, which has other methods: every body gets the method of the
    /// scene, and a previous position for position Verlet counts only with that method.
    pub(crate) fn begin_by_method_of(&mut self, scene: &Scene) {
        let snapshot::Snapshot { method, own_methods, last_steps, bodies, states, .. } =
            &mut self.state;
        *method = scene.method;
        own_methods.clear();
        last_steps.clear();
        for (id, row) in bodies.ids().zip(states) {
            let Some(body) =
                scene.bodies.get(id as usize).filter(|body| body.verlet_previous.is_some())
            else {
                continue;
            };
            let start = scene.verlet_start(body);
            row.velocity = start.map_or(body.velocity, |(velocity, _)| velocity);
            row.inverse_mass = body.inverse_mass.unwrap_or(0.0);
            last_steps.extend(start.map(|(_, last)| (id, last)));
        }
    }
}

#[cfg(test)]
mod tests;
