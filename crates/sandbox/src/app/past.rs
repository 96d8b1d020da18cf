//! The last minute of a session: going back in it, and what happens when something goes wrong.
//!
//! Going back simulates the ticks from a snapshot on, over as many frames as that takes. Until it is there, the present is
//! shown, and doing something to the present gives it up. Without a window, a quarantine that is ahead after going back
//! still decides the exit code.

use std::ops::{ControlFlow, RangeInclusive};

use bevy_ecs::prelude::*;
use history::{Fault, Intervention, Replay, Seek, Simulation, TIMELINE_BYTES, Timeline, Watch};
use motion::ledger::Ledger;
use motion::{PushQueue, SoftBody, TimeStep, remember_positions};
use pick::{SoftTargets, Targets};
use scene::{FileIndex, StepKind};

use crate::app::session::{Order, Session, Simulated};
use crate::app::ui::Topic;
use crate::app::worlds::{draw_between_ticks, ids_of, share_among_threads};
use crate::view::trails::Trails;

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
    pub(crate) timeline: Timeline,
    watch: Watch,
    /// What the tick that was simulated last did wrong.
    found: Option<Fault>,
    /// What went wrong last, and is still ahead or just happened.
    pub(crate) fault: Option<Fault>,
    /// Whether it is to be met at the end of the frame.
    met: bool,
    /// The tick of a fault that the person was told of: going on goes through it, if nothing is done before.
    passed: Option<u64>,
    /// Whether going on from the past repeats what came from outside, until something else does.
    pub(crate) repeats: bool,
    /// The way to another tick, while it takes frames.
    way: Option<Box<Way>>,
}

struct Way {
    seek: Seek,
    /// Whether it ends at the last good tick before a fault, which the person is told.
    tells: bool,
}

impl Recorded {
    pub(crate) const fn new(timeline: Timeline, watch: Watch) -> Self {
        Self { timeline, watch, found: None, fault: None, met: true, passed: None, repeats: false, way: None }
    }

    /// One tick, booked by `books` if there are some.
    pub(crate) fn tick(&mut self, simulation: &mut Simulation, books: Option<&mut Ledger>) {
        self.found = self.watch.tick(simulation, books);
    }

    /// What was gone back behind, and is not ahead any more, is no fault.
    fn forget_fault(&mut self) {
        let head = *self.timeline.range().end();
        self.fault.take_if(|fault| fault.tick > head);
    }
}

