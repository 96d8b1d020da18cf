//! How particles are born and taken back.

use bevy_ecs::prelude::*;

use crate::clock::StepClock;
use crate::components::{PhysicsBody, Quarantined, Transform};
use crate::emitter::{Dormant, Emitter};
use crate::interpolate::PreviousPosition;
use crate::own::{LastAcceleration, LastStep};
use crate::switch::Off;
use crate::units::{Scalar, Vector};

/// A birth or death this near, in births, is due: 1/60 s times 500 a second may come out a rounding below.
const NEARLY: Scalar = 1e-6;

/// The slot is free.
const FREE: u64 = u64::MAX;

/// A body of an emitter's pool, living or [`Dormant`].
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Particle;

/// What an emitter has thrown out so far; every [`Emitter`] has one.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct Emission {
    /// Number of the particle that is born next.
    next: u64,
    /// No particle below that number lives.
    oldest: u64,
    /// Number of the particle that lives in each slot of the pool.
    slots: Vec<u64>,
    living: usize,
    /// Number and time of the tick in which it was looked at last.
    seen: Option<(u64, Scalar)>,
}

/// What an [`Emission`] goes on from, by slots of the pool.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EmissionState {
    /// Number of the particle that is born next.
    pub next: u64,
    /// No particle below that number lives.
    pub oldest: u64,
    /// Number of the particle that lives in each slot; `None` is a free one.
    pub slots: Vec<Option<u64>>,
    /// Number and scene's time, s, of the tick in which it was looked at last.
    pub seen: Option<(u64, Scalar)>,
}

/// Whether anything is left to do for [`emit_particles`].
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Emissions {
    /// Every emitter is off, and every particle taken back.
    pub over: bool,
}

/// What becomes of the body in a slot.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    body: Entity,
    position: Vector,
    inverse_mass: Scalar,
    /// Velocity of a birth, m/s; `None` is the end of a life.
    launch: Option<Vector>,
}

/// Particles whose birth is at or before `time`, s since the scene's start.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be at least 0")]
fn due(emitter: &Emitter, time: Scalar) -> u64 {
    let births = time * emitter.rate + NEARLY;
    if births >= 0.0 { (births as u64).saturating_add(1) } else { 0 }
}

impl Emission {
    /// Particles that live.
    #[must_use]
    pub const fn living(&self) -> usize {
        self.living
    }

    /// What it goes on from.
    #[must_use]
    pub fn state(&self) -> EmissionState {
        let Self { next, oldest, slots, seen, .. } = self;
        let slots = slots.iter().map(|slot| (*slot != FREE).then_some(*slot)).collect();
        EmissionState { next: *next, oldest: *oldest, slots, seen: *seen }
    }

    /// An emission that goes on from `state`.
    #[must_use]
    pub fn from_state(state: EmissionState) -> Self {
        let EmissionState { next, oldest, slots, seen } = state;
        let living = slots.iter().flatten().count();
        let slots = slots.into_iter().map(|slot| slot.unwrap_or(FREE)).collect();
        Self { next, oldest, slots, living, seen }
    }

