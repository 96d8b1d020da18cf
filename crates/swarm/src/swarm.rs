//! The system that enters the ticks of swarms into their logs.

use bevy_ecs::prelude::*;

use crate::schedule::emission::carrier_state;
use crate::schedule::swarm::{Swarm, SwarmLog, SwarmTick};
use crate::schedule::swarm_laws::{SwarmLaws, single};
use crate::state::clock::{StepClock, TimeStep};
use crate::state::emitter::{Due, Emission, Emitter, RidesOn, Tick, birth_time};
use crate::state::substeps::Substeps;
use crate::state::switched_off::Off;
use crate::units::Vector;

/// Enters the tick into the log of every swarm: births, deaths and laws.
pub fn advance_swarms(
    world: &mut World,
    swarms: &mut QueryState<(Entity, &Swarm)>,
    mut found: Local<Vec<(Entity, Swarm)>>,
) {
    let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
    let TimeStep(step) = world.get_resource().copied().unwrap_or(TimeStep(0.0));
    let tick = Tick::next(clock, step);
    let substeps = Substeps::count(world.get_resource());
    found.extend(swarms.iter(world).map(|(entity, swarm)| (entity, swarm.clone())));
    for (entity, swarm) in found.drain(..) {
        let before =
            world.get::<SwarmLog>(entity).and_then(|log| log.ticks.back()).map(|tick| &tick.laws);
        let (laws, phase) = SwarmLaws::of(world, swarm.anchor, tick.start, before);
        let Ok(parts) = world.get_entity(entity) else { continue };
        let on = parts.get::<Emitter>();
        let off = parts.get::<Off<Emitter>>().map(|Off(emitter)| emitter);
        let Some(emitter) = on.or(off).cloned() else {
            // Its emitter was removed, and its particles with it.
            if let Some(mut log) = world.get_mut::<SwarmLog>(entity) {
                *log = SwarmLog::default();
            }
            continue;
        };
        let is_on = on.is_some();
        let substeps = swarm.substeps.unwrap_or(substeps);
        let carrier = parts.get::<RidesOn>().map(|carrier| carrier_state(world, *carrier));
        let Some(mut emission) = world.get_mut::<Emission>(entity) else { continue };
        let (Due { dead, births }, restarted) =
            emission.advance_without_slots(&emitter, is_on, tick, swarm.slots());
        let (at, velocity) = carrier.flatten().unwrap_or((Vector::ZERO, Vector::ZERO));
        let first_birth = birth_time(&emitter, births.start) - tick.start;
        let [step, first_birth, between] = single([step, first_birth, emitter.rate.recip()]);
        let Some(mut log) = world.get_mut::<SwarmLog>(entity) else { continue };
        if restarted {
            *log = SwarmLog::default();
        }
        // Nothing moves in a tick without a length.
        if step == 0.0 {
            continue;
        }
        log.enter(SwarmTick {
            key: 0,
            step,
            substeps,
            births: [births.start, births.end],
            // Without a carrier nothing is born.
            born: carrier != Some(None),
            first_birth,
            between,
            source: single((emitter.position + at - swarm.anchor).to_array()),
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
pub(crate) fn prepare(world: &mut World) -> bool {
    let mut swarms = world.query::<(&Swarm, Option<&Emitter>, Option<&Off<Emitter>>)>();
    let mut some = false;
    for (swarm, on, off) in swarms.iter(world) {
        if let Some(emitter) = on.or(off.map(|Off(emitter)| emitter)) {
            swarm.check(emitter);
        }
        some = true;
    }
    some
}
