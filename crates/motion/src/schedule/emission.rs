//! How particles are born and taken back.
//!
//! Both happen at the start of the tick that holds their time. A particle whose life ends in the tick is taken back
//! before the tick is integrated, for at its end it is not there. One that is born in the tick stands at the emitter
//! with its launch velocity; the systems that integrate bodies give it the rest of the tick, from its birth on.

use bevy_ecs::prelude::*;

use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{PhysicsBody, Quarantined, Transform};
use crate::state::emitter::{Dormant, Emission, Emissions, Emitter, Particle, Tick};
use crate::state::interpolate::PreviousPosition;
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::state::off::Off;
use crate::units::{Scalar, Vector};

/// What becomes of the body in a slot.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    body: Entity,
    position: Vector,
    inverse_mass: Scalar,
    /// Time of a birth, s, and its velocity, m/s; `None` is the end of a life.
    birth: Option<(Scalar, Vector)>,
}

impl Change {
    fn carry_out(self, world: &mut World) {
        let Self { body, position, inverse_mass, birth } = self;
        let Ok(mut body) = world.get_entity_mut(body) else { return };
        if body.contains::<Quarantined>() {
            return;
        }
        if let Some(mut transform) = body.get_mut::<Transform>() {
            transform.position = position;
        }
        if let Some(mut state) = body.get_mut::<PhysicsBody>() {
            let velocity = birth.map_or(Vector::ZERO, |(_, velocity)| velocity);
            *state = PhysicsBody { velocity, inverse_mass };
        }
        // Nothing of another life: it is not drawn on the way from there, and its method starts anew.
        if let Some(mut before) = body.get_mut::<PreviousPosition>() {
            before.0 = position;
        }
        if let Some(mut last) = body.get_mut::<LastStep>() {
            *last = LastStep::default();
        }
        if let Some(mut last) = body.get_mut::<LastAcceleration>() {
            *last = LastAcceleration::default();
        }
        match (birth, body.contains::<Dormant>()) {
            (Some(_), true) => drop(body.remove::<Dormant>()),
            (None, false) => drop(body.insert(Dormant)),
            _ => {}
        }
    }
}

/// Emitters, and those whose particles still fly after they were switched off.
type Emitters = (Option<&'static Emitter>, Option<&'static Off<Emitter>>, &'static mut Emission);

/// Lets particles be born that are due before the end of the tick, and takes back those whose life is over at its end.
///
/// A particle that is born stands at its emitter with its launch velocity, to be integrated from its birth on. Times are
/// the scene's and never added up. A particle that still lives when its slot is needed is taken; a slot whose body was
/// quarantined or removed stays empty.
pub fn emit_particles(
    world: &mut World,
    emitters: &mut QueryState<Emitters>,
    mut changes: Local<Vec<Change>>,
) {
    let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
    let tick = Tick::next(clock, world.get_resource::<TimeStep>().map_or(0.0, |step| step.0));
    changes.clear();
    let mut over = true;
    for (on, off, mut emission) in emitters.iter_mut(world) {
        let Some(emitter) = on.or(off.map(|Off(emitter)| emitter)) else { continue };
        let Emitter { position, inverse_mass, pool, launches, .. } = emitter;
        emission.advance(emitter, on.is_some(), tick, |slot, born| {
            changes.push(Change {
                body: pool[slot],
                position: *position,
                inverse_mass: *inverse_mass,
                birth: born.map(|time| (time, launches[slot])),
            });
        });
        over &= on.is_none() && emission.living() == 0;
    }
    // Once the first of them have lived, as many die as are born.
    let now = changes.len();
    changes.reserve(now + 1);
    let mut emissions = world.get_resource_or_init::<Emissions>();
    if emissions.tick != tick.number {
        emissions.births.clear();
    }
    emissions.births.extend(changes.iter().filter_map(|change| Some((change.body, change.birth?.0))));
    let now = emissions.births.len();
    emissions.births.reserve(now + 1);
    (emissions.over, emissions.tick) = (over, tick.number);
    changes.drain(..).for_each(|change| change.carry_out(world));
}

/// Whether there are emitters, or particles of some that were switched off; marks the bodies of their pools.
pub(crate) fn prepare(world: &mut World) -> bool {
    let mut pools = Vec::new();
    let mut goes_on = false;
    let mut emitters = world.query::<Emitters>();
    for (on, off, mut emission) in emitters.iter_mut(world) {
        goes_on |= on.is_some() || emission.living() > 0;
        if let Some(emitter) = on.or(off.map(|Off(emitter)| emitter)) {
            emission.fit(emitter);
            pools.extend_from_slice(&emitter.pool);
        }
    }
    let mut dormant = Vec::new();
    for body in pools {
        if let Ok(mut body) = world.get_entity_mut(body)
            && !body.contains::<Particle>()
        {
            body.insert(Particle);
            // All of them once in the tables of the living: births find room there without asking for memory.
            if body.take::<Dormant>().is_some() {
                dormant.push((body.id(), Dormant));
            }
        }
    }
    world.insert_batch(dormant);
    if goes_on {
        // Births of the coming tick may be known already.
        world.get_resource_or_init::<Emissions>().over = false;
    } else {
        world.remove_resource::<Emissions>();
    }
    goes_on
}
