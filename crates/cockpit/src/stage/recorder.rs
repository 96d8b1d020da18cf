//! The recorder of a stage: the last minute of its run, for going back, and the faults in it.

use history::{Change, Fault, Seek, Simulation, TIMELINE_BYTES, Timeline, Watch};
use motion::TimeStep;
use motion::clock::StepClock;
use motion::ledger::Ledger;

use crate::stage::timeline::{Times, Within};

/// The reaction of a stage to a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OnFault {
    /// Goes back to the tick before the fault, pauses and selects the body.
    Pause,
    /// Stops simulating.
    Stop,
}

/// Records the last minute and watches for faults, once it is switched on.
#[derive(Default)]
pub struct Recorder {
    /// The reaction to a fault, if the recorder is on.
    pub(super) on_fault: Option<OnFault>,
    /// The last minute; `None` also if the scene is too large to record.
    pub(super) recorded: Option<Box<Recorded>>,
}

/// A timeline and the watch over it.
pub(super) struct Recorded {
    pub timeline: Timeline,
    pub watch: Watch,
    /// The fault of the last simulated tick.
    found: Option<Fault>,
    /// The last fault, if it is still ahead or just happened.
    fault: Option<Fault>,
    /// Whether the fault was handled at the end of its frame.
    met: bool,
    /// The tick of a fault that the person was told of. The run goes through the fault unless a change is made before.
    passed: Option<u64>,
    /// The first tick of the run with a fault: no tick from there on is good.
    bad_from: Option<u64>,
    /// Whether continuing from the past repeats the recorded changes, until a new change is made.
    repeats: bool,
    /// The unfinished seek to another tick.
    pub way: Option<Box<Way>>,
}

/// An unfinished seek.
pub(super) struct Way {
    pub seek: Seek,
    /// Whether the person is told at its end, because it goes to the last good tick before a fault.
    pub tells: bool,
}

/// The end of a tick, as the recorder sees it.
pub(super) struct Seen {
    /// Whether the tick had a fault that the person was not told of.
    pub is_news: bool,
    /// Whether the tick repeated the last one of the recording.
    pub at_the_end: bool,
}

impl Recorder {
    /// A recorder with the `timeline` of an opened bundle, whose run repeats, and its `fault`.
    pub(crate) fn opened(timeline: Timeline, watch: Watch, fault: Option<Fault>) -> Self {
        let recorded = Recorded { fault, repeats: true, ..Recorded::new(timeline, watch) };
        Self { on_fault: Some(OnFault::Pause), recorded: Some(Box::new(recorded)) }
    }

    /// The recorded fault, if any.
    #[must_use]
    pub fn fault(&self) -> Option<&Fault> {
        self.recorded.as_ref()?.fault.as_ref()
    }

