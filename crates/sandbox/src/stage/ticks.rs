//! The ticks of a frame.

use std::ops::ControlFlow;

use bevy_ecs::entity::Entity;
use glam::DVec3;
use history::Change;
use motion::ledger::Ledger;
use motion::{PhysicsBody, Push, PushQueue, TimeStep, Transform, remember_positions};
use scene::StepKind;

use crate::clock::FrameTime;
use crate::stage::notices::Topic;
use crate::stage::{Simulated, Stage};

/// What is done with every tick that is over; a break drops the other ticks of the frame.
pub(crate) type Look<'a> = &'a mut dyn FnMut(&Stage, Simulated) -> ControlFlow<()>;

impl Stage {
    /// Begins the ticks of a frame; how many there are, and how long each is where the scene has one per frame. `None` while
    /// another tick is sought.
    pub(crate) fn begin_ticks(
        &mut self,
        time: FrameTime,
        look: Look<'_>,
    ) -> Option<(u64, Option<f64>)> {
        self.run.dropped_lately = 0.0;
        if self.continue_seek(look) {
            self.clock.pause(time);
            return None;
        }
        // Taken in any case: a step that was asked for before the pause ended is not one of the next pause.
        let steps_asked = std::mem::take(&mut self.steps_asked);
        let (mut ticks, step) = if self.paused {
            self.clock.pause(time);
            (steps_asked, None)
        } else if self.sim.scene.step == StepKind::Frame {
            let length = time.length() * self.clock.pace();
            self.clock.pause(time);
            (u64::from(length > 0.0), Some(length))
        } else {
            let due = self.clock.due(time);
            self.run.dropped_lately = due.dropped;
            self.run.dropped += due.dropped;
            (due.ticks, None)
        };
        if let Some(left) = &mut self.run.ticks_left {
            ticks = ticks.min(*left);
            *left -= ticks;
        }
        Some((ticks, step))
    }

    /// Before the first tick of a frame: gives it the pull and the held pushes, and the length of the frame's step.
    pub(crate) fn before_first_tick(&mut self, step: Option<f64>) {
        // Before `repeats` is asked: a pull or a push ends the repetition of the recorded run.
        self.push_held();
        self.note_pushes();
        self.notices.retract(Topic::Place);
        let now = self.sim.world.resource::<TimeStep>().0;
        if let Some(length) =
            step.filter(|length| *length > 0.0 && length.to_bits() != now.to_bits())
            && !self.repeats()
        {
            // The frame's length is no change by a person: it goes through faults that were passed.
            self.record(&Change::Step(length));
            self.give_again(Change::Step(length));
        }
    }

    /// When the tick ends that has so many ticks of its frame after it, s of the clock of frames, and how exactly that is known, s.
    /// Where time does not pass, later than everything.
    pub(crate) fn end_of_tick(&self, after_it: u64) -> [f64; 2] {
        if self.paused || self.sim.scene.step == StepKind::Frame {
            return [f64::INFINITY, 0.0];
        }
        self.clock.end_of_tick(after_it)
    }

    /// Between two ticks of a frame: carries out what a script `played`, if it did, and gives the coming tick the pull and the held
    /// pushes.
    pub(crate) fn between_ticks(&mut self, played: bool) {
        self.push_held();
        // What was pushed once is shown to the end of the frame.
        if played || self.here.pull.is_some() {
            self.note_pushes();
        }
    }

    /// Gives what is held to the coming tick: the pull of the pointer and the pushes of keys.
    fn push_held(&mut self) {
        self.pull();
        for Push { body, newtons } in self.held.clone() {
            self.push(body, newtons);
        }
    }

    /// Pushes what the pointer pulls.
    fn pull(&mut self) {
        let Some(pull) = &mut self.here.pull else { return };
        let world = &self.sim.world;
        let (Some(place), Some(state)) =
            (world.get::<Transform>(pull.body), world.get::<PhysicsBody>(pull.body))
        else {
            self.here.pull = None;
            return;
        };
        let newtons = pull.force(place.position, state, world.resource::<TimeStep>().0);
        let body = pull.body;
        if newtons.is_finite() {
            self.push(body, newtons);
        }
    }

    /// Begins a tick, before which positions are `remembered` or not; whether it repeats one that was recorded.
    pub(crate) fn begin_tick(&mut self, remembered: bool) -> bool {
        if remembered {
            self.sim.world.run_system_cached(remember_positions).expect("a query and nothing else");
        }
        self.repeat_before_tick()
    }

    /// Simulates a tick, entered into `ledger` if there is one and watched if it is recorded.
    pub(crate) fn tick(&mut self, repeated: bool, ledger: Option<&mut Ledger>) {
        if !repeated {
            self.leave_recorded_ticks();
        }
        match (&mut self.past, ledger) {
            (Some(past), ledger) => past.tick(&mut self.sim, ledger),
            (None, Some(ledger)) => ledger.tick(&mut self.sim.stepper, &mut self.sim.world),
            (None, None) => self.sim.tick(),
        }
    }

    /// Ends the ticks of a frame, of which `undone` were not simulated. Where the caller was `late`, they count as dropped time; after
    /// a fault they do not.
    pub(crate) fn end_ticks(&mut self, undone: u64, late: bool) {
        if let Some(left) = &mut self.run.ticks_left {
            *left += undone;
        }
        if late {
            #[expect(clippy::cast_precision_loss, reason = "a count of ticks")]
            let dropped = undone as f64 / self.clock.rate();
            self.run.dropped_lately += dropped;
            self.run.dropped += dropped;
        }
        let between = self.run.options.interpolate
            && !self.paused
            && self.sim.scene.step == StepKind::Fixed
            // Positions are remembered before the last tick, which was not reached.
            && undone == 0;
        self.here.alpha = if between { self.clock.fraction() } else { 1.0 };
        self.version += 1;
        self.note_quarantined();
        self.note_unconverged();
        self.meet_fault();
    }

    /// Notes the pushes of the coming tick. They are shown until the next one: a frame without a tick changes nothing.
    fn note_pushes(&mut self) {
        self.here.pushes.clear();
        for Push { body, newtons } in self.sim.world.resource::<PushQueue>().pending() {
            *self.here.pushes.entry(body).or_default() += newtons;
        }
    }

    /// Pushes a body in the coming tick, N.
    pub(crate) fn push(&mut self, body: Entity, newtons: DVec3) {
        if let Some(id) = self.sim.id(body) {
            self.give(Change::Push(id, newtons));
        }
    }

    /// The next frames simulate at most `ticks` more ticks; after that they change nothing but the picture.
    pub const fn limit_ticks(&mut self, ticks: u64) {
        self.run.ticks_left = Some(ticks);
    }
}
