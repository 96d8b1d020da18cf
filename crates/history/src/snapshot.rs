//! Snapshots of scenes: [`motion::snapshot`] by stable id instead of entity, for files and for new worlds of the same
//! scene.
//!
//! A simulation is copied in no other way: twins, going back and bundles all restore a snapshot.

mod entries;
mod restore;
mod swarm;
mod take;
pub mod words;

use motion::clock::ClockState;
use motion::snapshot::Effects;
use motion::{Method, Request};
use scene::Scene;
use serde::{Deserialize, Serialize};

use crate::simulation::hash_of_states;
use scene::lists::{list, list_bytes};

pub use restore::BadSnapshot;
use swarm::SwarmEntry;

#[cfg(test)]
pub(crate) use entries::RequestEntry;
use entries::{ClockFields, CountsEntry, EffectsFields, EmissionEntry, PushEntry, RecordEntry, SavedFault};
pub(crate) use entries::{requests, vector};
pub(crate) use words::Name;

/// The state of a simulation between two ticks.
///
/// Numbers are those of the world, bit for bit, also in a file. Unknown keys of a file are ignored, and absent ones
/// are empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Snapshot {
    #[serde(with = "ClockFields")]
    pub(crate) clock: ClockState,
    /// Length of a tick, s.
    pub(crate) step_s: f64,
    pub(crate) method: Name<Method>,
    /// Substeps of bodies without their own.
    pub(crate) substeps: u32,
    #[serde(with = "EffectsFields")]
    pub(crate) effects: Effects,
    pub(crate) counts: CountsEntry,
    /// Things that exist, scenery too: runs of stable ids, ascending, each as its first id and its length.
    #[serde(deserialize_with = "list")]
    pub(crate) things: Vec<[u32; 2]>,
    /// Bodies with physics, in the order of their tables: laws are called for several rows at once, so that counts of
    /// evaluations depend on which rows are neighbors. Runs as above.
    #[serde(deserialize_with = "list")]
    pub(crate) bodies: Vec<[u32; 2]>,
    /// Positions of the bodies in that order, m.
    #[serde(deserialize_with = "list")]
    pub(crate) positions: Vec<[f64; 3]>,
    /// Their velocities, m/s, and inverse masses, 1/kg.
    #[serde(deserialize_with = "list")]
    pub(crate) velocities: Vec<[f64; 4]>,
    /// Positions of bodies before the last tick, m, in runs that draw between ticks.
    #[serde(deserialize_with = "list")]
    pub(crate) drawn_from: Vec<(u32, [f64; 3])>,
    #[serde(deserialize_with = "list")]
    pub(crate) quarantined: Vec<u32>,
    /// Particles that are not alive.
    #[serde(deserialize_with = "list")]
    pub(crate) dormant: Vec<u32>,
    #[serde(deserialize_with = "list")]
    pub(crate) own_methods: Vec<(u32, Name<Method>)>,
    #[serde(deserialize_with = "list")]
    pub(crate) own_substeps: Vec<(u32, u32)>,
    /// Lengths of the last steps of position Verlet, s.
    #[serde(deserialize_with = "list")]
    pub(crate) last_steps: Vec<(u32, f64)>,
    #[serde(deserialize_with = "list")]
    pub(crate) records: Vec<RecordEntry>,
    /// The state of each emitter, by its index in the scene file.
    #[serde(deserialize_with = "list")]
    pub(crate) emissions: Vec<(u32, EmissionEntry)>,
    /// The ticks of each swarm, by the index of its emitter in the scene file.
    #[serde(deserialize_with = "list", skip_serializing_if = "Vec::is_empty")]
    pub(crate) swarms: Vec<(u32, SwarmEntry)>,
    /// Pushes that wait for a tick.
    #[serde(deserialize_with = "list")]
    pub(crate) pushes: Vec<PushEntry>,
    /// Pushes that act in every tick.
    #[serde(deserialize_with = "list")]
    pub(crate) sustained: Vec<PushEntry>,
    /// Requests that wait for a tick.
    #[serde(with = "requests")]
    pub(crate) requests: Vec<Request<u32>>,
}

impl Snapshot {
    /// Ticks simulated before the snapshot.
    #[must_use]
    pub const fn ticks(&self) -> u64 {
        self.clock.ticks
    }

    /// XXH3-64 over the little-endian f64 bits of position and velocity of every body with physics in stable-id
    /// order, as summaries have it.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let ids = self.bodies.iter().flat_map(|[first, count]| *first..first.saturating_add(*count));
        let mut rows: Vec<_> = ids.zip(self.positions.iter().zip(&self.velocities)).collect();
        rows.sort_unstable_by_key(|(id, _)| *id);
        hash_of_states(rows.into_iter().map(|(_, (position, [x, y, z, _]))| (*position, [*x, *y, *z])))
    }

    /// Bytes of memory of the snapshot, lists as they are allocated.
    #[must_use]
    pub fn bytes(&self) -> usize {
        // A field that is not named here does not compile.
        let Self {
            clock: _,
            step_s: _,
            method: _,
            substeps: _,
            effects,
            counts,
            things,
            bodies,
            positions,
            velocities,
            drawn_from,
            quarantined,
            dormant,
            own_methods,
            own_substeps,
            last_steps,
            records,
            emissions,
            swarms,
            pushes,
            sustained,
            requests,
        } = self;
        let slots = emissions.iter().map(|(_, emission)| list_bytes(&emission.0.slots));
        size_of::<Self>()
            + list_bytes(&effects.off)
            + list_bytes(&counts.laws)
            + [things, bodies].map(list_bytes).iter().sum::<usize>()
            + list_bytes(positions)
            + list_bytes(velocities)
            + list_bytes(drawn_from)
            + [quarantined, dormant].map(list_bytes).iter().sum::<usize>()
            + list_bytes(own_methods)
            + list_bytes(own_substeps)
            + list_bytes(last_steps)
            + list_bytes(records)
            + list_bytes(emissions)
            + slots.sum::<usize>()
            + list_bytes(swarms)
            + swarms.iter().map(|(_, swarm)| swarm.0.bytes()).sum::<usize>()
            + [pushes, sustained].map(list_bytes).iter().sum::<usize>()
            + list_bytes(requests)
    }

    /// Drops the inputs that wait for the next tick: pushes and requests.
    pub(crate) fn without_inputs(mut self) -> Self {
        self.pushes.clear();
        self.sustained.clear();
        self.requests.clear();
        self
    }

    /// Drops the counts of evaluations and the records of quarantined bodies.
    pub(crate) fn without_history(mut self) -> Self {
        self.counts = CountsEntry::default();
        self.records.clear();
        self
    }

    /// Makes it the start of `scene`, which has other methods: every body gets the method of the scene, and a
    /// previous position of position Verlet counts only under that method.
    pub(crate) fn begin_by_method_of(&mut self, scene: &Scene) {
        self.method = Name(scene.method);
        self.own_methods.clear();
        self.last_steps.clear();
        let ids = self.bodies.iter().flat_map(|[first, count]| *first..first.saturating_add(*count));
        for (id, row) in ids.zip(&mut self.velocities) {
            let Some(body) = scene.bodies.get(id as usize).filter(|body| body.verlet_previous.is_some())
            else {
                continue;
            };
            let start = scene.verlet_start(body);
            let [x, y, z] = start.map_or(body.velocity, |(velocity, _)| velocity).to_array();
            *row = [x, y, z, body.inverse_mass.unwrap_or(0.0)];
            self.last_steps.extend(start.map(|(_, last)| (id, last.0)));
        }
    }
}

#[cfg(test)]
mod tests;
