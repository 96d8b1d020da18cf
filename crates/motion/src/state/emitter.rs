//! Emitters: each has a fixed pool of particles, which are born one after another and return when their life is over.

use std::ops::Range;

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::state::clock::StepClock;
use crate::state::components::PhysicsBody;
use crate::state::coupling::structure_changed;
use crate::units::{Scalar, Vector, at_least_0};

/// A birth or death within this fraction of the interval between births from the end of a tick counts as at its end: 1/60 s
/// times 500 per second may be one rounding error off.
const NEARLY: Scalar = 1e-6;

/// Marks a free slot.
const FREE: u64 = u64::MAX;

/// Emits particles at a fixed rate from a pool of bodies. The emitter is an entity separate from its particles.
///
/// Particle number k, counted from 0, is born `k / rate` seconds after the start of the scene and lives for `life`. It
/// is body `k % n` of a pool of n; if that body still lives, it is reborn. Births that were due before the emitter was
/// spawned, or while it was off, are skipped.
///
/// A particle that is born within a tick is integrated over the rest of that tick, in as many substeps as a whole one.
///
/// The first tick of an emitter panics if a field is out of range.
///
/// The component is immutable: insert another one to change it. If it is removed, its particles become [`Dormant`] before
/// the next tick; switch the effect off to let them live out their lives.
#[derive(Component, Clone, Debug, PartialEq)]
#[component(immutable, on_insert = emitters_changed, on_discard = emitters_changed)]
#[require(Emission)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Emitter {
    /// Particles per second, finite and above 0.
    pub rate: Scalar,
    /// Life of each particle, s, above 0.
    pub life: Scalar,
    /// Position at which particles are born, m.
    pub position: Vector,
    /// The pool of bodies, each of which is in no other pool. The first tick makes each of them a [`Particle`], [`Dormant`] until
    /// it is born. Empty if another crate keeps the particles.
    pub pool: Vec<Entity>,
    /// Velocity at birth of each body of the pool, m/s; at least as many as there are bodies.
    pub launches: Vec<Vector>,
    /// Reciprocal of the mass of each particle, 1/kg, at least 0.
    pub inverse_mass: Scalar,
}

impl Emitter {
    /// An emitter at the origin of `rate` particles of 1 kg per second, which live for `life` seconds. They are born with these
    /// velocities, m/s, in turn. Without a [pool](Self::with_pool) it emits nothing.
    ///
    /// ```
    /// use bevy_ecs::prelude::*;
    /// use motion::prelude::*;
    /// use motion::{Dormant, Emitter, Transform};
    ///
    /// let mut world = World::new();
    /// world.insert_resource(Gravity::EARTH);
    /// let fountain = Emitter::new(100.0, 1.0, vec![Vector::Y * 9.8, Vector::new(1.0, 9.8, 0.0)])
    ///     .with_mass(0.01)
    ///     .with_pool(|| world.spawn(PhysicsBody::IMMOVABLE).id());
    /// world.spawn(fountain);
    /// let mut stepper = Stepper::new(&mut world, Method::VelocityVerlet, TimeStep(1.0 / 60.0));
    /// (0..120).for_each(|_| stepper.tick(&mut world));
    /// let mut drops = world.query_filtered::<&Transform, (With<PhysicsBody>, Without<Dormant>)>();
    /// let highest = drops.iter(&world).map(|drop| drop.position.y).fold(0.0, f64::max);
    /// assert!(highest < 4.9 && highest > 4.89); // v² / (2 g)
    /// ```
    #[must_use]
    pub const fn new(rate: Scalar, life: Scalar, launches: Vec<Vector>) -> Self {
        Self { rate, life, position: Vector::ZERO, pool: Vec::new(), launches, inverse_mass: 1.0 }
    }

    /// The same at `position`, m.
    #[must_use]
    pub fn at(self, position: Vector) -> Self {
        Self { position, ..self }
    }

    /// The same with particles of `mass`, kg.
    #[must_use]
    pub fn with_mass(self, mass: Scalar) -> Self {
        Self { inverse_mass: PhysicsBody::with_mass(mass).inverse_mass, ..self }
    }

    /// The same with a pool of as many bodies as live at once, each of which `body` makes with a
    /// [`PhysicsBody`](crate::PhysicsBody), and whatever else a particle is drawn with. Repeats the velocities at birth until each
    /// body has one.
    ///
    /// # Panics
    /// If the number of bodies, rate times life, is not at least 0 and below 2^32.
    #[must_use]
    pub fn with_pool(self, body: impl FnMut() -> Entity) -> Self {
        let alive = self.rate * self.life;
        let is_a_number = (0.0..=f64::from(u32::MAX)).contains(&alive);
        assert!(is_a_number, "{alive} particles live at once; give a smaller `rate` or `life`");
        let count = alive.ceil() as usize;
        let launches = self.launches.iter().copied().cycle().take(count).collect();
        Self { pool: std::iter::repeat_with(body).take(count).collect(), launches, ..self }
    }

