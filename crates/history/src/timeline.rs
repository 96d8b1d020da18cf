//! The last minute of a run: snapshots at some ticks, and the changes from outside between them.
//!
//! The state at any tick is restored from the nearest snapshot before it, by simulating the ticks from there again.

mod replay;
mod rerun;
mod seek;
mod watch;

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use motion::clock::StepClock;

use crate::bundle::{EnergyState, Event};
use crate::change::Change;
use crate::simulation::Simulation;
use crate::snapshot::Snapshot;

pub use scene::TIMELINE_BYTES;

pub use replay::{Broken, Replay};
pub use rerun::Rerun;
pub use seek::Seek;
pub use watch::{ENERGY_JUMP, Fault, Watch};

/// Simulated time that a timeline covers, s, if its memory limit allows it.
pub const TIMELINE_SECONDS: f64 = 60.0;

/// Ticks between two snapshots at first, hence the most ticks that a seek simulates at first.
const FIRST_SPACING: u64 = 32;

/// A snapshot, its hash, its time and its size.
#[derive(Clone, Debug)]
struct Keyframe {
    snapshot: Snapshot,
    state_hash: u64,
    bytes: usize,
    /// Simulated time, s.
    seconds: f64,
    energy: EnergyState,
}

impl Keyframe {
    fn of(simulation: &Simulation, energy: EnergyState) -> Self {
        // A pending input is recorded as an event when a tick applies it.
        let snapshot = simulation.snapshot().without_inputs();
        let bytes = size_of::<Self>() + snapshot.bytes();
        let (state_hash, seconds) =
            (snapshot.state_hash(), simulation.world.resource::<StepClock>().seconds());
        Self { snapshot, state_hash, bytes, seconds, energy }
    }
}

/// Snapshots and events of a run.
///
/// When the timeline is full, every second snapshot is dropped and the spacing of later ones doubles. With three
/// snapshots or fewer, or if events take half of the limit, the oldest snapshot is dropped instead. Snapshots that
/// are more than a minute old are dropped in any case.
#[derive(Clone, Debug)]
pub struct Timeline {
    cap: usize,
    keyframes: VecDeque<Keyframe>,
    /// One more snapshot, taken shortly before the end of the last long seek.
    near: Option<Box<Keyframe>>,
    /// The events since the oldest snapshot, ascending by tick.
    events: VecDeque<Event>,
    spacing: u64,
    /// Number of the last tick.
    last_tick: u64,
    keyframe_bytes: usize,
    event_bytes: usize,
}

impl Timeline {
    /// Starts a timeline of `simulation`, between two ticks, that takes at most `cap` bytes. `None` if two snapshots
    /// take more. `energy` is [`Watch::energy`].
    pub fn new(simulation: &Simulation, cap: usize, energy: EnergyState) -> Option<Self> {
        let mut timeline = Self {
            cap,
            keyframes: VecDeque::new(),
            near: None,
            events: VecDeque::new(),
            spacing: FIRST_SPACING,
            last_tick: simulation.ticks(),
            keyframe_bytes: 0,
            event_bytes: 0,
        };
        timeline.take_keyframe(simulation, energy);
        (timeline.bytes() * 2 <= cap).then_some(timeline)
    }

    /// Ticks that a seek can reach.
    #[must_use]
    pub fn range(&self) -> RangeInclusive<u64> {
        self.keyframes.front().map_or(self.last_tick, |first| first.snapshot.ticks())
            ..=self.last_tick
    }

