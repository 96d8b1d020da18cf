//! Going back in the last minute, repeating it, and the reaction to faults.
//!
//! A seek simulates ticks from a snapshot on and may take several frames. Until it ends, the present is shown; a change of
//! the present cancels it. Without a window, a quarantine that is ahead after going back still decides the exit code.

use std::ops::ControlFlow;

use history::{Event, Fault, Replay};
use motion::remember_positions;

use crate::stage::notices::Topic;
use crate::stage::things::Thing;
use crate::stage::ticks::Look;
use crate::stage::timeline::{Recorded, Way};
use crate::stage::{OnFault, Order, Simulated, Stage, prepare};

impl Stage {
    /// Records the last minute from now on, for going back. At a fault the stage goes back by itself, pauses and selects the
    /// body.
    pub fn keep_timeline(&mut self) {
        self.run.recording = Some(OnFault::Pause);
        self.restart_recording();
    }

    /// Records the last minute from now on, and stops simulating when a body is quarantined or energy jumps.
    pub fn keep_black_box(&mut self) {
        self.run.recording = Some(OnFault::Stop);
        self.restart_recording();
    }

    /// Lets the stage order a bundle at the first fault of this scene and of each scene that is opened.
    pub const fn save_faults(&mut self) {
        self.run.saves_faults = true;
    }

    /// Restarts the recording, for another world.
    pub(crate) fn restart_recording(&mut self) {
        self.past = None;
        if self.run.recording.is_some() {
            self.begin_recording();
        }
    }

    /// Repeats the recorded changes before the coming tick if that tick is repeated. Returns whether it is.
    pub(crate) fn repeat_before_tick(&mut self) -> bool {
        let repeats = self.repeats();
        if repeats {
            self.repeat_events();
        }
        repeats
    }

    /// Repeats the changes recorded at the end of the last tick.
    fn repeat_events(&mut self) {
        let now = self.sim.ticks();
        let Some(past) = &self.past else { return };
        let events: Vec<Event> = past.timeline.events_after(now).cloned().collect();
        events.into_iter().for_each(|event| self.give_again(event.what));
    }

    /// Records the completed tick unless it was `repeated`. Returns whether it had a fault, other than the one in
    /// `Recorded::passed`.
    pub(crate) fn record_after_tick(&mut self, repeated: bool) -> bool {
        let now = self.sim.ticks();
        let Some(past) = &mut self.past else { return false };
        let at_the_end = repeated && now == *past.timeline.range().end();
        if !repeated {
            let energy = past.watch.energy();
            past.timeline.after_tick(&mut self.sim, energy);
        }
        let found = past.found.take();
        let news = found.as_ref().is_some_and(|fault| past.passed != Some(fault.tick));
        past.met &= !news;
        if let Some(found) = &found {
            past.bad_from = Some(past.bad_from.map_or(found.tick, |bad| bad.min(found.tick)));
        }
        if found.is_none() {
            // The run continued from before this fault, and the fault did not recur.
            past.fault.take_if(|fault| fault.found == now);
        }
        if found.as_ref().map(|fault| fault.tick) != past.fault.as_ref().map(|fault| fault.tick) {
            past.fault = found.or(past.fault.take());
        }
        if at_the_end {
            self.repeat_events();
        }
        news
    }

    /// Handles a new fault at the end of its frame. With `OnFault::Pause`, begins the seek to the tick before it, for the person
    /// to look.
    pub(crate) fn meet_fault(&mut self) {
        let Some(past) = self.past.as_mut().filter(|past| !past.met) else { return };
        past.met = true;
        let Some(fault) = past.fault.clone() else { return };
        past.passed = Some(fault.tick);
        if self.run.recording == Some(OnFault::Pause) {
            // The person was already told of a quarantine.
            if !fault.quarantined {
                self.notices.say(Topic::Fault, fault.what.clone());
            }
            self.begin_seek_before(&fault);
            if let Some(way) = self.past.as_mut().and_then(|past| past.way.as_mut()) {
                way.tells = true;
            }
        }
    }

    /// Goes back to the tick before the recorded fault, if any, and selects the body at fault.
    pub fn rewind_before_fault(&mut self) {
        if let Some(fault) = self.fault().cloned() {
            self.rewind_before(&fault);
        }
    }

    /// Goes back to the tick before `fault` within this call, and selects the body at fault.
    pub fn rewind_before(&mut self, fault: &Fault) {
        self.begin_seek_before(fault);
        self.finish_seek();
    }

