//! Restores a simulation from a snapshot.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::effects::Effect;
use motion::snapshot::{self, RestoreError};
use motion::{
    Emission, Evaluations, Fault, PhysicsBody, Push, QuarantineRecord, StableId, Stepper, Substeps,
    TimeStep,
};
use scene::{FileIndex, Scene, unsolvable};

use super::{IdRanges, Log, Snapshot};
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
    /// Restores a simulation of `scene`. It continues the run of the snapshot bit for bit; its first tick evaluates
    /// cached accelerations again. `scene` must be the scene of that run, with the options that changed it.
    ///
    /// # Errors
    /// If the snapshot cannot be of a simulation of that scene.
    pub fn restore(scene: impl Into<Arc<Scene>>, snapshot: &Snapshot) -> Result<Self, BadSnapshot> {
        let scene = scene.into();
        snapshot.check(&scene)?;
        let mut world = World::new();
        let bodies = scene.spawn(&mut world);
        snapshot.remove_absent(&mut world, &bodies);
        let state = snapshot.of_world(&mut world, &bodies);
        let mut stepper = Stepper::new(&mut world, state.method, state.step);
        snapshot::restore(&mut world, &mut stepper, &state).map_err(|error| match error {
            RestoreError::Mismatch(_) => BadSnapshot("its bodies are not those of the scene"),
            RestoreError::Invalid { why, .. } => BadSnapshot(why),
            RestoreError::Springs | RestoreError::Integrator => {
                BadSnapshot("its springs or its method are not those of the scene")
            }
        })?;
        Ok(Self { scene, world, stepper, bodies })
    }
}

impl Snapshot {
    /// Checks that the snapshot can be of `scene`.
    fn check(&self, scene: &Scene) -> Result<(), BadSnapshot> {
        let state = &self.state;
        let TimeStep(step) = state.step;
        let count = scene.bodies.len();
        ensure(step > 0.0 && step.is_finite(), "its ticks have no length")?;
        ensure(state.substeps.0 <= Substeps::MOST, "too many substeps per tick")?;
        // Particles of emitters are not attracted.
        let own = state.own_methods.iter().filter(|(id, _)| !scene.is_particle(*id));
        let methods = own.map(|(_, method)| *method).chain([state.method]);
        let attracts =
            scene.mutual_gravity.is_some() && !state.effects.off.contains(&Effect::MutualGravity);
        let solved = |method| unsolvable(method, attracts).is_none();
        ensure({ methods }.all(solved), "its method cannot solve the scene")?;
        let things =
            state.things.below(count).ok_or(BadSnapshot("it has things that the scene lacks"))?;
        ensure(things.is_sorted_by(|a, b| a < b), "its things are not in order")?;
        let mut ids =
            state.bodies.below(count).ok_or(BadSnapshot("it has bodies that the scene lacks"))?;
        ids.sort_unstable();
        let has_physics = |id: &u32| scene.bodies[*id as usize].inverse_mass.is_some();
        let expected = things.iter().copied().filter(has_physics);
        ensure(expected.eq(ids.iter().copied()), "its bodies are not those of the scene")?;
        ensure(ids.len() == state.transforms.len(), "positions and bodies differ in number")?;
        ensure(ids.len() == state.states.len(), "velocities and bodies differ in number")?;
        let holds = state.transforms.iter().all(|at| at.position.is_finite())
            && state
                .states
                .iter()
                .all(|body| body.velocity.is_finite() && body.inverse_mass.is_finite());
        ensure(holds, "its state is not finite")?;
        ensure(state.states.iter().all(|body| body.inverse_mass >= 0.0), "a mass is negative")?;
        let mut places = state.previous_positions.iter();
        ensure(places.all(|(_, place)| place.0.is_finite()), "a place to draw from is not finite")?;
        let mut seen = state.emissions.iter().filter_map(|(_, emission)| emission.seen);
        ensure(
            seen.all(|(tick, _)| tick <= state.clock.ticks),
            "an emitter is ahead of its clock",
        )?;
        let known = state.records.iter().all(|record| (record.body as usize) < count);
        ensure(known, "it has records of things that the scene lacks")?;
        ensure(largest(&state.evaluations) <= MOST_COUNTED, "its counts are too large")?;
        ensure(StepClock::from_state(state.clock).is_some(), "invalid clock")
    }

