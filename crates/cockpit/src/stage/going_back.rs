//! Going back in the last minute, repeating it, and the reaction to faults.
//!
//! A seek simulates ticks from a snapshot on and may take several frames. Until it ends, the present is shown; a change of
//! the present cancels it. Without a window, a quarantine that is ahead after going back still decides the exit code.

use history::{Fault, Replay};
use motion::{TimeStep, remember_positions};
use scene::StepKind;

use crate::stage::notices::Topic;
use crate::stage::recorder::{OnFault, Recorded, Recorder, Way};
use crate::stage::things::Thing;
use crate::stage::ticks::Look;
use crate::stage::{Origin, Simulated, Stage, prepare};

impl Stage {
    /// Records the last minute from now on, for going back. At a fault the stage goes back by itself, pauses and selects the
    /// body.
    pub fn keep_timeline(&mut self) {
        self.recorder.on_fault = Some(OnFault::Pause);
        self.restart_recording();
    }

    /// Records the last minute from now on, and stops simulating when a body is quarantined or energy jumps.
    pub fn keep_black_box(&mut self) {
        self.recorder.on_fault = Some(OnFault::Stop);
        self.restart_recording();
    }

    /// Restarts the recording, for another world.
    pub(super) fn restart_recording(&mut self) {
        if self.recorder.restart(&self.sim) {
            self.notices.refuse(Topic::Other, "too many bodies to go back in time");
        }
    }

    /// Replaces the world with the `end` of the run that `recorder` has.
    pub(crate) fn resume(&mut self, recorder: Recorder, end: Replay) {
        self.recorder = recorder;
        self.take_over(end);
        self.quarantines.begin_world();
        self.note_quarantined();
    }

    /// Repeats the changes recorded at the end of the last tick.
    pub(super) fn repeat_changes(&mut self) {
        let changes = self.recorder.changes_after(self.sim.ticks());
        changes.into_iter().for_each(|change| self.give_again(change));
    }

    /// Records the completed tick unless it was `repeated`. Returns whether it had a fault that the person was not told of.
    pub(crate) fn record_after_tick(&mut self, repeated: bool) -> bool {
        let Some(seen) = self.recorder.after_tick(&self.sim, repeated) else { return false };
        if seen.at_the_end {
            self.repeat_changes();
        }
        seen.is_news
    }

    /// Handles a new fault at the end of its frame. With `OnFault::Pause`, begins the seek to the tick before it, for the person
    /// to look.
    pub(super) fn meet_fault(&mut self) {
        let Some(fault) = self.recorder.take_unmet() else { return };
        if self.recorder.on_fault == Some(OnFault::Pause) {
            // The person was already told of a quarantine.
            if !fault.quarantined {
                self.notices.say(Topic::Fault, fault.what.clone());
            }
            self.begin_seek_before(&fault);
            if let Some(way) =
                self.recorder.recorded.as_mut().and_then(|recorded| recorded.way.as_mut())
            {
                way.tells = true;
            }
        }
    }

    /// Selects the body at `fault`, and begins the seek to the tick before it.
    pub(crate) fn begin_seek_before(&mut self, fault: &Fault) {
        // Before the seek, which keeps the selection.
        if let Some(body) = fault.body.and_then(|id| self.sim.body(id)) {
            self.here.selection = Some(body);
        }
        self.begin_seek(fault.tick.saturating_sub(1));
    }

    /// Pauses and begins a seek to the end of tick number `tick`, or the nearest in the last minute.
    pub(crate) fn begin_seek(&mut self, tick: u64) {
        self.playback.set_paused(true);
        self.notices.retract(Topic::Place);
        let Some(recorded) = &mut self.recorder.recorded else {
            self.notices.refuse(Topic::Other, "no timeline is kept to go back in");
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
            Err(broken) => self.notices.say(Topic::Other, broken.to_string()),
        }
    }

    /// Continues a seek until it ends or `look` breaks. Returns whether it is unfinished.
    pub(crate) fn continue_seek(&mut self, look: Look<'_>) -> bool {
        let Some(mut way) = self.recorder.take_seek() else { return false };
        while let Some(recorded) = &mut self.recorder.recorded {
            if !recorded.timeline.seek_tick(&mut way.seek) {
                let Way { seek, tells } = *way;
                let there = recorded.timeline.finish_seek(seek);
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
        if let Some(recorded) = &mut self.recorder.recorded {
            recorded.way = Some(way);
        }
        true
    }

    fn tell_of_last_good_tick(&mut self) {
        let now = self.sim.ticks();
        let before = self.recorder.fault().is_none_or(|fault| now < fault.tick);
        let which = match self.recorder.is_good(now) {
            true => "the last good tick",
            false if before => "the tick before; the run went wrong earlier",
            false => "the oldest tick that is kept",
        };
        let words = format!("back at {}, {which}; Ctrl+S saves the run", self.times().words(now));
        self.notices.say(Topic::Place, words);
    }

    /// Pauses and goes one tick back.
    pub(crate) fn step_back(&mut self) {
        let within = self.recorder.within(&self.sim);
        let now = within.as_ref().map_or_else(|| self.sim.ticks(), |within| within.at);
        if within.is_some_and(|within| *within.range.start() >= now) {
            self.playback.set_paused(true);
            self.notices.say(Topic::Place, "nothing is kept of the time before this tick");
        } else {
            self.begin_seek(now.saturating_sub(1));
        }
    }

    /// Cancels a seek because the run was changed, and tells the person.
    pub(crate) fn give_up_seek(&mut self) {
        if let Some(way) = self.recorder.take_seek() {
            let to = self.times().words(way.seek.to());
            self.notices
                .say(Topic::Place, format!("the seek to {to} was canceled: the run was changed"));
        }
    }

    /// Replaces the world with the result of a seek.
    fn take_over(&mut self, replay: Replay) {
        let (selection, before) =
            (self.here.selection.and_then(|entity| Thing::of(&self.sim, entity)), self.sim.ticks());
        let Replay { mut simulation, watch } = replay;
        prepare(&mut simulation.world, simulation.bodies.len(), self.options);
        simulation.world.run_system_cached(remember_positions).expect("a query and nothing else");
        self.replace(simulation, Origin::Seek);
        if let Some(recorded) = &mut self.recorder.recorded {
            recorded.watch = watch;
        }
        self.here.selection = selection.and_then(|thing| thing.entity(&self.sim));
        self.playback.add_ticks_left(before, self.sim.ticks());
        if self.sim.scene.step == StepKind::Fixed {
            self.playback.follow_step(self.sim.world.resource::<TimeStep>().0);
        }
    }
}
