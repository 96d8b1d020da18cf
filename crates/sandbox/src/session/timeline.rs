//! The last minute of a session: going back in it, and what happens when something goes wrong.

use std::ops::RangeInclusive;

use bevy_ecs::prelude::*;
use lab::{ENERGY_JUMP, Fault, Replay, TIMELINE_BYTES, Timeline, Watch};
use motion::{SoftBody, remember_positions};
use pick::{SoftTargets, Targets};
use scene::{BUNDLE_FORMAT, Bundle, FileIndex, Happening, Keyframe, Manifest, Settings};

use super::{Order, Session, ids_of, share_among_threads};
use crate::PROGRAM;
use crate::trails::Trails;

/// What a session does when something goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OnFault {
    /// It goes back to the last good tick, pauses and selects the body.
    Pause,
    /// It simulates no further.
    Stop,
}

/// A timeline and the watch over it.
pub(crate) struct Recorded {
    timeline: Timeline,
    watch: Watch,
    /// What went wrong last, and is still ahead or just happened.
    fault: Option<Fault>,
    /// Whether it is to be met at the end of the frame.
    met: bool,
    /// The tick of a fault that the person was told of: going on goes through it.
    passed: Option<u64>,
}

/// Where in the last minute a session is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Within {
    pub range: RangeInclusive<u64>,
    pub now: u64,
    pub keyframes: Vec<u64>,
    pub fault: Option<Fault>,
    pub bytes: usize,
    pub cap: usize,
}

/// What a selection is in every world of a scene.
#[derive(Clone, Copy)]
enum Thing {
    Body(u32),
    Soft(FileIndex),
}

impl Session {
    /// Records the last minute from now on, for going back. At a fault it does that by itself, pauses and selects.
    pub fn keep_timeline(&mut self) {
        self.recording = Some(OnFault::Pause);
        self.restart_recording();
    }

    /// Records the last minute and keeps books from now on, and simulates no further when a body is quarantined or
    /// energy jumps.
    pub fn keep_black_box(&mut self) {
        self.keep_ledger();
        self.recording = Some(OnFault::Stop);
        self.restart_recording();
    }

    /// What went wrong, if something did and it was recorded.
    #[must_use]
    pub fn fault(&self) -> Option<&Fault> {
        self.recorded.as_ref()?.fault.as_ref()
    }

    /// Whether the last minute is recorded.
    #[must_use]
    pub const fn records(&self) -> bool {
        self.recorded.is_some()
    }

    pub(super) fn timeline_bytes(&self) -> usize {
        self.recorded.as_ref().map_or(0, |recorded| recorded.timeline.bytes())
    }

    /// Begins anew with a world that was built anew.
    pub(super) fn restart_recording(&mut self) {
        self.recorded = None;
        if self.recording.is_none() {
            return;
        }
        match Timeline::new(&mut self.world, self.stepper.method(), TIMELINE_BYTES) {
            Some(timeline) => {
                let watch = self.new_watch(None);
                let recorded = Recorded { timeline, watch, fault: None, met: true, passed: None };
                self.recorded = Some(Box::new(recorded));
            }
            None => self.notice("too many bodies to go back in time"),
        }
    }

    fn new_watch(&self, scale: Option<f64>) -> Watch {
        Watch::new(&self.world, self.ledger(), scale, ENERGY_JUMP)
    }

    /// Records what is done to the world at once, between two ticks.
    pub(super) fn record(&mut self, what: Happening) {
        if let Some(recorded) = &mut self.recorded {
            recorded.timeline.note(&self.world, what);
        }
    }

    pub(super) fn record_requests(&mut self) {
        if let Some(recorded) = &mut self.recorded {
            recorded.timeline.note_requests(&self.world);
        }
    }

    pub(super) fn record_before_tick(&mut self) {
        if let Some(recorded) = &mut self.recorded {
            recorded.timeline.before_tick(&self.world);
        }
    }

    /// Records a tick that is over; whether something went wrong in it.
    pub(super) fn record_after_tick(&mut self) -> bool {
        let Some(mut recorded) = self.recorded.take() else { return false };
        let fault = recorded.watch.look(&self.world, self.ledger());
        recorded.timeline.after_tick(&mut self.world, self.stepper.method(), recorded.watch.scale());
        // One that was gone back behind and did not happen again is none.
        let now = self.ticks();
        recorded.fault.take_if(|old| fault.is_none() && old.tick == now);
        let new = fault.filter(|fault| recorded.passed != Some(fault.tick));
        let found = new.is_some();
        if found {
            (recorded.fault, recorded.met) = (new, false);
        }
        self.recorded = Some(recorded);
        found
    }

    /// At the end of a frame in which something went wrong: back to the last good tick, for the person to look.
    pub(super) fn meet_fault(&mut self) {
        let Some(recorded) = self.recorded.as_mut().filter(|recorded| !recorded.met) else { return };
        recorded.met = true;
        let Some(fault) = recorded.fault.clone() else { return };
        recorded.passed = Some(fault.tick);
        if self.recording == Some(OnFault::Pause) {
            self.rewind_before(&fault);
            if fault.body.is_none() {
                self.notice(fault.what);
            }
            let now = self.ticks();
            self.notice(format!("back at tick {now}, the last good one; Ctrl+S saves the run"));
        }
    }

    /// Goes back to the last good tick and selects the body that is at fault.
    pub fn rewind_before(&mut self, fault: &Fault) {
        self.seek(fault.tick.saturating_sub(1));
        let body = fault.body.and_then(|id| self.entities.get(id as usize)).copied();
        if let Some(body) = body.filter(|body| self.world.get_entity(*body).is_ok()) {
            self.control.selection = Some(body);
        }
    }