    fn begin_seek_before(&mut self, fault: &Fault) {
        // Before the seek, which keeps the selection.
        if let Some(body) = fault.body.and_then(|id| self.sim.body(id)) {
            self.here.selection = Some(body);
        }
        self.begin_seek(fault.tick.saturating_sub(1));
    }

    /// Pauses and goes to the end of tick number `tick`, or the nearest in the last minute, within this call. Continuing from
    /// there drops the ticks recorded after it, unless they are repeated.
    pub fn seek(&mut self, tick: u64) {
        self.begin_seek(tick);
        self.finish_seek();
    }

    fn finish_seek(&mut self) {
        self.continue_seek(&mut |_, _| ControlFlow::Continue(()));
    }

    /// Pauses and begins a seek to the end of tick number `tick`, or the nearest in the last minute.
    pub(crate) fn begin_seek(&mut self, tick: u64) {
        self.paused = true;
        self.notices.retract(Topic::Place);
        let Some(past) = &mut self.past else {
            self.notices.refuse(Topic::Other, "no timeline is kept to go back in");
            return;
        };
        let Recorded { timeline, way, .. } = &mut **past;
        if let Some(way) = way
            && timeline.redirect(&mut way.seek, tick)
        {
            way.tells = false;
            return;
        }
        *way = None;
        match timeline.begin_seek(&self.sim.scene, tick) {
            Ok(seek) => *way = Some(Box::new(Way { seek, tells: false })),
            Err(broken) => self.notices.say(Topic::Other, broken.to_string()),
        }
    }

    /// Continues a seek until it ends or `look` breaks. Returns whether it is unfinished.
    pub(crate) fn continue_seek(&mut self, look: Look<'_>) -> bool {
        let Some(mut way) = self.past.as_mut().and_then(|past| past.way.take()) else {
            return false;
        };
        while let Some(past) = &mut self.past {
            if !past.timeline.seek_tick(&mut way.seek) {
                let Way { seek, tells } = *way;
                let there = past.timeline.finish_seek(seek);
                self.take_over(there);
                if tells {
                    self.tell_of_last_good_tick();
                }
                return false;
            }
            if look(self, Simulated::Again).is_break() {
                break;
            }
        }
        if let Some(past) = &mut self.past {
            past.way = Some(way);
        }
        true
    }

    fn tell_of_last_good_tick(&mut self) {
        let now = self.sim.ticks();
        let before = self.fault().is_none_or(|fault| now < fault.tick);
        let which = match self.past.as_ref().is_none_or(|past| past.is_good(now)) {
            true => "the last good tick",
            false if before => "the tick before; the run went wrong earlier",
            false => "the oldest tick that is kept",
        };
        let good = format!("back at {}, {which}", self.times().words(now));
        // An opened bundle and the first fault of a scene are already in files. Later faults may be many.
        if self.run.saves_faults && !self.repeats() {
            self.run.saves_faults = false;
            self.orders.push(Order::Bundle);
            self.notices.say(Topic::Place, good);
        } else {
            self.notices.say(Topic::Place, format!("{good}; Ctrl+S saves the run"));
        }
    }

    /// Pauses and goes one tick back.
    pub(crate) fn step_back(&mut self) {
        self.paused = true;
        match self.within().map(|within| (*within.range.start(), within.at)) {
            Some((first, now)) if first >= now => {
                self.notices
                    .say(Topic::Place, "nothing is kept of the time before this tick".to_owned());
            }
            within => {
                self.begin_seek(within.map_or(self.sim.ticks(), |(_, now)| now).saturating_sub(1));
            }
        }
    }

    /// Replaces the world with the result of a seek.
    pub(crate) fn take_over(&mut self, replay: Replay) {
        let (selection, before) =
            (self.here.selection.and_then(|entity| Thing::of(&self.sim, entity)), self.sim.ticks());
        let Replay { mut simulation, watch } = replay;
        prepare(&mut simulation.world, simulation.bodies.len(), self.run.options);
        simulation.world.run_system_cached(remember_positions).expect("a query and nothing else");
        self.replace(simulation, true);
        if let Some(past) = &mut self.past {
            past.watch = watch;
        }
        self.here.selection = selection.and_then(|thing| thing.entity(&self.sim));
        if let Some(left) = self.run.ticks_left {
            self.run.ticks_left =
                Some(left.saturating_add(before).saturating_sub(self.sim.ticks()));
        }
        self.keep_pace_with_step();
    }
}