    /// Ticks of the snapshots with their state hashes, ascending.
    pub fn keyframes(&self) -> impl Iterator<Item = (u64, u64)> + '_ {
        self.keyframes.iter().map(|keyframe| (keyframe.snapshot.ticks(), keyframe.state_hash))
    }

    /// Ticks of the snapshots with their simulated times, s, ascending.
    pub fn times(&self) -> impl Iterator<Item = (u64, f64)> + '_ {
        self.keyframes.iter().map(|keyframe| (keyframe.snapshot.ticks(), keyframe.seconds))
    }

    /// Memory that the timeline takes, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let near = self.near.as_ref().map_or(0, |near| near.bytes);
        size_of::<Self>() + self.keyframe_bytes + near + self.event_bytes
    }

    /// Memory limit of the timeline, bytes.
    #[must_use]
    pub const fn cap(&self) -> usize {
        self.cap
    }

    /// Records a change between two ticks. If the run went back, drops the record of the ticks after the present one.
    pub fn note(&mut self, simulation: &Simulation, what: Change) {
        let tick = simulation.ticks();
        self.forget_after(tick);
        let event = Event { tick, what };
        self.event_bytes += event.bytes();
        self.events.push_back(event);
    }

    /// Records the end of a tick. `energy` is [`Watch::energy`].
    pub fn after_tick(&mut self, simulation: &Simulation, energy: EnergyState) {
        self.last_tick = simulation.ticks();
        let last = self.keyframes.back().map_or(0, |keyframe| keyframe.snapshot.ticks());
        if self.last_tick >= last + self.spacing {
            self.take_keyframe(simulation, energy);
        }
        self.keep_within_cap();
    }

    /// The oldest snapshot, from which a bundle repeats the run, the events after it, and the state of the watch over
    /// its energy.
    #[must_use]
    pub fn origin(&self) -> Option<(&Snapshot, Vec<Event>, EnergyState)> {
        let first = self.keyframes.front()?;
        Some((&first.snapshot, self.events.iter().cloned().collect(), first.energy))
    }

    /// The events after tick number `tick` and before the next one.
    pub fn events_after(&self, tick: u64) -> impl Iterator<Item = &Event> {
        let first = self.events.partition_point(|event| event.tick < tick);
        self.events.iter().skip(first).take_while(move |event| event.tick == tick)
    }

    fn take_keyframe(&mut self, simulation: &Simulation, energy: EnergyState) {
        let keyframe = Keyframe::of(simulation, energy);
        self.keyframe_bytes += keyframe.bytes;
        self.keyframes.push_back(keyframe);
    }

    /// The last snapshot at or before the end of tick number `tick`.
    fn keyframe_before(&self, tick: u64) -> Option<&Keyframe> {
        let not_after = |keyframe: &&Keyframe| keyframe.snapshot.ticks() <= tick;
        let regular = self.keyframes.iter().rfind(not_after)?;
        let near = self.near.as_deref().filter(not_after);
        Some(
            near.filter(|near| near.snapshot.ticks() > regular.snapshot.ticks()).unwrap_or(regular),
        )
    }

    /// Replaces the extra snapshot by `near`, or drops it if `near` does not fit.
    fn keep_near(&mut self, near: Keyframe) {
        self.near = None;
        if self.bytes() + near.bytes <= self.cap {
            self.near = Some(Box::new(near));
        }
    }

    /// Drops the record of ticks after tick number `now` if the run went back to it, because it may differ from there
    /// on.
    pub fn forget_after(&mut self, now: u64) {
        if now >= self.last_tick {
            return;
        }
        self.near.take_if(|near| near.snapshot.ticks() > now);
        while let Some(keyframe) = self.keyframes.pop_back_if(|last| last.snapshot.ticks() > now) {
            self.keyframe_bytes -= keyframe.bytes;
        }
        while let Some(event) = self.events.pop_back_if(|event| event.tick >= now) {
            self.event_bytes -= event.bytes();
        }
        self.last_tick = now;
    }

    fn keep_within_cap(&mut self) {
        let now = self.keyframes.back().map_or(0.0, |last| last.seconds);
        while self.keyframes.get(1).is_some_and(|second| now - second.seconds >= TIMELINE_SECONDS) {
            self.drop_oldest();
        }
        while self.bytes() > self.cap && self.keyframes.len() > 1 {
            if self.near.take().is_some() {
                continue;
            }
            if self.keyframes.len() > 3 && self.event_bytes * 2 < self.cap {
                self.thin_out();
            } else {
                self.drop_oldest();
            }
        }
    }

    /// Drops every second snapshot, except the oldest and the newest, and doubles the spacing.
    fn thin_out(&mut self) {
        self.spacing = self.spacing.saturating_mul(2);
        let last = self.keyframes.len() - 1;
        let mut number = 0;
        self.keyframes.retain(|_| {
            number += 1;
            number % 2 == 1 || number > last
        });
        self.keyframe_bytes = self.keyframes.iter().map(|keyframe| keyframe.bytes).sum();
    }

    fn drop_oldest(&mut self) {
        if let Some(oldest) = self.keyframes.pop_front() {
            self.keyframe_bytes -= oldest.bytes;
        }
        // A snapshot is taken before the events of its tick, so these stay.
        let first = *self.range().start();
        self.near.take_if(|near| near.snapshot.ticks() < first);
        while let Some(event) = self.events.pop_front_if(|event| event.tick < first) {
            self.event_bytes -= event.bytes();
        }
    }
}
