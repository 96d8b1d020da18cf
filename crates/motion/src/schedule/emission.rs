//! How particles are born and taken back.
//!
//! Both happen at the start of the tick that holds their time. A particle whose life ends in the tick is taken back
//! before the tick is integrated, for at its end it is not there. One that is born in the tick stands at the emitter
//! with its launch velocity; the systems that integrate bodies give it the rest of the tick, from its birth on.

use bevy_ecs::prelude::*;

use crate::laws::own::{LastAcceleration, LastStep};
use crate::schedule::switch::Off;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{PhysicsBody, Quarantined, Transform};
use crate::state::emitter::{Dormant, Emitter};
use crate::state::interpolate::PreviousPosition;
use crate::units::{Scalar, Vector};

/// A birth or death this near to the end of a tick, in births, is at its end: 1/60 s times 500 a second may come out
/// a rounding below or above.
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
    /// Number and start of the tick in which it was looked at last.
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
    /// Number and start, s since the scene's start, of the tick in which it was looked at last.
    pub seen: Option<(u64, Scalar)>,
}

/// What [`emit_particles`] tells the rest of the schedule.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct Emissions {
    /// Every emitter is off, and every particle taken back.
    pub over: bool,
    /// Number of the tick that `births` are of.
    tick: u64,
    pub births: Vec<(Entity, Scalar)>,
}

impl Emissions {
    /// Bodies that are born in the tick of that number, and when, s since the scene's start.
    pub fn births_in(&self, tick: u64) -> &[(Entity, Scalar)] {
        if tick == self.tick { &self.births } else { &[] }
    }
}

/// Number, start and end of a tick, s since the scene's start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tick {
    number: u64,
    start: Scalar,
    end: Scalar,
}

impl Tick {
    /// The next tick of `clock`, `step` seconds long.
    pub fn next(clock: StepClock, step: Scalar) -> Self {
        let [start, end] = [clock, clock.after(step)].map(|clock| clock.scene_seconds());
        Self { number: clock.ticks(), start, end }
    }
}

/// What becomes of the body in a slot.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    body: Entity,
    position: Vector,
    inverse_mass: Scalar,
    /// Time of a birth, s, and its velocity, m/s; `None` is the end of a life.
    birth: Option<(Scalar, Vector)>,
}

/// Particles that are born before `time`, s since the scene's start.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be above 0")]
fn born_before(emitter: &Emitter, time: Scalar) -> u64 {
    let births = (time * emitter.rate - NEARLY).ceil();
    if births > 0.0 { births as u64 } else { 0 }
}

/// Particles whose life is over at `time`, s since the scene's start.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be at least 0")]
fn dead_at(emitter: &Emitter, time: Scalar) -> u64 {
    let births = (time - emitter.life) * emitter.rate + NEARLY;
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

    /// An emission with as many slots as the pool of `emitter` has bodies.
    pub(crate) fn fit(&mut self, emitter: &Emitter) {
        self.slots.resize(emitter.pool.len(), FREE);
    }

    /// Whether the body in that slot lives.
    pub(crate) fn lives(&self, slot: usize) -> bool {
        self.slots.get(slot).is_some_and(|number| *number != FREE)
    }

    /// Goes on by a tick. `change` is told each slot whose body is taken back, or born at a time, s since the scene's
    /// start. There are births only if the emitter `is_on`.
    pub(crate) fn advance(
        &mut self,
        emitter: &Emitter,
        is_on: bool,
        tick: Tick,
        mut change: impl FnMut(usize, Option<Scalar>),
    ) {
        let Tick { number, start, end } = tick;
        match self.seen.replace((number, start)) {
            // The scene began again.
            Some((then, at)) if start < at || start == 0.0 && number > then => {
                let lived = self.slots.iter().enumerate().filter(|(_, number)| **number != FREE);
                lived.for_each(|(slot, _)| change(slot, None));
                self.slots.fill(FREE);
                (self.next, self.oldest, self.living) = (0, 0, 0);
            }
            Some((then, _)) if number <= then + 1 => {}
            None if start <= 0.0 => {}
            // What was due while nothing looked is not made up for.
            _ => self.next = self.next.max(born_before(emitter, start)),
        }
        let count = self.slots.len().min(emitter.launches.len()) as u64;
        if count == 0 {
            return;
        }
        #[expect(clippy::cast_possible_truncation, reason = "below the number of slots")]
        let slot_of = |number: u64| (number % count) as usize;
        let due = born_before(emitter, end);
        let dead = dead_at(emitter, end).min(due);
        let passed = dead.min(self.next);
        // No more than the slots hold: what is older was taken.
        for number in self.oldest.max(passed.saturating_sub(count))..passed {
            let slot = slot_of(number);
            if self.slots[slot] == number {
                self.slots[slot] = FREE;
                self.living -= 1;
                change(slot, None);
            }
        }
        self.oldest = self.oldest.max(dead);
        let first = if is_on { self.next.max(dead).max(due.saturating_sub(count)) } else { due };
        for number in first..due {
            let slot = slot_of(number);
            self.living += usize::from(self.slots[slot] == FREE);
            self.slots[slot] = number;
            #[expect(clippy::cast_precision_loss, reason = "2^53 births are more than a run has")]
            change(slot, Some(number as Scalar / emitter.rate));
        }
        self.next = self.next.max(due);
    }
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
        over &= on.is_none() && emission.living == 0;
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
        goes_on |= on.is_some() || emission.living > 0;
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
