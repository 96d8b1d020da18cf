//! The recording of the last minute of a simulation, for going back, and its faults.

use history::{Change, Fault, TIMELINE_BYTES, Timeline, Watch};
use motion::TimeStep;
use motion::clock::StepClock;

use crate::stage::notices::Topic;
use crate::stage::timeline::{Recorded, Times, Within};
use crate::stage::{Order, Stage};

impl Stage {
    /// The recorded fault, if any.
    #[must_use]
    pub fn fault(&self) -> Option<&Fault> {
        self.past.as_ref()?.fault.as_ref()
    }

    /// Whether the last minute is recorded.
    #[must_use]
    pub const fn records(&self) -> bool {
        self.past.is_some()
    }

    /// Whether no seek is unfinished.
    #[must_use]
    pub fn arrived(&self) -> bool {
        self.past.as_ref().is_none_or(|past| past.way.is_none())
    }

    /// Begins a recording.
    pub(crate) fn begin_recording(&mut self) {
        let watch = Watch::new(&mut self.sim.world);
        let timeline = Timeline::new(&mut self.sim, TIMELINE_BYTES, watch.energy());
        self.past = timeline.map(|timeline| Box::new(Recorded::new(timeline, watch)));
        if self.past.is_none() {
            self.notices.refuse(Topic::Other, "too many bodies to go back in time");
        }
    }

    /// Records a change that is made now, between two ticks.
    pub(crate) fn record(&mut self, change: &Change) {
        if let Some(past) = &mut self.past {
            past.timeline.note(&self.sim, change.clone());
        }
    }

    /// Drops the quarantined bodies that are ahead of the present after going back.
    pub(crate) fn forget_ahead(&mut self) {
        self.run.quarantined.truncate(self.run.quarantined_before + self.here.records_seen);
    }

    /// Begins a tick that does not repeat a recorded one: drops the recording after the present.
    pub(crate) fn leave_recorded_ticks(&mut self) {
        let now = self.sim.ticks();
        if let Some(past) = &mut self.past {
            past.timeline.forget_after(now);
            // Drops a fault ahead with its ticks, unless the run goes through it.
            let passed = past.passed;
            past.fault.take_if(|fault| fault.tick > now && passed != Some(fault.tick));
            past.bad_from.take_if(|bad| *bad > now);
            self.forget_ahead();
        }
    }

    /// Whether the coming tick repeats a recorded one.
    pub(crate) fn repeats(&self) -> bool {
        self.past
            .as_ref()
            .is_some_and(|past| past.repeats && self.sim.ticks() < *past.timeline.range().end())
    }

    /// Cancels a seek because the run was changed, and tells the person.
    pub(crate) fn give_up_seek(&mut self) {
        if let Some(way) = self.past.as_mut().and_then(|past| past.way.take()) {
            let to = self.times().words(way.seek.to());
            self.notices
                .say(Topic::Place, format!("the seek to {to} was canceled: the run was changed"));
        }
    }

    /// Orders a bundle of the whole recording.
    pub(crate) fn order_bundle(&mut self) {
        if self.past.is_some() {
            self.orders.push(Order::Bundle);
        } else {
            self.notices.refuse(Topic::Other, "no timeline is kept that could be saved");
        }
    }

    /// The scene times at the ends of recorded ticks and now.
    pub(crate) fn times(&self) -> Times {
        let (clock, now) = (self.sim.world.resource::<StepClock>(), self.sim.ticks());
        let began = clock.seconds() - clock.scene_seconds();
        let mut known: Vec<_> = self.past.iter().flat_map(|past| past.timeline.times()).collect();
        known.iter_mut().for_each(|(_, seconds)| *seconds -= began);
        known.retain(|(tick, _)| *tick != now);
        known.insert(known.partition_point(|(tick, _)| *tick < now), (now, clock.scene_seconds()));
        Times { known, step: self.sim.world.resource::<TimeStep>().0 }
    }

    /// The tick before the first fault, if it is recorded.
    pub(crate) fn last_good(&self) -> Option<u64> {
        let past = self.past.as_ref()?;
        let bad = past.bad_from.or(past.fault.as_ref().map(|fault| fault.tick))?;
        Some(bad.saturating_sub(1)).filter(|good| past.timeline.range().contains(good))
    }

    /// The position of the stage in the last minute.
    pub(crate) fn within(&self) -> Option<Within> {
        let Recorded { timeline, fault, repeats, way, .. } = &**self.past.as_ref()?;
        Some(Within {
            range: timeline.range(),
            at: way.as_ref().map_or_else(|| self.sim.ticks(), |way| way.seek.to()),
            left: way.as_ref().map_or(0, |way| way.seek.ticks_left()),
            keyframes: timeline.keyframes().map(|(tick, _)| tick).collect(),
            times: self.times(),
            fault: fault.clone(),
            repeats: *repeats,
            bytes: timeline.bytes(),
            cap: timeline.cap(),
        })
    }
}