/// Where in the last minute a session is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Within {
    pub range: RangeInclusive<u64>,
    /// The tick of the state that is shown, or the one that is gone to.
    pub at: u64,
    /// Ticks left to simulate until then.
    pub left: u64,
    pub keyframes: Vec<u64>,
    pub fault: Option<Fault>,
    /// Whether going on repeats what is ahead, instead of dropping it.
    pub repeats: bool,
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

    /// Orders a bundle by itself at the first fault of this scene and of each that is opened.
    pub const fn save_faults(&mut self) {
        self.saves_faults = true;
    }

    /// Records the last minute from now on, and simulates no further when a body is quarantined or energy jumps.
    pub fn keep_black_box(&mut self) {
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

    pub(crate) fn timeline_bytes(&self) -> usize {
        self.recorded.as_ref().map_or(0, |recorded| recorded.timeline.bytes())
    }

    /// Begins anew with a world that was built anew.
    pub(crate) fn restart_recording(&mut self) {
        self.recorded = None;
        if self.recording.is_none() {
            return;
        }
        let watch = Watch::new(&mut self.sim.world);
        match Timeline::new(&mut self.sim, TIMELINE_BYTES, watch.energy()) {
            Some(timeline) => self.recorded = Some(Box::new(Recorded::new(timeline, watch))),
            None => self.refuse("too many bodies to go back in time"),
        }
    }

    /// Records what is done to the world at once, between two ticks.
    pub(crate) fn record(&mut self, what: Intervention) {
        if let Some(recorded) = &mut self.recorded {
            recorded.timeline.note(&self.sim, what);
            self.take_another_course();
        }
    }

    pub(crate) fn record_requests(&mut self) {
        if let Some(recorded) = &mut self.recorded
            && recorded.timeline.note_requests(&self.sim)
        {
            self.take_another_course();
        }
    }

    /// What was done now makes another run of what is ahead.
    fn take_another_course(&mut self) {
        if let Some(recorded) = &mut self.recorded {
            recorded.passed = None;
        }
        self.forget_ahead();
        self.give_up_journey();
    }

    /// What was gone back before, and is dropped, was not quarantined.
    pub(crate) fn forget_ahead(&mut self) {
        self.quarantined.truncate(self.quarantined_before + self.records_seen);
    }

    /// Records what the coming tick takes in, which nobody has recorded before.
    pub(crate) fn record_before_tick(&mut self) {
        if let Some(recorded) = &mut self.recorded {
            if recorded.timeline.before_tick(&self.sim) {
                recorded.passed = None;
            }
            recorded.forget_fault();
            self.forget_ahead();
        }
    }

    /// Records a tick that is over, unless it was one that is `repeated`; whether something went wrong in it.
    pub(crate) fn record_after_tick(&mut self, repeated: bool) -> bool {
        let now = self.ticks();
        let Some(recorded) = &mut self.recorded else { return false };
        let at_the_end = repeated && now == *recorded.timeline.range().end();
        if !repeated {
            let energy = recorded.watch.energy();
            recorded.timeline.after_tick(&mut self.sim, energy);
        }
        let found = recorded.found.take();
        let news = found.as_ref().is_some_and(|fault| recorded.passed != Some(fault.tick));
        recorded.met &= !news;
        if found.as_ref().map(|fault| fault.tick) != recorded.fault.as_ref().map(|fault| fault.tick) {
            recorded.fault = found.or(recorded.fault.take());
        }
        if at_the_end {
            self.repeat_events();
        }
        news
    }

    /// At the end of a frame in which something went wrong: back to the last good tick, for the person to look.
    pub(crate) fn meet_fault(&mut self) {
        let Some(recorded) = self.recorded.as_mut().filter(|recorded| !recorded.met) else { return };
        recorded.met = true;
        let Some(fault) = recorded.fault.clone() else { return };
        recorded.passed = Some(fault.tick);
        if self.recording == Some(OnFault::Pause) {
            // Whom it froze has been said.
            if !fault.quarantined {
                self.ui.notice(Topic::Fault, fault.what.clone());
            }
            self.set_out_before(&fault);
            if let Some(way) = self.recorded.as_mut().and_then(|recorded| recorded.way.as_mut()) {
                way.tells = true;
            }
        }
    }

    /// Goes back to the last good tick, in one go, and selects the body that is at fault.
    pub fn rewind_before(&mut self, fault: &Fault) {
        self.set_out_before(fault);
        self.arrive();
    }

    fn set_out_before(&mut self, fault: &Fault) {
        // Before it is gone to: a selection goes along.
        if let Some(body) = fault.body.and_then(|id| self.entity_of(Thing::Body(id))) {
            self.control.selection = Some(body);
        }
        self.set_out(fault.tick.saturating_sub(1));
    }

    /// Pauses and goes to the end of tick number `tick`, or the nearest in the last minute, in one go. Going on from there
    /// drops what came after it, unless it is repeated.
    pub fn seek(&mut self, tick: u64) {
        self.set_out(tick);
        self.arrive();
    }

    fn arrive(&mut self) {
        self.travel(&mut |_, _| ControlFlow::Continue(()));
    }

    /// Pauses and begins to go to the end of tick number `tick`, or the nearest in the last minute.
    pub(crate) fn set_out(&mut self, tick: u64) {
        self.control.paused = true;
        self.ui.retract(Topic::Place);
        let Some(recorded) = &mut self.recorded else {
            self.refuse("no timeline is kept to go back in");
            return;
        };
        let Recorded { timeline, way, .. } = &mut **recorded;
        if let Some(way) = way
            && timeline.redirect(&mut way.seek, tick)
        {
            way.tells = false;
            return;
        }
        *way = None;
        match timeline.begin_seek(&self.sim.scene, tick) {
            Ok(seek) => *way = Some(Box::new(Way { seek, tells: false })),
            Err(broken) => self.notice(broken.to_string()),
        }
    }

    /// Goes on with a seek for as long as `look` lets it; whether it is not there.
    pub(crate) fn travel(&mut self, look: &mut dyn FnMut(&Self, Simulated) -> ControlFlow<()>) -> bool {
        let Some(mut way) = self.recorded.as_mut().and_then(|recorded| recorded.way.take()) else {
            return false;
        };
        while let Some(recorded) = &mut self.recorded {
            if !recorded.timeline.go_on(&mut way.seek) {
                let Way { seek, tells } = *way;
                let there = recorded.timeline.finish_seek(seek);
                self.go_on_from(there);
                if tells {
                    self.tell_of_last_good_tick();
                }
                return false;
            }
            if look(self, Simulated::Again).is_break() {
                break;
            }
        }
        if let Some(recorded) = &mut self.recorded {
            recorded.way = Some(way);
        }
        true
    }

    fn tell_of_last_good_tick(&mut self) {
        let now = self.ticks();
        let before = self.fault().is_none_or(|fault| now < fault.tick);
        let which = if before { "the last good one" } else { "the oldest that is kept" };
        let good = format!("back at tick {now}, {which}");
        // What is opened to be looked at is in a file, and so is the first fault of a scene: the next ones may be many.
        if self.saves_faults && !self.repeats() {
            self.saves_faults = false;
            self.orders.push(Order::Bundle);
            self.ui.notice(Topic::Place, good);
        } else {
            self.ui.notice(Topic::Place, format!("{good}; Ctrl+S saves the run"));
        }
    }

    /// Whether it is at the tick that was gone to.
    #[must_use]
    pub fn arrived(&self) -> bool {
        self.recorded.as_ref().is_none_or(|recorded| recorded.way.is_none())
    }

    /// Pushes that wait for the next tick, while another one is gone to.
    pub(crate) fn pushes_on_the_way(&self) -> Option<usize> {
        self.recorded.as_ref()?.way.as_ref()?;
        Some(self.sim.world.resource::<PushQueue>().pending().count())
    }

    /// What was done here makes the way to another tick worthless.
    pub(crate) fn give_up_journey(&mut self) {
        if let Some(way) = self.recorded.as_mut().and_then(|recorded| recorded.way.take()) {
            let to = way.seek.to();
            self.ui.notice(Topic::Place, format!("not gone to tick {to}, for something was done here"));
        }
    }

    /// Asks for a file with everything that is recorded.
    pub(crate) fn ask_for_bundle(&mut self) {
        if self.recorded.is_some() {
            self.orders.push(Order::Bundle);
        } else {
            self.refuse("no timeline is kept that could be saved");
        }
    }

    /// One tick back, paused.
    pub(crate) fn step_back(&mut self) {
        self.control.paused = true;
        let way = self.recorded.as_ref().and_then(|recorded| recorded.way.as_ref());
        let now = way.map_or_else(|| self.ticks(), |way| way.seek.to());
        match self.recorded.as_ref().map(|recorded| *recorded.timeline.range().start()) {
            Some(first) if first >= now => {
                self.ui.notice(Topic::Place, "nothing is kept of the time before this tick".to_owned());
            }
            _ => self.set_out(now.saturating_sub(1)),
        }
    }

    pub(crate) fn go_on_from(&mut self, replay: Replay) {
        let (selection, locked) = (self.thing(self.control.selection), self.thing(self.control.locked));
        let before = self.ticks();
        let Replay { simulation, watch } = replay;
        self.sim = simulation;
        if let Some(recorded) = &mut self.recorded {
            recorded.watch = watch;
        }
        share_among_threads(&mut self.sim.world, self.sim.bodies.len(), self.options);
        if self.options.interpolate {
            draw_between_ticks(&mut self.sim.world);
        }
        self.sim.world.run_system_cached(remember_positions).expect("a query and nothing else");
        self.ids = ids_of(&self.sim.bodies);
        self.control.selection = selection.and_then(|thing| self.entity_of(thing));
        self.control.locked = locked.and_then(|thing| self.entity_of(thing));
        let now = self.ticks();
        if let Some(left) = &mut self.ticks_left {
            *left = left.saturating_add(before).saturating_sub(now);
        }
        self.records_seen = self.sim.world.resource::<motion::Quarantine>().records().len();
        (self.targets, self.soft) = (Targets::default(), SoftTargets::default());
        self.targets_current = false;
        self.trails = Trails::default();
        self.acting.clear();
        self.alpha = 1.0;
        self.count_unconverged_from_now();
        self.restart_ghosts();
        if self.ledger.take().is_some() {
            self.open_or_close_ledger();
        }
        self.count_effects_from_now();
        self.keep_pace_with_step();
    }

    /// Lets the clock ask for ticks as often as their length says, which may have been another one then.
    fn keep_pace_with_step(&mut self) {
        let rate = 1.0 / self.sim.world.resource::<TimeStep>().0;
        let differs = (rate / self.clock.rate() - 1.0).abs() > 1e-9;
        if self.sim.scene.step == StepKind::Fixed && differs {
            // The length that 120 Hz have is that of 119.999... as well.
            let whole = (rate - rate.round()).abs() <= 1e-9 * rate;
            // A length that ticks have had is above 0 and finite.
            let _ = self.clock.set_rate(if whole { rate.round() } else { rate });
        }
    }

    fn thing(&self, entity: Option<Entity>) -> Option<Thing> {
        let entity = entity?;
        let soft = || {
            self.sim.world.get::<SoftBody>(entity)?;
            self.sim.world.get::<FileIndex>(entity).copied().map(Thing::Soft)
        };
        self.ids.get(&entity).copied().map(Thing::Body).or_else(soft)
    }

    fn entity_of(&mut self, thing: Thing) -> Option<Entity> {
        match thing {
            Thing::Body(id) => self.sim.body(id),
            Thing::Soft(index) => {
                let mut softs = self.sim.world.query_filtered::<(Entity, &FileIndex), With<SoftBody>>();
                softs.iter(&self.sim.world).find(|(_, other)| **other == index).map(|(soft, _)| soft)
            }
        }
    }

    /// Where in the last minute it is.
    pub(crate) fn within(&self) -> Option<Within> {
        let Recorded { timeline, fault, repeats, way, .. } = &**self.recorded.as_ref()?;
        Some(Within {
            range: timeline.range(),
            at: way.as_ref().map_or_else(|| self.ticks(), |way| way.seek.to()),
            left: way.as_ref().map_or(0, |way| way.seek.ticks_left()),
            keyframes: timeline.keyframes().map(|(tick, _)| tick).collect(),
            fault: fault.clone(),
            repeats: *repeats,
            bytes: timeline.bytes(),
            cap: timeline.cap(),
        })
    }
}
