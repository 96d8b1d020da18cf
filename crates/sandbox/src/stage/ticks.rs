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

/// A callback after every tick; a break drops the remaining ticks of the frame.
pub(crate) type Look<'a> = &'a mut dyn FnMut(&Stage, Simulated) -> ControlFlow<()>;

impl Stage {
    /// Begins the ticks of a frame. Returns their number and, if the scene has one tick per frame and is not paused, its
    /// length, s. Returns `None` during a seek.
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
        // Taken even if not paused: a step requested before the pause ended must not run in the next pause.
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

    /// Prepares the first tick of a frame: applies the pull, the held pushes and the length of the frame's step, s.
    pub(crate) fn before_first_tick(&mut self, step: Option<f64>) {
        // Before the call of `repeats`: a pull or a push ends the repetition of the recorded run.
        self.push_held();
        self.note_pushes();
        self.notices.retract(Topic::Place);
        let now = self.sim.world.resource::<TimeStep>().0;
        if let Some(length) =
            step.filter(|length| *length > 0.0 && length.to_bits() != now.to_bits())
            && !self.repeats()
        {
            // The frame's length is not a change by a person, so the run still goes through a fault that was passed.
            self.record(&Change::Step(length));
            self.give_again(Change::Step(length));
        }
    }

    /// The frame time at which a tick ends, s, and its uncertainty, s. `after_it` is the number of ticks after it in its frame.
    /// Infinity while paused and in scenes with one tick per frame.
    pub(crate) fn end_of_tick(&self, after_it: u64) -> [f64; 2] {
        if self.paused || self.sim.scene.step == StepKind::Frame {
            return [f64::INFINITY, 0.0];
        }
        self.clock.end_of_tick(after_it)
    }

    /// Prepares another tick of a frame: applies the pull and the held pushes. `played`: whether a script acted before the
    /// tick.
    pub(crate) fn between_ticks(&mut self, played: bool) {
        self.push_held();
        // A single push is shown to the end of the frame.
        if played || self.here.pull.is_some() {
            self.note_pushes();
        }
    }

    /// Applies the pull of the pointer and the pushes of held keys to the coming tick.
    fn push_held(&mut self) {
        self.pull();
        for Push { body, newtons } in self.held.clone() {
            self.push(body, newtons);
        }
    }

    /// Pushes the body that the pointer pulls.
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

    /// Begins a tick, and stores the positions before it if `remembered`. Returns whether it repeats a recorded tick.
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

    /// Ends the ticks of a frame, of which `undone` were not simulated. These count as dropped time if the caller was `late`, but
    /// not after a fault.
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
            // Positions are stored before the last tick, which was not reached otherwise.
            && undone == 0;
        self.here.alpha = if between { self.clock.fraction() } else { 1.0 };
        self.version += 1;
        self.note_quarantined();
        self.note_unconverged();
        self.meet_fault();
    }

    /// Notes the pushes of the coming tick. They are shown until the next tick: a frame without a tick does not change them.
    fn note_pushes(&mut self) {
        self.here.pushes.clear();
        for Push { body, newtons } in self.sim.world.resource::<PushQueue>().pending() {
            *self.here.pushes.entry(body).or_default() += newtons;
        }
    }

    /// Pushes a body with `newtons`, N, in the coming tick.
    pub(crate) fn push(&mut self, body: Entity, newtons: DVec3) {
        if let Some(id) = self.sim.id(body) {
            self.give(Change::Push(id, newtons));
        }
    }

    /// Limits the next frames to `ticks` more ticks in total; after that, frames change only the picture.
    pub const fn limit_ticks(&mut self, ticks: u64) {
        self.run.ticks_left = Some(ticks);
    }
}