    /// Whether the last minute is recorded.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        self.recorded.is_some()
    }

    /// Whether a seek is unfinished.
    #[must_use]
    pub fn is_seeking(&self) -> bool {
        self.recorded.as_ref().is_some_and(|recorded| recorded.way.is_some())
    }

    /// The timeline, if the recorder is on.
    pub(crate) fn timeline(&self) -> Option<&Timeline> {
        Some(&self.recorded.as_ref()?.timeline)
    }

    /// Whether the run is recorded and had no fault up to the end of tick number `tick`.
    pub(crate) fn is_good(&self, tick: u64) -> bool {
        let is_good = |bad: Option<u64>| bad.is_none_or(|bad| tick < bad);
        self.recorded.as_ref().is_some_and(|recorded| is_good(recorded.bad_from))
    }

    /// The tick before the first fault, if it is recorded.
    pub(crate) fn last_good(&self) -> Option<u64> {
        let recorded = self.recorded.as_ref()?;
        let bad = recorded.bad_from.or(recorded.fault.as_ref().map(|fault| fault.tick))?;
        Some(bad.saturating_sub(1)).filter(|good| recorded.timeline.range().contains(good))
    }

    /// The scene times at the ends of recorded ticks and at the state of `sim`.
    pub(crate) fn times(&self, sim: &Simulation) -> Times {
        let (clock, now) = (sim.world.resource::<StepClock>(), sim.ticks());
        let began = clock.seconds() - clock.scene_seconds();
        let mut known: Vec<_> = self.timeline().into_iter().flat_map(Timeline::times).collect();
        known.iter_mut().for_each(|(_, seconds)| *seconds -= began);
        known.retain(|(tick, _)| *tick != now);
        known.insert(known.partition_point(|(tick, _)| *tick < now), (now, clock.scene_seconds()));
        Times { known, step: sim.world.resource::<TimeStep>().0 }
    }

    /// The position of `sim` in the last minute.
    pub(crate) fn within(&self, sim: &Simulation) -> Option<Within> {
        let Recorded { timeline, fault, repeats, way, .. } = &**self.recorded.as_ref()?;
        Some(Within {
            range: timeline.range(),
            at: way.as_ref().map_or_else(|| sim.ticks(), |way| way.seek.to()),
            left: way.as_ref().map_or(0, |way| way.seek.ticks_left()),
            keyframes: timeline.keyframes().map(|(tick, _)| tick).collect(),
            times: self.times(sim),
            fault: fault.clone(),
            repeats: *repeats,
            bytes: timeline.bytes(),
            cap: timeline.cap(),
        })
    }

    /// Begins another recording, if the recorder is switched on. Returns whether the scene is too large for that.
    pub(super) fn restart(&mut self, sim: &Simulation) -> bool {
        self.recorded = None;
        if self.on_fault.is_some() {
            let watch = Watch::new(sim);
            let timeline = Timeline::new(sim, TIMELINE_BYTES, watch.energy());
            self.recorded = timeline.map(|timeline| Box::new(Recorded::new(timeline, watch)));
        }
        self.on_fault.is_some() && self.recorded.is_none()
    }

    /// Records a change that is made now, between two ticks.
    pub(super) fn note(&mut self, sim: &Simulation, change: &Change) {
        if let Some(recorded) = &mut self.recorded {
            recorded.timeline.note(sim, change.clone());
        }
    }

    /// Makes a fault that the person was told of news again, because a change was made before it.
    pub(super) fn watch_again(&mut self) {
        if let Some(recorded) = &mut self.recorded {
            recorded.passed = None;
        }
    }

    /// The changes recorded at the end of tick number `now`.
    pub(super) fn changes_after(&self, now: u64) -> Vec<Change> {
        let events = self.timeline().into_iter().flat_map(|timeline| timeline.events_after(now));
        events.map(|event| event.what.clone()).collect()
    }

    /// Whether the tick after tick number `now` repeats a recorded one.
    pub(super) fn repeats(&self, now: u64) -> bool {
        let repeats =
            |recorded: &Recorded| recorded.repeats && now < *recorded.timeline.range().end();
        self.recorded.as_ref().is_some_and(|recorded| repeats(recorded))
    }

    /// Drops the recording after tick number `now`.
    pub(super) fn forget_after(&mut self, now: u64) {
        if let Some(recorded) = &mut self.recorded {
            recorded.timeline.forget_after(now);
            // Drops a fault ahead with its ticks, unless the run goes through it.
            let passed = recorded.passed;
            recorded.fault.take_if(|fault| fault.tick > now && passed != Some(fault.tick));
            recorded.bad_from.take_if(|bad| *bad > now);
        }
    }

    /// Simulates one tick, watched if the recorder is on, and entered into `ledger` if there is one.
    pub(super) fn tick(&mut self, sim: &mut Simulation, ledger: Option<&mut Ledger>) {
        match (&mut self.recorded, ledger) {
            (Some(recorded), ledger) => {
                let now = sim.ticks();
                if recorded.timeline.events_after(now).any(|event| event.what.may_add_energy()) {
                    recorded.watch.note_change(now);
                }
                recorded.found = recorded.watch.tick(sim, ledger);
            }
            (None, Some(ledger)) => sim.tick_with(ledger),
            (None, None) => sim.tick(),
        }
    }

    /// Records the completed tick unless it was `repeated`. `None` if the recorder is off.
    pub(super) fn after_tick(&mut self, sim: &Simulation, repeated: bool) -> Option<Seen> {
        let now = sim.ticks();
        let recorded = self.recorded.as_mut()?;
        let at_the_end = repeated && now == *recorded.timeline.range().end();
        if !repeated {
            let energy = recorded.watch.energy();
            recorded.timeline.after_tick(sim, energy);
        }
        let found = recorded.found.take();
        let is_news = found.as_ref().is_some_and(|fault| recorded.passed != Some(fault.tick));
        recorded.met &= !is_news;
        if let Some(found) = &found {
            let bad = recorded.bad_from.map_or(found.tick, |bad| bad.min(found.tick));
            recorded.bad_from = Some(bad);
        } else {
            // The run continued from before this fault, and the fault did not recur.
            recorded.fault.take_if(|fault| fault.found == now);
        }
        let tick = |fault: &Option<Fault>| fault.as_ref().map(|fault| fault.tick);
        if tick(&found) != tick(&recorded.fault) {
            recorded.fault = found.or(recorded.fault.take());
        }
        Some(Seen { is_news, at_the_end })
    }

    /// Looks for a fault in the last ticks of a run that ends in the present state of `sim`.
    pub(super) fn finish(&mut self, sim: &Simulation) {
        if let Some(recorded) = self.recorded.as_mut().filter(|recorded| recorded.fault.is_none()) {
            recorded.fault = recorded.watch.finish(sim);
            let tick = recorded.fault.as_ref().map(|fault| fault.tick);
            recorded.bad_from = recorded.bad_from.or(tick);
        }
    }

    /// Takes the fault that is to be handled at the end of its frame, if any.
    pub(super) fn take_unmet(&mut self) -> Option<Fault> {
        let recorded = self.recorded.as_mut().filter(|recorded| !recorded.met)?;
        recorded.met = true;
        let fault = recorded.fault.clone()?;
        recorded.passed = Some(fault.tick);
        Some(fault)
    }

    /// Takes the unfinished seek, if any.
    pub(super) fn take_seek(&mut self) -> Option<Box<Way>> {
        self.recorded.as_mut()?.way.take()
    }
}

impl Recorded {
    const fn new(timeline: Timeline, watch: Watch) -> Self {
        Self {
            timeline,
            watch,
            found: None,
            fault: None,
            met: true,
            passed: None,
            bad_from: None,
            repeats: false,
            way: None,
        }
    }
}