    /// # Panics
    /// If it cannot emit; the message says how to set its fields.
    pub(crate) fn check(&self) {
        let Self { rate, life, pool, launches, inverse_mass, .. } = self;
        assert!(
            *rate > 0.0 && rate.is_finite(),
            "an emitter cannot emit {rate} particles per second; give a finite `rate` above 0"
        );
        assert!(
            *life > 0.0,
            "a particle cannot live for {life} s; give the emitter a `life` above 0"
        );
        at_least_0(*inverse_mass, "the inverse mass of particles", "1/kg");
        let (bodies, velocities) = (pool.len(), launches.len());
        assert!(
            bodies <= velocities,
            "an emitter of {bodies} bodies has {velocities} velocities at birth; give one in `launches` per body of `pool`"
        );
    }
}

/// Makes an [`Emitter`] ride on a body: its position is counted from the body, and its particles have the velocity of the
/// body besides their own. A component of the emitter's entity.
///
/// Within a tick the body counts as moving uniformly, with its velocity at the start of the tick. While the body is removed,
/// disabled, quarantined or dormant, no particle is born.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct RidesOn(pub Entity);

/// Marks a particle that is not born yet or no longer lives. It rests at its emitter, every system skips it, and it is
/// neither drawn nor picked.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[component(on_add = dormant_changed, on_remove = dormant_changed)]
pub struct Dormant;

/// Has the groups compiled again if the body is not a particle: particles are in no group, so births change none.
fn dormant_changed(world: DeferredWorld, context: HookContext) {
    if world.get_entity(context.entity).is_ok_and(|body| !body.contains::<Particle>()) {
        structure_changed(world, context);
    }
}

/// Whether emitters were inserted or removed since their pools were prepared.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EmittersChanged(pub bool);

/// Has the pools of emitters prepared again before the next tick. A hook, also for the components of a
/// `ParticleBackend`.
pub fn emitters_changed(mut world: DeferredWorld, _: HookContext) {
    if let Some(mut changed) = world.get_resource_mut::<EmittersChanged>() {
        changed.0 = true;
    }
}

/// Marks a body of an emitter's pool, living or [`Dormant`].
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
pub struct Particle;

/// The particles that an emitter has emitted so far. Every [`Emitter`] has one.
#[derive(Component, Clone, Debug, Default, PartialEq)]
#[component(on_discard = emitters_changed)]
pub struct Emission {
    /// Number of the next particle to be born.
    next: u64,
    /// No particle below this number lives.
    oldest: u64,
    /// Number of the particle that lives in each slot of the pool.
    slots: Vec<u64>,
    living: usize,
    /// Number and start of the tick to which it was last advanced.
    seen: Option<(u64, Scalar)>,
}

/// The state of an [`Emission`] as plain numbers, to save and restore.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct EmissionState {
    /// Number of the next particle to be born.
    pub next: u64,
    /// No particle below this number lives.
    pub oldest: u64,
    /// Number of the particle that lives in each slot of the pool; `None` for a free slot.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::lists::list"))]
    pub slots: Vec<Option<u64>>,
    /// Number and start, s since the start of the scene, of the tick to which it was last advanced.
    pub seen: Option<(u64, Scalar)>,
}

/// The births of the current tick, for the rest of the schedule.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct Emissions {
    /// Whether every emitter is off and no particle lives.
    pub over: bool,
    /// Number of the tick of these births.
    pub tick: u64,
    pub births: Vec<(Entity, Scalar)>,
}

impl Emissions {
    /// Bodies that are born in the tick of that number, and the times of their births, s since the start of the scene.
    pub fn births_in(&self, tick: u64) -> &[(Entity, Scalar)] {
        if tick == self.tick { &self.births } else { &[] }
    }
}

/// Number, start and end of a tick, s since the start of the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tick {
    pub number: u64,
    pub start: Scalar,
    pub end: Scalar,
}

impl Tick {
    /// The next tick of `clock`, `step` seconds long.
    pub fn next(clock: StepClock, step: Scalar) -> Self {
        let [start, end] = [clock, clock.after(step)].map(|clock| clock.scene_seconds());
        Self { number: clock.ticks(), start, end }
    }
}

/// Number of particles born before `time`, s since the start of the scene.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked to be above 0"
)]
fn born_before(emitter: &Emitter, time: Scalar) -> u64 {
    let births = (time * emitter.rate - NEARLY).ceil();
    if births > 0.0 { births as u64 } else { 0 }
}

