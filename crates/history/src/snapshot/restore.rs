//! A simulation from a snapshot.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::effects::Effect;
use motion::snapshot::LastStep;
use motion::units::Vector;
use motion::{
    Cause, Dormant, Emission, Evaluations, Fault, Iterations, OwnSubsteps, PhysicsBody, PreviousPosition,
    Push, PushQueue, Quarantine, QuarantineRecord, Quarantined, Requests, StableId, Stepper, Substeps,
    TimeStep, Transform, mark_method, own_method,
};

use scene::{FileIndex, Scene, unsolvable};

use super::{EmissionEntry, Name, PushEntry, RecordEntry, SavedFault, Snapshot};
use crate::simulation::Simulation;

/// Largest count that a restored run may start from: no run comes near it, and none gets from it beyond a `u64`.
const MOST_COUNTED: u64 = 1 << 53;

/// Why a snapshot does not match a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BadSnapshot(pub(crate) &'static str);

fn ensure(holds: bool, what: &'static str) -> Result<(), BadSnapshot> {
    if holds { Ok(()) } else { Err(BadSnapshot(what)) }
}

/// Marks a body while its row is moved to the end of its table.
#[derive(Component)]
struct Moved;

impl Simulation {
    /// A simulation of `scene` in that state. It goes on, bit for bit, as the one that the snapshot was taken of; its first
    /// tick evaluates accelerations again that were cached there. `scene` is what that one was spawned from, options that
    /// change scenes included.
    ///
    /// # Errors
    /// A snapshot that cannot have been taken of a simulation of that scene.
    pub fn restore(scene: impl Into<Arc<Scene>>, snapshot: &Snapshot) -> Result<Self, BadSnapshot> {
        let scene = scene.into();
        let ids = snapshot.check(&scene)?;
        let clock = StepClock::from_state(snapshot.clock).ok_or(BadSnapshot("invalid clock"))?;
        let mut world = World::new();
        let bodies = scene.spawn(&mut world);
        world.insert_resource(Substeps(snapshot.substeps));
        world.insert_resource(clock);
        snapshot.remove_absent(&mut world, &bodies);
        snapshot.put_bodies(&mut world, &bodies, &ids);
        snapshot.effects.put(&mut world);
        snapshot.put_emissions(&mut world);
        let mut stepper = Stepper::new(&mut world, snapshot.method.0, TimeStep(snapshot.step_s));
        snapshot.put_counts(&mut world);
        snapshot.put_records(&mut world, &bodies);
        put_in_order(&mut world, &ids);
        snapshot.put_inputs(&mut world, &bodies);
        stepper.recompile(&mut world);
        Ok(Self { scene, world, stepper, bodies })
    }
}