    /// Pauses and goes to the end of tick number `tick`, or the nearest in the last minute. Going on from there drops
    /// what came after it.
    pub fn seek(&mut self, tick: u64) {
        self.control.paused = true;
        let Some(recorded) = &self.recorded else {
            self.notice("no timeline is kept to go back in");
            return;
        };
        match recorded.timeline.seek(&self.scene, tick) {
            Ok(replay) => self.go_on_from(replay),
            Err(broken) => self.notice(broken.to_string()),
        }
    }

    /// Asks for a file with everything that is recorded.
    pub(crate) fn ask_for_bundle(&mut self) {
        if self.recorded.is_some() {
            self.orders.push(Order::Bundle);
        } else {
            self.notice("no timeline is kept that could be saved");
        }
    }

    /// One tick back, paused.
    pub(crate) fn step_back(&mut self) {
        self.control.paused = true;
        let now = self.ticks();
        match self.recorded.as_ref().map(|recorded| *recorded.timeline.range().start()) {
            Some(first) if first >= now => self.notice("nothing is kept of the time before this tick"),
            _ => self.seek(now.saturating_sub(1)),
        }
    }

    fn go_on_from(&mut self, replay: Replay) {
        let (selection, locked) = (self.thing(self.control.selection), self.thing(self.control.locked));
        let before = self.ticks();
        let Replay { world, stepper, bodies } = replay;
        (self.world, self.stepper, self.entities) = (world, stepper, bodies);
        share_among_threads(&mut self.world, self.entities.len(), self.options);
        self.world.run_system_cached(remember_positions).expect("a query and nothing else");
        self.ids = ids_of(&self.entities);
        self.control.selection = selection.and_then(|thing| self.entity_of(thing));
        self.control.locked = locked.and_then(|thing| self.entity_of(thing));
        let now = self.ticks();
        if let Some(left) = &mut self.ticks_left {
            *left = left.saturating_add(before).saturating_sub(now);
        }
        self.quarantined.retain(|frozen| frozen.tick <= now);
        self.records_seen = self.world.resource::<motion::Quarantine>().records().len();
        (self.targets, self.soft) = (Targets::default(), SoftTargets::default());
        self.targets_current = false;
        self.trails = Trails::default();
        self.acting.clear();
        self.alpha = 1.0;
        self.restart_ghosts();
        if self.ledger.take().is_some() {
            self.open_or_close_ledger();
        }
        self.count_effects_from_now();
        if let Some(mut recorded) = self.recorded.take() {
            recorded.watch = self.new_watch(Some(recorded.watch.scale()));
            self.recorded = Some(recorded);
        }
    }

    fn thing(&self, entity: Option<Entity>) -> Option<Thing> {
        let entity = entity?;
        let soft = || {
            self.world.get::<SoftBody>(entity)?;
            self.world.get::<FileIndex>(entity).copied().map(Thing::Soft)
        };
        self.ids.get(&entity).copied().map(Thing::Body).or_else(soft)
    }

    fn entity_of(&mut self, thing: Thing) -> Option<Entity> {
        match thing {
            Thing::Body(id) => {
                let body = *self.entities.get(id as usize)?;
                self.world.get_entity(body).is_ok().then_some(body)
            }
            Thing::Soft(index) => {
                let mut softs = self.world.query_filtered::<(Entity, &FileIndex), With<SoftBody>>();
                softs.iter(&self.world).find(|(_, other)| **other == index).map(|(soft, _)| soft)
            }
        }
    }

    /// Where in the last minute it is.
    pub(crate) fn within(&self) -> Option<Within> {
        let Recorded { timeline, fault, .. } = &**self.recorded.as_ref()?;
        Some(Within {
            range: timeline.range(),
            now: self.ticks(),
            keyframes: timeline.keyframes().map(|(tick, _)| tick).collect(),
            fault: fault.clone(),
            bytes: timeline.bytes(),
            cap: timeline.cap(),
        })
    }

    /// Everything that is recorded, to be repeated elsewhere, with a PNG of the last good tick. `None` where nothing
    /// is recorded, or the run does not come out the same here.
    #[must_use]
    pub fn bundle(&self, picture: Option<Vec<u8>>) -> Option<Bundle> {
        let Recorded { timeline, fault, .. } = &**self.recorded.as_ref()?;
        let (snapshot, events, scale) = timeline.origin()?;
        let hash = |hash: u64| format!("{hash:016x}");
        let keyframes = timeline.keyframes().map(|(tick, state)| Keyframe { tick, state_hash: hash(state) });
        let range = timeline.range();
        Some(Bundle {
            scene: self.scene.text.0.to_string(),
            manifest: Manifest {
                format: BUNDLE_FORMAT,
                program: PROGRAM.to_owned(),
                scene: self.scene.name.clone(),
                settings: Settings::of(&self.scene),
                snapshot_tick: *range.start(),
                end_tick: *range.end(),
                end_state_hash: hash(timeline.end_hash(&self.scene).ok()?),
                keyframes: keyframes.collect(),
                fault: fault
                    .as_ref()
                    .filter(|fault| range.contains(&fault.tick))
                    .map(|fault| fault.named(&self.scene.names)),
            },
            snapshot: snapshot.clone(),
            events,
            energy_scale_j: self.ledger().is_some().then_some(scale),
            picture,
        })
    }
}