/// Number of particles whose life is over at `time`, s since the start of the scene.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked to be at least 0"
)]
fn dead_at(emitter: &Emitter, time: Scalar) -> u64 {
    let births = (time - emitter.life) * emitter.rate + NEARLY;
    if births >= 0.0 { (births as u64).saturating_add(1) } else { 0 }
}

/// When particle number `number` is born, s since the start of the scene.
#[expect(clippy::cast_precision_loss, reason = "2^53 births are more than a run has")]
pub(crate) fn birth_time(emitter: &Emitter, number: u64) -> Scalar {
    number as Scalar / emitter.rate
}

/// The particles that die and are born in a tick.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Due {
    /// Particles below this number are dead.
    pub dead: u64,
    /// The particles that are born.
    pub births: Range<u64>,
}

impl Emission {
    /// Number of living particles that are bodies.
    #[must_use]
    pub const fn living(&self) -> usize {
        self.living
    }

    /// Returns the state, to save it.
    #[must_use]
    pub fn state(&self) -> EmissionState {
        let Self { next, oldest, slots, seen, .. } = self;
        let slots = slots.iter().map(|slot| (*slot != FREE).then_some(*slot)).collect();
        EmissionState { next: *next, oldest: *oldest, slots, seen: *seen }
    }

    /// Restores an emission from a saved state.
    #[must_use]
    pub fn from_state(state: EmissionState) -> Self {
        let EmissionState { next, oldest, slots, seen } = state;
        let living = slots.iter().flatten().count();
        let slots = slots.into_iter().map(|slot| slot.unwrap_or(FREE)).collect();
        Self { next, oldest, slots, living, seen }
    }

    /// Resizes the slots to the pool of `emitter`.
    pub(crate) fn fit(&mut self, emitter: &Emitter) {
        self.slots.resize(emitter.pool.len(), FREE);
    }

    /// Whether the body in that slot lives.
    pub(crate) fn lives(&self, slot: usize) -> bool {
        self.slots.get(slot).is_some_and(|number| *number != FREE)
    }

    /// Advances by a tick. Calls `change` with each slot whose body dies (`None`) or is born, with the time of birth, s
    /// since the start of the scene. There are births only if the emitter `is_on`.
    pub(crate) fn advance(
        &mut self,
        emitter: &Emitter,
        is_on: bool,
        tick: Tick,
        mut change: impl FnMut(usize, Option<Scalar>),
    ) {
        if self.begin(emitter, tick) {
            let lived = self.slots.iter().enumerate().filter(|(_, number)| **number != FREE);
            lived.for_each(|(slot, _)| change(slot, None));
            self.slots.fill(FREE);
            self.living = 0;
        }
        let count = self.slots.len().min(emitter.launches.len()) as u64;
        if count == 0 {
            return;
        }
        #[expect(clippy::cast_possible_truncation, reason = "below the number of slots")]
        let slot_of = |number: u64| (number % count) as usize;
        let (oldest, next) = (self.oldest, self.next);
        let Due { dead, births } = self.take_due(emitter, is_on, tick, count);
        let passed = dead.min(next);
        // No more than the slots hold: older particles were replaced.
        for number in oldest.max(passed.saturating_sub(count))..passed {
            let slot = slot_of(number);
            if self.slots[slot] == number {
                self.slots[slot] = FREE;
                self.living -= 1;
                change(slot, None);
            }
        }
        for number in births {
            let slot = slot_of(number);
            self.living += usize::from(self.slots[slot] == FREE);
            self.slots[slot] = number;
            change(slot, Some(birth_time(emitter, number)));
        }
    }

    /// Begins a tick: skips the births that were due in ticks that passed without a call. Returns whether the scene was
    /// restarted.
    pub(crate) fn begin(&mut self, emitter: &Emitter, Tick { number, start, .. }: Tick) -> bool {
        match self.seen.replace((number, start)) {
            Some((then, at)) if start < at || start == 0.0 && number > then => {
                (self.next, self.oldest) = (0, 0);
                return true;
            }
            Some((then, _)) if number <= then + 1 => {}
            None if start <= 0.0 => {}
            _ => self.next = self.next.max(born_before(emitter, start)),
        }
        false
    }

    /// The deaths and births of the tick, of an emitter whose particles share `count` slots.
    pub(crate) fn take_due(
        &mut self,
        emitter: &Emitter,
        is_on: bool,
        tick: Tick,
        count: u64,
    ) -> Due {
        let due = born_before(emitter, tick.end);
        let dead = dead_at(emitter, tick.end).min(due);
        let first = if is_on { self.next.max(dead).max(due.saturating_sub(count)) } else { due };
        self.oldest = self.oldest.max(dead);
        self.next = self.next.max(due);
        Due { dead, births: first..due }
    }
}
