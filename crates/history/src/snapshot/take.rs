//! A snapshot of a simulation.

use bevy_ecs::prelude::*;
use motion::snapshot;
use motion::{Cause, Evaluations, Fault, Push, QuarantineRecord, StableId};
use scene::FileIndex;

use super::{CountsEntry, EmissionEntry, Name, RecordEntry, SavedFault, Snapshot, SwarmEntry};
use crate::simulation::Simulation;

impl Simulation {
    /// Its state, between two ticks.
    pub fn snapshot(&mut self) -> Snapshot {
        let state = snapshot::take(&mut self.world, &self.stepper);
        let mut things: Vec<_> = self.world.query::<&StableId>().iter(&self.world).map(|id| id.0).collect();
        things.sort_unstable();
        let id = |body: Entity| self.id(body);
        let index = |emitter: Entity| self.world.get::<FileIndex>(emitter).map(|index| index.0);
        let pushes = |pushes: Vec<Push>| -> Vec<_> {
            let pushes = pushes.into_iter();
            pushes.filter_map(|push| Some((id(push.body)?, push.newtons.to_array()))).collect()
        };
        let velocity = |state: &motion::PhysicsBody| {
            let [x, y, z] = state.velocity.to_array();
            [x, y, z, state.inverse_mass]
        };
        Snapshot {
            clock: state.clock.into(),
            step_s: state.step.0,
            method: Name(state.method),
            substeps: state.substeps.0,
            effects: state.effects,
            counts: counts(&state.evaluations),
            things: runs(things),
            bodies: runs(state.bodies.iter().filter_map(|body| id(*body))),
            positions: state.transforms.iter().map(|at| at.position.to_array()).collect(),
            velocities: state.states.iter().map(velocity).collect(),
            drawn_from: by_id(state.previous_positions, id, |before| before.0.to_array()),
            quarantined: state.quarantined.into_iter().filter_map(id).collect(),
            dormant: state.dormant.into_iter().filter_map(id).collect(),
            own_methods: by_id(state.own_methods, id, Name),
            own_substeps: by_id(state.own_substeps, id, |substeps| substeps.0),
            last_steps: by_id(state.last_steps, id, |last| last.0),
            records: state.records.iter().filter_map(record).collect(),
            emissions: by_id(state.emissions, index, EmissionEntry),
            swarms: by_id(state.swarms, index, SwarmEntry),
            pushes: pushes(state.pushes),
            sustained: pushes(state.sustained),
            requests: state.requests.into_iter().filter_map(|request| request.rename(id)).collect(),
        }
    }
}

/// Those of entities that have an id.
fn by_id<T, Saved>(
    all: Vec<(Entity, T)>,
    id: impl Fn(Entity) -> Option<u32>,
    saved: impl Fn(T) -> Saved,
) -> Vec<(u32, Saved)> {
    all.into_iter().filter_map(|(entity, value)| Some((id(entity)?, saved(value)))).collect()
}

fn record(record: &QuarantineRecord) -> Option<RecordEntry> {
    // The body itself may be gone since.
    let StableId(body) = record.id?;
    let Cause { system, component, fault } = record.cause;
    let fault = match fault {
        Fault::Found => SavedFault::Found,
        Fault::Law(name) => SavedFault::Law(Name(name)),
        Fault::Spring(_) => SavedFault::Spring(record.other_end.map_or(u32::MAX, |id| id.0)),
        Fault::Overflow => SavedFault::Overflow,
        Fault::Range(bound) => SavedFault::Range(bound),
        Fault::Request => SavedFault::Request,
    };
    Some(RecordEntry { body, tick: record.tick, system: Name(system), component: Name(component), fault })
}

fn counts(evaluations: &Evaluations) -> CountsEntry {
    CountsEntry {
        accelerations: evaluations.accelerations(),
        laws: evaluations.laws().iter().map(|(law, count)| (Name(*law), *count)).collect(),
        newton_iterations: evaluations.newton_iterations(),
        cg_iterations: evaluations.cg_iterations(),
        unconverged_steps: evaluations.unconverged_steps(),
    }
}

/// Consecutive numbers as runs.
fn runs(ids: impl IntoIterator<Item = u32>) -> Vec<[u32; 2]> {
    let mut runs: Vec<[u32; 2]> = Vec::new();
    for id in ids {
        match runs.last_mut() {
            Some([first, count]) if first.checked_add(*count) == Some(id) => *count += 1,
            _ => runs.push([id, 1]),
        }
    }
    runs
}
