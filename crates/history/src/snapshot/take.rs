//! A snapshot of a simulation.

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::snapshot::LastStep;
use motion::{
    Cause, Dormant, Emission, Evaluations, Fault, OwnMethod, OwnSubsteps, PhysicsBody, PreviousPosition,
    Push, PushQueue, Quarantine, Quarantined, StableId, Substeps, TimeStep, Transform, own_method,
};
use scene::FileIndex;

use super::{CountsEntry, EffectsState, EmissionEntry, Name, PushEntry, RecordEntry, SavedFault, Snapshot};
use crate::simulation::Simulation;

impl Simulation {
    /// Its state, between two ticks.
    pub fn snapshot(&mut self) -> Snapshot {
        let (method, world) = (self.method(), &mut self.world);
        let mut snapshot = Snapshot {
            clock: (*world.resource::<StepClock>()).into(),
            step_s: world.resource::<TimeStep>().0,
            method: Name(method),
            substeps: world.get_resource::<Substeps>().map_or(1, |substeps| substeps.0),
            effects: EffectsState::of(world),
            counts: counts(world.resource::<Evaluations>()),
            ..Snapshot::default()
        };
        snapshot.take_bodies(world);
        snapshot.take_emissions(world);
        snapshot.take_inputs(self);
        snapshot
    }
}

impl Snapshot {
    fn take_bodies(&mut self, world: &mut World) {
        let mut things: Vec<_> = world.query::<&StableId>().iter(world).map(|id| id.0).collect();
        things.sort_unstable();
        self.things = runs(things);
        let mut bodies = world.query::<(
            &StableId,
            &Transform,
            &PhysicsBody,
            Has<Quarantined>,
            Has<Dormant>,
            Option<&OwnSubsteps>,
            Option<&LastStep>,
            Option<&PreviousPosition>,
        )>();
        let bodies = bodies.iter(world);
        let count = bodies.len();
        let mut ids = Vec::with_capacity(count);
        self.positions.reserve_exact(count);
        self.velocities.reserve_exact(count);
        for (StableId(id), at, body, quarantined, dormant, substeps, last, before) in bodies {
            ids.push(*id);
            self.positions.push(at.position.to_array());
            let [x, y, z] = body.velocity.to_array();
            self.velocities.push([x, y, z, body.inverse_mass]);
            self.quarantined.extend(quarantined.then_some(*id));
            self.dormant.extend(dormant.then_some(*id));
            self.own_substeps.extend(substeps.map(|substeps| (*id, substeps.0)));
            self.last_steps.extend(last.map(|last| (*id, last.0)));
            self.drawn_from.extend(before.map(|before| (*id, before.0.to_array())));
        }
        self.bodies = runs(ids);
        let mut marked = world.query_filtered::<(EntityRef, &StableId), With<OwnMethod>>();
        self.own_methods =
            marked.iter(world).filter_map(|(body, id)| Some((id.0, Name(own_method(body)?)))).collect();
    }

    fn take_emissions(&mut self, world: &mut World) {
        let mut emissions = world.query::<(&FileIndex, &Emission)>();
        self.emissions = emissions
            .iter(world)
            .map(|(index, emission)| (index.0, EmissionEntry(emission.state())))
            .collect();
    }

    fn take_inputs(&mut self, simulation: &Simulation) {
        let world = &simulation.world;
        let records = world.resource::<Quarantine>().records().iter();
        self.records = records
            .filter_map(|record| {
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
                let (system, component) = (Name(system), Name(component));
                Some(RecordEntry { body, tick: record.tick, system, component, fault })
            })
            .collect();
        let push =
            |push: &Push| -> Option<PushEntry> { Some((simulation.id(push.body)?, push.newtons.to_array())) };
        let queue = world.resource::<PushQueue>();
        self.pushes = queue.edges().iter().filter_map(push).collect();
        self.sustained = queue.sustained().iter().filter_map(push).collect();
        self.requests = simulation.requested().collect();
    }
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
