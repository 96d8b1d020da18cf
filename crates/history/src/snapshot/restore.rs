//! Restores a simulation from a snapshot.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::effects::Effect;
use motion::snapshot::{self, EmissionState, LastStep, RestoreError};
use motion::units::Vector;
use motion::{
    Cause, Emission, Evaluations, Fault, Iterations, OwnSubsteps, PhysicsBody, PreviousPosition, Push,
    QuarantineRecord, StableId, Stepper, Substeps, SwarmLog, TimeStep, Transform,
};
use scene::{FileIndex, Scene, unsolvable};

use super::{CountsEntry, EmissionEntry, Name, PushEntry, RecordEntry, SavedFault, Snapshot};
use crate::simulation::Simulation;

/// Largest count of evaluations in a snapshot: no run comes near it, and no run that continues from it overflows a
/// `u64`.
const MOST_COUNTED: u64 = 1 << 53;

/// Why a snapshot does not match a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BadSnapshot(pub(crate) &'static str);

fn ensure(holds: bool, what: &'static str) -> Result<(), BadSnapshot> {
    if holds { Ok(()) } else { Err(BadSnapshot(what)) }
}

impl Simulation {
    /// A simulation of `scene` in that state. It continues the run of the snapshot bit for bit; its first tick
    /// evaluates cached accelerations again. `scene` must be the scene of that run, with the options that changed it.
    ///
    /// # Errors
    /// If the snapshot cannot be of a simulation of that scene.
    pub fn restore(scene: impl Into<Arc<Scene>>, snapshot: &Snapshot) -> Result<Self, BadSnapshot> {
        let scene = scene.into();
        let ids = snapshot.check(&scene)?;
        let clock = StepClock::from_state(snapshot.clock).ok_or(BadSnapshot("invalid clock"))?;
        let mut world = World::new();
        let bodies = scene.spawn(&mut world);
        snapshot.remove_absent(&mut world, &bodies);
        let state = snapshot.state(&mut world, &bodies, &ids, clock);
        let mut stepper = Stepper::new(&mut world, state.method, state.step);
        snapshot::restore(&mut world, &mut stepper, &state).map_err(|error| match error {
            RestoreError::Mismatch(_) => BadSnapshot("its bodies are not those of the scene"),
            RestoreError::Invalid { why, .. } => BadSnapshot(why),
        })?;
        Ok(Self { scene, world, stepper, bodies })
    }
}

impl Snapshot {
    /// Checks that the snapshot can be of `scene`. Returns the ids of its bodies in their order.
    fn check(&self, scene: &Scene) -> Result<Vec<u32>, BadSnapshot> {
        let count = scene.bodies.len();
        ensure(self.step_s > 0.0 && self.step_s.is_finite(), "its ticks have no length")?;
        ensure(self.substeps <= Substeps::MOST, "too many substeps per tick")?;
        // Particles of emitters are not attracted.
        let attracted = |id: &u32| !scene.emitters.iter().any(|emitter| emitter.pool.contains(id));
        let own = self.own_methods.iter().filter(|(id, _)| attracted(id));
        let methods = own.map(|(_, Name(method))| *method).chain([self.method.0]);
        let attracts = scene.mutual_gravity.is_some() && !self.effects.off.contains(&Effect::MutualGravity);
        let solved = |method| unsolvable(method, attracts).is_none();
        ensure({ methods }.all(solved), "its method cannot solve the scene")?;
        let things = expand(&self.things, count).ok_or(BadSnapshot("it has things that the scene lacks"))?;
        ensure(things.is_sorted_by(|a, b| a < b), "its things are not in order")?;
        let ids = expand(&self.bodies, count).ok_or(BadSnapshot("it has bodies that the scene lacks"))?;
        let mut sorted = ids.clone();
        sorted.sort_unstable();
        let has_physics = |id: &u32| scene.bodies[*id as usize].inverse_mass.is_some();
        let expected = things.iter().copied().filter(has_physics);
        ensure(expected.eq(sorted), "its bodies are not those of the scene")?;
        ensure(ids.len() == self.positions.len(), "positions and bodies differ in number")?;
        ensure(ids.len() == self.velocities.len(), "velocities and bodies differ in number")?;
        let numbers = self.positions.iter().flatten().chain(self.velocities.iter().flatten());
        ensure({ numbers }.all(|number| number.is_finite()), "its state is not finite")?;
        ensure(self.velocities.iter().all(|[.., w]| *w >= 0.0), "a mass is negative")?;
        let mut places = self.drawn_from.iter().flat_map(|(_, place)| place);
        ensure(places.all(|number| number.is_finite()), "a place to draw from is not finite")?;
        let late = |(_, emission): &(u32, EmissionEntry)| {
            emission.0.seen.is_some_and(|(tick, _)| tick > self.ticks())
        };
        ensure(!self.emissions.iter().any(late), "an emitter is ahead of its clock")?;
        let known = |record: &RecordEntry| (record.body as usize) < count;
        ensure(self.records.iter().all(known), "it has records of things that the scene lacks")?;
        ensure(self.counts.largest() <= MOST_COUNTED, "its counts are too large")?;
        Ok(ids)
    }

    fn remove_absent(&self, world: &mut World, bodies: &[Entity]) {
        let mut next = 0;
        let mut remove = |absent: std::ops::Range<usize>| {
            bodies[absent].iter().for_each(|body| {
                world.despawn(*body);
            });
        };
        for [first, count] in &self.things {
            remove(next..*first as usize);
            next = (first + count) as usize;
        }
        remove(next..bodies.len());
    }

