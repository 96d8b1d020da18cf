//! Emission: births and deaths of particles.
//!
//! Both happen at the start of the tick in which they are due. A particle that dies in the tick becomes dormant before
//! the tick is integrated, because at its end it no longer lives. A particle that is born in the tick starts at its
//! emitter with its launch velocity, and is integrated over the rest of the tick.

use std::ops::Range;

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;

use crate::laws::{EvaluationTime, PrescribedMotion};
use crate::state::archetypes::collect;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{PhysicsBody, Quarantined, Transform};
use crate::state::disabled::is_disabled;
use crate::state::emitter::{
    Dormant, Due, Emission, Emissions, Emitter, EmittersChanged, Particle, RidesOn, Tick,
    birth_time,
};
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::state::previous_position::PreviousPosition;
use crate::state::switched_off::Off;
use crate::units::{Scalar, Vector};

/// Position, m, and velocity, m/s, of the body on which an emitter rides; `None` if it cannot carry now.
pub(crate) fn carrier_state(world: &World, RidesOn(body): RidesOn) -> Option<(Vector, Vector)> {
    let body = world.get_entity(body).ok()?;
    let away =
        body.contains::<Quarantined>() || body.contains::<Dormant>() || is_disabled(world, body);
    let (transform, state) = body.get_components::<(&Transform, &PhysicsBody)>().ok()?;
    let (position, velocity) = (transform.position, state.velocity);
    // A body whose state is not finite is about to be quarantined.
    (!away && position.is_finite() && velocity.is_finite()).then_some((position, velocity))
}

/// Position and birth of a particle of an emitter that rides on `carrier`, from those relative to the carrier, in the tick
/// that begins at `start`, s. While the carrier cannot carry, nothing is born.
fn ride(
    world: &World,
    carrier: RidesOn,
    position: Vector,
    birth: Option<(Scalar, Vector)>,
    start: Scalar,
) -> (Vector, Option<(Scalar, Vector)>) {
    let Some((at, velocity)) = carrier_state(world, carrier) else { return (position, None) };
    let Some((time, launch)) = birth else { return (position + at, None) };
    let [at, velocity] = match world.get::<PrescribedMotion>(carrier.0) {
        Some(motion) => motion.at(EvaluationTime::at(time)),
        None => [at + velocity * (time - start), velocity],
    };
    (position + at, Some((time, launch + velocity)))
}

/// The birth or death of the body in a slot.
#[derive(Clone, Copy, Debug)]
pub struct ParticleChange {
    body: Entity,
    position: Vector,
    carrier: Option<RidesOn>,
    inverse_mass: Scalar,
    /// Time, s, and velocity, m/s, of the birth; `None` is a death.
    birth: Option<(Scalar, Vector)>,
}

