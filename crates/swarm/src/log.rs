//! The log of a swarm: what happens to its particles, tick by tick.

use std::collections::VecDeque;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::laws::{SwarmLaws, word};

/// The ticks of a [`Swarm`](crate::Swarm), from the birth of its oldest living particle on. Written by the ticks of the world.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct SwarmLog {
    /// The ticks, the newest last.
    pub ticks: VecDeque<SwarmTick>,
    /// [`SwarmTick::key`] of the last tick, in the log or not; 0 before the first.
    pub key: u64,
    /// Whether velocities were reversed after the last tick.
    pub reversed: bool,
}

impl SwarmLog {
    /// Bytes of the log, those of laws not counted: ticks share them.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.ticks.capacity() * size_of::<SwarmTick>()
    }

    /// Appends a tick and sets its key and the fields that follow from the tick before. Equal laws must be shared with that tick.
    /// Drops the ticks before the birth of the oldest living particle.
    pub(crate) fn enter(&mut self, mut tick: SwarmTick) {
        tick.other_laws =
            self.ticks.back().is_some_and(|last| !Arc::ptr_eq(&last.laws, &tick.laws));
        tick.reversed = std::mem::take(&mut self.reversed);
        tick.key = tick.key_after(self.key);
        self.key = tick.key;
        let dead = tick.dead;
        self.ticks.push_back(tick);
        let over = |tick: &SwarmTick| {
            let [first, after] = tick.births;
            first >= after || after <= dead
        };
        while self.ticks.pop_front_if(|tick| over(tick)).is_some() {}
    }
}

/// One tick of a swarm. Times count from its start.
///
/// In files its laws are in the [`SwarmLog`], once for all ticks that share them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SwarmTick {
    /// Identifies the state after the tick: it depends on this tick and all before it, and on nothing else.
    pub key: u64,
    /// Length, s.
    pub step: f32,
    /// Number of substeps, at least 1.
    pub substeps: u32,
    /// First particle that is due in the tick, and the first after it that is not. Each takes over its slot.
    pub births: [u64; 2],
    /// Whether the due particles are born. If not, because the carrier of the emitter is away, their slots are free.
    pub born: bool,
    /// Time of the first birth, s.
    pub first_birth: f32,
    /// Time from birth to birth, s.
    pub between: f32,
    /// Position of a birth at the start of the tick, m.
    pub source: [f32; 3],
    /// Velocity of the body on which the emitter rides, m/s.
    pub carried: [f32; 3],
    /// Particles below this number are dead at the end of the tick; they die at its start.
    pub dead: u64,
    /// Whether other laws act than in the tick before: position Verlet then brings its velocities to the time of the positions
    /// under the laws of the tick before.
    pub other_laws: bool,
    /// Whether velocities are reversed before the tick.
    pub reversed: bool,
    /// Phase of gusts at the anchor and the start of the tick, rad, from -pi to pi.
    pub phase: f32,
    /// The laws of the tick.
    #[serde(skip)]
    pub laws: Arc<SwarmLaws>,
}

impl SwarmTick {
    /// The key of the tick after a state with the key `before`.
    pub(crate) fn key_after(&self, before: u64) -> u64 {
        let Self {
            key: _,
            step,
            substeps,
            births,
            born,
            first_birth,
            between,
            source,
            carried,
            ..
        } = self;
        let numbers =
            [*step, *first_birth, *between, self.phase].into_iter().chain(*source).chain(*carried);
        let counts = [
            before,
            u64::from(*substeps),
            births[0],
            births[1],
            self.dead,
            u64::from(self.other_laws) | u64::from(self.reversed) << 1 | u64::from(!*born) << 2,
        ];
        let words =
            counts.into_iter().chain(numbers.map(|number| word(&number))).chain(self.laws.words());
        // FNV-1a over words, then the finalizer of SplitMix64 (Steele, Lea, Flood 2014): FNV alone mixes high bits badly.
        let mut hash = words.fold(0xcbf2_9ce4_8422_2325_u64, |hash, word| {
            (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3)
        });
        hash = (hash ^ hash >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash = (hash ^ hash >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        hash ^ hash >> 31
    }
}