    fn remove_absent(&self, world: &mut World, bodies: &[Entity]) {
        let mut next = 0;
        let mut remove = |absent: std::ops::Range<usize>| {
            bodies[absent].iter().for_each(|body| {
                world.despawn(*body);
            });
        };
        for [first, count] in &self.state.things.0 {
            remove(next..*first as usize);
            next = (first + count) as usize;
        }
        remove(next..bodies.len());
    }

    /// The snapshot with stable ids replaced by entities of `world`, which has the `bodies` of the scene.
    fn of_world(
        &self,
        world: &mut World,
        bodies: &[Entity],
    ) -> snapshot::Snapshot<Entity, Vec<Entity>, Log> {
        let emissions = of_emitters::<Emission, _>(world, &self.state.emissions);
        let logs = of_emitters::<Log, _>(world, &self.state.logs);
        let body = |id: u32| bodies.get(id as usize).copied();
        let there = |id: u32| body(id).filter(|body| world.get_entity(*body).is_ok());
        let moves = |id: u32| there(id).filter(|body| world.get::<PhysicsBody>(*body).is_some());
        // Pending inputs may name scenery: a request removes it.
        let push =
            |Push { body, newtons }: &_| Some(Push { body: there(*body)?, newtons: *newtons });
        let pushes = |all: &[Push<u32>]| all.iter().filter_map(push).collect();
        let (pushes, sustained) = (pushes(&self.state.pushes), pushes(&self.state.sustained));
        let requests =
            self.state.requests.iter().filter_map(|request| request.rename(there)).collect();
        let record = |record: QuarantineRecord<u32>| {
            let id = Some(StableId(record.body));
            let other_end = match record.cause.fault {
                // A spring end that names no body never had an id.
                Fault::Spring(end) => body(end).map(|_| StableId(end)),
                Fault::Found
                | Fault::Law(_)
                | Fault::Overflow
                | Fault::Range(_)
                | Fault::Request => None,
            };
            let renamed = record.rename(|id| body(id).unwrap_or(Entity::PLACEHOLDER));
            Some(QuarantineRecord { id, other_end, ..renamed })
        };
        let list = |ranges: IdRanges| ranges.ids().filter_map(body).collect();
        let state = self.state.clone().rename(list, moves, |_| None, record);
        let substeps = Substeps(state.substeps.0.max(1));
        let mut state =
            snapshot::Snapshot { substeps, emissions, logs, pushes, sustained, requests, ..state };
        for (_, own) in &mut state.own_substeps {
            own.0 = own.0.clamp(1, Substeps::MOST);
        }
        state
    }
}

/// The emitters of `world` that have a `C`, each with the value `saved` for its place in the scene file, or the
/// default.
fn of_emitters<C: Component, T: Clone + Default>(
    world: &mut World,
    saved: &[(u32, T)],
) -> Vec<(Entity, T)> {
    let mut emitters = world.query_filtered::<(Entity, &FileIndex), With<C>>();
    let of = |(emitter, FileIndex(index)): (Entity, &FileIndex)| {
        let saved = saved.iter().find(|(saved, _)| saved == index);
        (emitter, saved.map_or_else(T::default, |(_, saved)| saved.clone()))
    };
    emitters.iter(world).map(of).collect()
}

/// The largest of all counts.
fn largest(evaluations: &Evaluations) -> u64 {
    let counts = [
        evaluations.accelerations(),
        evaluations.newton_iterations(),
        evaluations.cg_iterations(),
        evaluations.unconverged_steps(),
    ];
    counts.into_iter().chain(evaluations.laws().iter().map(|(_, count)| *count)).max().unwrap_or(0)
}

#[cfg(test)]
mod tests;