impl ParticleChange {
    /// Applies the change in the tick that begins at `start`, s.
    fn apply(self, world: &mut World, start: Scalar) {
        let Self { body, mut position, carrier, inverse_mass, birth } = self;
        // No particle is born while its body is disabled.
        let is_disabled = world.get_entity(body).is_ok_and(|body| is_disabled(world, body));
        let mut birth = birth.filter(|_| !is_disabled);
        if let Some(carrier) = carrier {
            (position, birth) = ride(world, carrier, position, birth, start);
        }
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
        // Clears the state of the previous life: the particle is not drawn moving from there, and its method restarts.
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

/// Emitters that are on, and those that are off: their particles may still live.
type Emitters = (
    Option<&'static Emitter>,
    Option<&'static Off<Emitter>>,
    Option<&'static RidesOn>,
    &'static mut Emission,
);

/// The tick that is about to be integrated.
fn coming_tick(world: &World) -> Tick {
    let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
    Tick::next(clock, world.get_resource::<TimeStep>().map_or(0.0, |step| step.0))
}

/// Emits the particles that are due in the tick, and makes those dormant whose life ends in it.
///
/// Times are computed from the start of the scene, never added up. If a slot is needed while its particle still lives,
/// the particle is born again. A slot whose body was quarantined or removed stays empty.
pub fn emit_particles(
    world: &mut World,
    emitters: &mut QueryState<Emitters>,
    mut changes: Local<Vec<ParticleChange>>,
) {
    let tick = coming_tick(world);
    changes.clear();
    let mut over = true;
    for (on, off, carrier, mut emission) in emitters.iter_mut(world) {
        let Some(emitter) = on.or(off.map(|Off(emitter)| emitter)) else { continue };
        if emitter.pool.is_empty() && emission.living() == 0 {
            continue;
        }
        let Emitter { position, inverse_mass, pool, launches, .. } = emitter;
        emission.advance(emitter, on.is_some(), tick, |slot, born| {
            changes.push(ParticleChange {
                body: pool[slot],
                position: *position,
                carrier: carrier.copied(),
                inverse_mass: *inverse_mass,
                birth: born.map(|time| (time, launches[slot])),
            });
        });
        over &= on.is_none() && emission.living() == 0;
    }
    // Room for the following ticks, which then allocate nothing: once the first particles die, as many die as are born.
    let room = changes.len() + 1;
    changes.reserve(room);
    let mut emissions = world.get_resource_or_init::<Emissions>();
    if emissions.tick != tick.number {
        emissions.births.clear();
    }
    emissions
        .births
        .extend(changes.iter().filter_map(|change| Some((change.body, change.birth?.0))));
    let room = emissions.births.len() + 1;
    emissions.births.reserve(room);
    (emissions.over, emissions.tick) = (over, tick.number);
    changes.drain(..).for_each(|change| change.apply(world, tick.start));
}

/// The particles of an emitter with an empty pool that are born and die in a tick.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct DueParticles {
    /// The particles that are due.
    pub births: Range<u64>,
    /// Time of the first birth, s from the start of the tick.
    pub first_birth: Scalar,
    /// Time from birth to birth, s.
    pub between: Scalar,
    /// Particles below this number are dead at the end of the tick.
    pub dead: u64,
    /// Whether the scene was restarted, so that no earlier particle lives.
    pub restarted: bool,
    /// Position of a birth at the start of the tick, m.
    pub position: Vector,
    /// Velocity of the body on which the emitter rides, m/s.
    pub velocity: Vector,
    /// Whether the due particles are born; they are not while the body on which the emitter rides is away.
    pub born: bool,
}

/// Advances an emitter with an empty pool, whose particles share `slots` slots, by the coming tick, for a
/// `ParticleBackend`. `None` if the entity is no emitter, on or off.
pub fn due_particles(world: &mut World, entity: Entity, slots: u64) -> Option<DueParticles> {
    let tick = coming_tick(world);
    let parts = world.get_entity(entity).ok()?;
    let (on, off) = parts.get_components::<(Option<&Emitter>, Option<&Off<Emitter>>)>().ok()?;
    let emitter = on.or(off.map(|Off(emitter)| emitter))?.clone();
    let is_on = on.is_some();
    let carrier = parts.get::<RidesOn>().map(|carrier| carrier_state(world, *carrier));
    let (position, velocity) = carrier.flatten().unwrap_or_default();
    let mut emission = world.get_mut::<Emission>(entity)?;
    let restarted = emission.begin(&emitter, tick);
    let Due { dead, births } = emission.take_due(&emitter, is_on, tick, slots);
    Some(DueParticles {
        first_birth: birth_time(&emitter, births.start) - tick.start,
        between: emitter.rate.recip(),
        births,
        dead,
        restarted,
        position: emitter.position + position,
        velocity,
        born: carrier != Some(None),
    })
}

/// Makes the particles dormant that are in none of the `pools`: their emitter was removed.
fn retire(world: &mut World, pools: &EntityHashSet) {
    let mut particles = world.query_filtered::<(Entity, Has<Quarantined>), With<Particle>>();
    let particles = particles.iter(world).filter(|(body, _)| !pools.contains(body));
    for (body, is_quarantined) in particles.collect::<Vec<_>>() {
        let mut body = world.entity_mut(body);
        body.remove::<Particle>();
        if !is_quarantined {
            body.insert(Dormant);
        }
    }
}

/// The particles that the next tick makes dormant, because their emitter was removed or replaced.
pub(crate) fn orphans(world: &World) -> Vec<Entity> {
    if world.get_resource::<EmittersChanged>().is_some_and(|changed| !changed.0) {
        return Vec::new();
    }
    let mut emitters = world.try_query::<Emitters>().expect("a stepper has prepared the pools");
    let mut living = EntityHashSet::default();
    for (on, off, _, emission) in emitters.iter(world) {
        let pool = on.or(off.map(|Off(emitter)| emitter)).map_or(&[][..], |emitter| &emitter.pool);
        living.extend(
            pool.iter().zip(0..).filter(|(_, slot)| emission.lives(*slot)).map(|(body, _)| *body),
        );
    }
    collect::<Particle, _>(world, |(particle, _)| {
        let body = world.entity(particle);
        let rests = body.contains::<Dormant>() || body.contains::<Quarantined>();
        (!rests && !living.contains(&particle)).then_some(particle)
    })
}

/// Prepares pools: marks their bodies as [`Particle`]s, [`Dormant`] unless they live. Returns whether there are emitters with
/// bodies, or living particles of emitters that are off.
pub(crate) fn prepare(world: &mut World) -> bool {
    let mut pools = Vec::new();
    let mut emits = false;
    let mut emitters = world.query::<Emitters>();
    for (on, off, _, mut emission) in emitters.iter_mut(world) {
        emits |= on.is_some_and(|on| !on.pool.is_empty()) || emission.living() > 0;
        if let Some(emitter) = on.or(off.map(|Off(emitter)| emitter)) {
            emitter.check();
            emission.fit(emitter);
            let lives = (0..).map(|slot| emission.lives(slot));
            pools.extend(emitter.pool.iter().copied().zip(lives));
        }
    }
    let mut bodies: Vec<_> = pools.iter().map(|(body, _)| *body).collect();
    bodies.sort_unstable();
    if let Some(pair) = bodies.windows(2).find(|pair| pair[0] == pair[1]) {
        panic!(
            "the body {} is twice in the pools of emitters; give each emitter bodies of its own",
            pair[0]
        );
    }
    let mut dormant = Vec::new();
    for (body, lives) in &pools {
        if let Ok(mut body) = world.get_entity_mut(*body) {
            if !body.contains::<Particle>() {
                // Every particle is once in the table of the living, so that births find room there and allocate nothing.
                body.insert(Particle).remove::<Dormant>();
            }
            if !lives && !body.contains::<Quarantined>() && !body.contains::<Dormant>() {
                dormant.push((body.id(), Dormant));
            }
        }
    }
    world.insert_batch(dormant);
    if world.get_resource::<EmittersChanged>().is_none_or(|changed| changed.0) {
        retire(world, &pools.into_iter().map(|(body, _)| body).collect());
        world.insert_resource(EmittersChanged(false));
    }
    if emits {
        // Not replaced: births of the coming tick may be in it already.
        world.get_resource_or_init::<Emissions>().over = false;
    } else {
        world.remove_resource::<Emissions>();
    }
    emits
}
