//! Emitters: a fixed pool of particles, thrown out one after another and taken back when their time is over.

use bevy_ecs::prelude::*;

use crate::state::clock::StepClock;
use crate::units::{Scalar, Vector};

/// A birth or death this near to the end of a tick, in births, is at its end: 1/60 s times 500 a second may come out
/// a rounding below or above.
const NEARLY: Scalar = 1e-6;

/// The slot is free.
const FREE: u64 = u64::MAX;

/// Throws out particles, an entity beside them. Particle number k, counted from 0, is born `k / rate` seconds
/// after the scene's start and lives for `life`; it is the body `k % n` of a pool of n, and if that one still
/// lives, it is taken. What was due before the emitter was spawned or while it was off is not made up for.
///
/// A birth within a tick is one: what is left of the tick is a tick of the body's method, in as many substeps as a
/// whole one.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Emission)]
pub struct Emitter {
    /// Particles a second, above 0.
    pub rate: Scalar,
    /// How long each of them lives, s, above 0.
    pub life: Scalar,
    /// Where they are born, m.
    pub position: Vector,
    /// The pool; its bodies are [`Dormant`] until they are born.
    pub pool: Vec<Entity>,
    /// The velocity that each body of the pool is born with, m/s; as many as there are bodies.
    pub launches: Vec<Vector>,
    /// Reciprocal of the mass of each of them, 1/kg.
    pub inverse_mass: Scalar,
}

/// A particle that is not born yet, or no longer lives: at rest at its emitter, ignored by every system, neither
/// drawn nor hit.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dormant;

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

/// What [`emit_particles`](crate::emit_particles) tells the rest of the schedule.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct Emissions {
    /// Every emitter is off, and every particle taken back.
    pub over: bool,
    /// Number of the tick that `births` are of.
    pub tick: u64,
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
    pub number: u64,
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