    /// The snapshot of `world`, which has the `bodies` of the scene; `ids` are those of the snapshot's bodies in
    /// their order.
    fn state(
        &self,
        world: &mut World,
        bodies: &[Entity],
        ids: &[u32],
        clock: StepClock,
    ) -> snapshot::Snapshot {
        let mut emitters = world.query_filtered::<(Entity, &FileIndex), With<Emission>>();
        let emissions = emitters.iter(world).map(|(emitter, FileIndex(index))| {
            let saved = self.emissions.iter().find(|(saved, _)| saved == index);
            (emitter, saved.map_or_else(EmissionState::default, |(_, saved)| saved.0.clone()))
        });
        let emissions = emissions.collect();
        let mut swarms = world.query_filtered::<(Entity, &FileIndex), With<SwarmLog>>();
        let swarms = swarms.iter(world).map(|(emitter, FileIndex(index))| {
            let saved = self.swarms.iter().find(|(saved, _)| saved == index);
            (emitter, saved.map_or_else(SwarmLog::default, |(_, saved)| saved.0.clone()))
        });
        let swarms = swarms.collect();
        let there = |id: u32| bodies.get(id as usize).copied().filter(|body| world.get_entity(*body).is_ok());
        let moves = |id: u32| there(id).filter(|body| world.get::<PhysicsBody>(*body).is_some());
        let pushes = |pushes: &[PushEntry]| -> Vec<_> {
            let push = |(id, newtons): &PushEntry| {
                Some(Push { body: there(*id)?, newtons: Vector::from_array(*newtons) })
            };
            pushes.iter().filter_map(push).collect()
        };
        let state = |[x, y, z, inverse_mass]: &[f64; 4]| PhysicsBody {
            velocity: Vector::new(*x, *y, *z),
            inverse_mass: *inverse_mass,
        };
        let before = |place: &[f64; 3]| PreviousPosition(Vector::from_array(*place));
        snapshot::Snapshot {
            clock,
            step: TimeStep(self.step_s),
            method: self.method.0,
            substeps: Substeps(self.substeps.max(1)),
            effects: self.effects.clone(),
            evaluations: self.evaluations(),
            bodies: ids.iter().map(|id| bodies[*id as usize]).collect(),
            transforms: self.positions.iter().map(|at| Transform::at(Vector::from_array(*at))).collect(),
            states: self.velocities.iter().map(state).collect(),
            previous_positions: of_bodies(&self.drawn_from, moves, before),
            last_steps: of_bodies(&self.last_steps, moves, |last| LastStep(*last)),
            own_methods: of_bodies(&self.own_methods, moves, |method| method.0),
            own_substeps: of_bodies(&self.own_substeps, moves, |own| {
                OwnSubsteps((*own).clamp(1, Substeps::MOST))
            }),
            quarantined: self.quarantined.iter().copied().filter_map(moves).collect(),
            records: self.records.iter().map(|record| record.of(bodies)).collect(),
            dormant: self.dormant.iter().copied().filter_map(moves).collect(),
            emissions,
            swarms,
            forces: Vec::new(),
            pushes: pushes(&self.pushes),
            sustained: pushes(&self.sustained),
            requests: self.requests.iter().filter_map(|request| request.rename(there)).collect(),
        }
    }

    fn evaluations(&self) -> Evaluations {
        let CountsEntry { accelerations, laws, newton_iterations, cg_iterations, unconverged_steps } =
            &self.counts;
        let iterations = Iterations {
            newton: *newton_iterations,
            cg: *cg_iterations,
            unconverged_steps: *unconverged_steps,
        };
        Evaluations::going_on(
            *accelerations,
            laws.iter().map(|(Name(law), count)| (*law, *count)),
            iterations,
        )
    }
}

impl RecordEntry {
    /// The record in a world that has these `bodies`.
    fn of(&self, bodies: &[Entity]) -> QuarantineRecord {
        let (fault, other_end) = match self.fault {
            SavedFault::Found => (Fault::Found, None),
            SavedFault::Law(Name(name)) => (Fault::Law(name), None),
            SavedFault::Spring(end) => match bodies.get(end as usize) {
                Some(body) => (Fault::Spring(*body), Some(StableId(end))),
                // It never had an id.
                None => (Fault::Spring(Entity::PLACEHOLDER), None),
            },
            SavedFault::Overflow => (Fault::Overflow, None),
            SavedFault::Range(bound) => (Fault::Range(bound), None),
            SavedFault::Request => (Fault::Request, None),
        };
        let cause = Cause { system: self.system.0, component: self.component.0, fault };
        let (id, body) = (StableId(self.body), bodies[self.body as usize]);
        QuarantineRecord { body, id: Some(id), other_end, tick: self.tick, cause }
    }
}

/// The values of bodies that exist.
fn of_bodies<Saved, T>(
    all: &[(u32, Saved)],
    body: impl Fn(u32) -> Option<Entity>,
    value: impl Fn(&Saved) -> T,
) -> Vec<(Entity, T)> {
    all.iter().filter_map(|(id, saved)| Some((body(*id)?, value(saved)))).collect()
}

/// The ids in `runs`; `None` if there are more than `count`, one is not below it, or a run is empty.
fn expand(runs: &[[u32; 2]], count: usize) -> Option<Vec<u32>> {
    let mut all = Vec::new();
    for [first, length] in runs {
        let end = first.checked_add(*length).filter(|end| *end as usize <= count)?;
        if *length == 0 || all.len() + *length as usize > count {
            return None;
        }
        all.extend(*first..end);
    }
    Some(all)
}

#[cfg(test)]
mod tests;