    /// What there is to do at the start of tick number `tick` at the scene's time `now`, s; there are births only
    /// if the emitter `is_on`.
    fn changes(
        &mut self,
        emitter: &Emitter,
        is_on: bool,
        (tick, now): (u64, Scalar),
        changes: &mut Vec<Change>,
    ) {
        let Emitter { rate, life, position, pool, launches, inverse_mass } = emitter;
        let free = |body| Change { body, position: *position, inverse_mass: *inverse_mass, launch: None };
        let until = due(emitter, now);
        match self.seen.replace((tick, now)) {
            Some((_, then)) if now < then => {
                // The scene began anew.
                let lived = self.slots.iter().zip(pool).filter(|(slot, _)| **slot != FREE);
                changes.extend(lived.map(|(_, body)| free(*body)));
                self.slots.fill(FREE);
                (self.next, self.oldest, self.living) = (0, 0, 0);
            }
            Some((then, _)) if tick <= then + 1 => {}
            None if now <= 0.0 => {}
            // What was due while nobody looked is not made up for.
            _ => self.next = self.next.max(until),
        }
        let count = pool.len().min(self.slots.len()).min(launches.len()) as u64;
        if count == 0 {
            return;
        }
        #[expect(clippy::cast_possible_truncation, reason = "below the number of slots")]
        let slot_of = |number: u64| (number % count) as usize;
        let dead = due(emitter, now - life).min(until);
        let passed = dead.min(self.next);
        // No more than the slots hold: what is older was taken.
        for number in self.oldest.max(passed.saturating_sub(count))..passed {
            let slot = slot_of(number);
            if self.slots[slot] == number {
                self.slots[slot] = FREE;
                self.living -= 1;
                changes.push(free(pool[slot]));
            }
        }
        self.oldest = self.oldest.max(dead);
        let first = if is_on { self.next.max(dead).max(until.saturating_sub(count)) } else { until };
        for number in first..until {
            let slot = slot_of(number);
            self.living += usize::from(self.slots[slot] == FREE);
            self.slots[slot] = number;
            #[expect(clippy::cast_precision_loss, reason = "2^53 births are more than a run has")]
            let age = (now - number as Scalar / rate).max(0.0);
            let position = *position + launches[slot] * age;
            changes.push(Change { position, launch: Some(launches[slot]), ..free(pool[slot]) });
        }
        self.next = self.next.max(until);
    }
}

impl Change {
    fn carry_out(self, world: &mut World) {
        let Self { body, position, inverse_mass, launch } = self;
        let Ok(mut body) = world.get_entity_mut(body) else { return };
        if body.contains::<Quarantined>() {
            return;
        }
        if let Some(mut transform) = body.get_mut::<Transform>() {
            transform.position = position;
        }
        if let Some(mut state) = body.get_mut::<PhysicsBody>() {
            *state = PhysicsBody { velocity: launch.unwrap_or(Vector::ZERO), inverse_mass };
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
        match (launch, body.contains::<Dormant>()) {
            (Some(_), true) => drop(body.remove::<Dormant>()),
            (None, false) => drop(body.insert(Dormant)),
            _ => {}
        }
    }
}

/// Emitters, and those whose particles still fly after they were switched off.
type Emitters = (Option<&'static Emitter>, Option<&'static Off<Emitter>>, &'static mut Emission);

/// Lets particles be born that are due at the start of the tick, and takes back those whose life is over.
///
/// A particle whose birth was due at t is placed where it has come to by now, `position + velocity (now - t)`, so
/// that many births in a tick make a stream and no clumps. Times are the scene's and never added up. A particle that
/// still lives when its slot is needed is taken; a slot whose body was quarantined or removed stays empty.
pub fn emit_particles(
    world: &mut World,
    emitters: &mut QueryState<Emitters>,
    mut changes: Local<Vec<Change>>,
) {
    let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
    let at = (clock.ticks(), clock.scene_seconds());
    changes.clear();
    let mut over = true;
    for (on, off, mut emission) in emitters.iter_mut(world) {
        if let Some(emitter) = on.or(off.map(|Off(emitter)| emitter)) {
            emission.changes(emitter, on.is_some(), at, &mut changes);
            over &= on.is_none() && emission.living == 0;
        }
    }
    // Once the first of them have lived, as many die as are born.
    let now = changes.len();
    changes.reserve(now + 1);
    changes.drain(..).for_each(|change| change.carry_out(world));
    if let Some(mut emissions) = world.get_resource_mut::<Emissions>() {
        emissions.over = over;
    }
}

/// Whether there are emitters, or particles of some that were switched off; marks the bodies of their pools.
pub(crate) fn prepare(world: &mut World) -> bool {
    let mut pools = Vec::new();
    let mut goes_on = false;
    let mut emitters = world.query::<Emitters>();
    for (on, off, mut emission) in emitters.iter_mut(world) {
        goes_on |= on.is_some() || emission.living > 0;
        if let Some(emitter) = on.or(off.map(|Off(emitter)| emitter)) {
            emission.slots.resize(emitter.pool.len(), FREE);
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
        world.insert_resource(Emissions::default());
    } else {
        world.remove_resource::<Emissions>();
    }
    goes_on
}