impl Snapshot {
    /// Whether it can be of `scene`; the ids of its bodies in their order.
    fn check(&self, scene: &Scene) -> Result<Vec<u32>, BadSnapshot> {
        let count = scene.bodies.len();
        ensure(self.step_s > 0.0 && self.step_s.is_finite(), "its ticks have no length")?;
        ensure(self.substeps <= Substeps::MOST, "too many substeps per tick")?;
        // Particles of emitters are not attracted.
        let attracted = |id: &u32| !scene.emitters.iter().any(|emitter| emitter.pool.contains(id));
        let own = self.own_methods.iter().filter(|(id, _)| attracted(id));
        let methods = own.map(|(_, Name(method))| *method).chain([self.method.0]);
        let attracts = scene.mutual_gravity.is_some() && !self.effects.is_off(Effect::MutualGravity);
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

    fn put_bodies(&self, world: &mut World, bodies: &[Entity], ids: &[u32]) {
        for (id, (position, [x, y, z, inverse_mass])) in
            ids.iter().zip(self.positions.iter().zip(&self.velocities))
        {
            let mut body = world.entity_mut(bodies[*id as usize]);
            body.insert((
                Transform::at(Vector::from_array(*position)),
                PhysicsBody { velocity: Vector::new(*x, *y, *z), inverse_mass: *inverse_mass },
            ));
            // Those that have some are given them below.
            body.remove::<(LastStep, OwnSubsteps, Dormant)>();
            if own_method(body.as_readonly()).is_some() {
                mark_method(&mut body, None);
            }
        }
        for (id, Name(method)) in &self.own_methods {
            if let Some(mut body) = with_physics(world, bodies, *id) {
                mark_method(&mut body, Some(*method));
            }
        }
        let substeps = |(id, substeps): &(u32, u32)| (*id, OwnSubsteps((*substeps).min(Substeps::MOST)));
        give(world, bodies, self.own_substeps.iter().map(substeps));
        give(world, bodies, self.last_steps.iter().map(|(id, step)| (*id, LastStep(*step))));
        let before = |(id, place): &(u32, [f64; 3])| (*id, PreviousPosition(Vector::from_array(*place)));
        give(world, bodies, self.drawn_from.iter().map(before));
        give(world, bodies, self.dormant.iter().map(|id| (*id, Dormant)));
        give(world, bodies, self.quarantined.iter().map(|id| (*id, Quarantined)));
    }

    fn put_emissions(&self, world: &mut World) {
        for (index, mut emission) in world.query::<(&FileIndex, &mut Emission)>().iter_mut(world) {
            if let Some((_, saved)) = self.emissions.iter().find(|(saved, _)| *saved == index.0) {
                *emission = Emission::from_state(saved.0.clone());
            }
        }
    }

    fn put_counts(&self, world: &mut World) {
        let counts = &self.counts;
        let iterations = Iterations {
            newton: counts.newton_iterations,
            cg: counts.cg_iterations,
            unconverged_steps: counts.unconverged_steps,
        };
        let laws = counts.laws.iter().map(|(Name(law), count)| (*law, *count));
        world.insert_resource(Evaluations::going_on(counts.accelerations, laws, iterations));
    }

    fn put_records(&self, world: &mut World, bodies: &[Entity]) {
        let records = self.records.iter().map(|record| {
            let (fault, other_end) = match record.fault {
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
            let cause = Cause { system: record.system.0, component: record.component.0, fault };
            let (id, body) = (StableId(record.body), bodies[record.body as usize]);
            QuarantineRecord { body, id: Some(id), other_end, tick: record.tick, cause }
        });
        world.insert_resource(Quarantine::going_on(records.collect()));
    }

    fn put_inputs(&self, world: &mut World, bodies: &[Entity]) {
        let there = |id: u32| bodies.get(id as usize).copied().filter(|body| world.get_entity(*body).is_ok());
        let push = |(id, newtons): &PushEntry| {
            Some(Push { body: there(*id)?, newtons: Vector::from_array(*newtons) })
        };
        let mut queue = PushQueue::default();
        for Push { body, newtons } in self.pushes.iter().filter_map(push) {
            queue.push_once(body, newtons);
        }
        queue.sustain(self.sustained.iter().filter_map(push));
        let mut requests = Requests::default();
        self.requests
            .iter()
            .filter_map(|request| request.rename(there))
            .for_each(|request| requests.ask(request));
        world.insert_resource(queue);
        world.insert_resource(requests);
    }
}

/// The body of that id, if it is there and has physics.
fn with_physics<'w>(world: &'w mut World, bodies: &[Entity], id: u32) -> Option<EntityWorldMut<'w>> {
    let body = world.get_entity_mut(*bodies.get(id as usize)?).ok()?;
    body.contains::<PhysicsBody>().then_some(body)
}

/// Gives each of those bodies its component.
fn give<C: Component>(world: &mut World, bodies: &[Entity], all: impl Iterator<Item = (u32, C)>) {
    for (id, component) in all {
        if let Some(mut body) = with_physics(world, bodies, id) {
            body.insert(component);
        }
    }
}

/// The numbers of runs; `None` where there are more than `count`, one is not below it, or a run is empty.
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

/// Brings the rows of every table into the order of `ids`.
fn put_in_order(world: &mut World, ids: &[u32]) {
    let mut place = vec![u32::MAX; ids.iter().max().map_or(0, |most| *most as usize + 1)];
    for (number, id) in (0..).zip(ids) {
        place[*id as usize] = number;
    }
    let mut bodies = world.query_filtered::<(Entity, &StableId), With<PhysicsBody>>();
    let tables: Vec<Vec<_>> = bodies
        .contiguous_iter(world)
        .expect("every component of a body is stored in tables")
        .map(|(bodies, ids)| bodies.iter().copied().zip(ids.iter().map(|id| place[id.0 as usize])).collect())
        .collect();
    for mut table in tables {
        if !table.is_sorted_by_key(|(_, place)| *place) {
            table.sort_unstable_by_key(|(_, place)| *place);
            for (body, _) in &table {
                world.entity_mut(*body).insert(Moved);
            }
            for (body, _) in &table {
                world.entity_mut(*body).remove::<Moved>();
            }
        }
    }
}

#[cfg(test)]
mod tests;
