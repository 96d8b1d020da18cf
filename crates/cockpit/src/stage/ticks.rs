//! The ticks of a frame.

use std::ops::ControlFlow;

use history::{Change, Simulation};
use motion::ledger::Ledger;
use motion::{BodyOscillator, Push, TimeStep, Transform, remember_positions};
use scene::{StepKind, Substepping};

use crate::clock::FrameTime;
use crate::stage::forces::between_steps;
use crate::stage::notices::Topic;
use crate::stage::playback::FrameTicks;
use crate::stage::{Simulated, Stage};

/// A callback after every tick; a break drops the remaining ticks of the frame.
pub(crate) type Look<'a> = &'a mut dyn FnMut(&Stage, Simulated) -> ControlFlow<()>;

impl Stage {
    /// Begins the ticks of a frame. Returns `None` during a seek.
    pub(crate) fn begin_ticks(&mut self, time: FrameTime, look: Look<'_>) -> Option<FrameTicks> {
        if self.continue_seek(look) {
            self.playback.pass(time);
            return None;
        }
        Some(self.playback.begin_frame(time, self.sim.scene.step))
    }

    /// Prepares the first tick of a frame: applies the pull, the held pushes and the length of the frame's step, s.
    pub(crate) fn before_first_tick(&mut self, step: Option<f64>) {
        // Before the call of `repeats`: a pull or a push ends the repetition of the recorded run.
        self.push_held();
        self.here.note_pushes(&self.sim.world);
        self.notices.retract(Topic::Place);
        let now = self.sim.world.resource::<TimeStep>().0;
        if let Some(length) =
            step.filter(|length| *length > 0.0 && length.to_bits() != now.to_bits())
            && !self.recorder.repeats(self.sim.ticks())
        {
            // The frame's length is not a change by a person, so the run still goes through a fault that was passed.
            self.recorder.note(&self.sim, &Change::Step(length));
            self.give_again(Change::Step(length));
        }
    }

    /// Prepares another tick of a frame: applies the pull and the held pushes. `played`: whether a script acted before the
    /// tick.
    pub(crate) fn between_ticks(&mut self, played: bool) {
        self.push_held();
        // A single push is shown to the end of the frame.
        if played || self.here.pull.is_some() {
            self.here.note_pushes(&self.sim.world);
        }
    }

    /// Applies the pull of the pointer and the pushes of held keys to the coming tick.
    fn push_held(&mut self) {
        let method = self.sim.method();
        let Self { sim: Simulation { world, .. }, here, .. } = self;
        let pulled = here.pull.as_mut().map(|pull| {
            let place = world.get::<Transform>(pull.body)?.position;
            let own = BodyOscillator::of(world, pull.body, method)?;
            let body = between_steps(world, pull.body, own.method, own.step)?;
            let newtons = pull.force(place, &body, &own, world.resource::<TimeStep>().0);
            Some(Push { body: pull.body, newtons })
        });
        if pulled == Some(None) {
            here.pull = None;
        }
        let pulled = pulled.flatten().filter(|push| push.newtons.is_finite());
        for Push { body, newtons } in pulled.into_iter().chain(self.held.clone()) {
            if let Some(id) = self.sim.id(body) {
                self.give(Change::Push(id, newtons));
            }
        }
    }

    /// Begins a tick, and stores the positions before it if `remembered`. Returns whether it repeats a recorded tick.
    pub(crate) fn begin_tick(&mut self, remembered: bool) -> bool {
        if remembered {
            self.sim.world.run_system_cached(remember_positions).expect("a query and nothing else");
        }
        let repeats = self.recorder.repeats(self.sim.ticks());
        if repeats {
            self.repeat_changes();
        }
        repeats
    }

    /// Simulates a tick, entered into `ledger` if there is one and watched if it is recorded.
    pub(crate) fn tick(&mut self, repeated: bool, ledger: Option<&mut Ledger>) {
        if !repeated && self.recorder.is_on() {
            self.recorder.forget_after(self.sim.ticks());
            self.quarantines.forget_ahead();
        }
        self.recorder.tick(&mut self.sim, ledger);
    }

    /// Ends a run: looks for a fault in its last ticks.
    pub fn end_run(&mut self) {
        self.recorder.finish(&self.sim);
    }

    /// Ends the ticks of a frame, of which `undone` were not simulated. These count as dropped time if the caller was `late`, but
    /// not after a fault.
    pub(crate) fn end_ticks(&mut self, undone: u64, late: bool) {
        self.playback.leave_undone(undone, late);
        let between = self.options.interpolate
            && !self.playback.paused()
            && self.sim.scene.step == StepKind::Fixed
            // Positions are stored before the last tick, which was not reached otherwise.
            && undone == 0;
        self.here.alpha = if between { self.playback.fraction() } else { 1.0 };
        self.here.version += 1;
        self.note_quarantined();
        let unconverged = self.sim.evaluations().unconverged_steps();
        if self.here.unconverged_before.take_if(|before| unconverged > *before).is_some() {
            let what = "an implicit step did not converge; a higher step rate may help";
            self.notices.say(Topic::Unconverged, what);
        }
        if !self.here.told_of_excess
            && let Some(what) = Substepping::excess(&self.sim.world)
        {
            self.here.told_of_excess = true;
            self.notices.say(Topic::Unconverged, what);
        }
        self.meet_fault();
    }

    /// Tells the person of the bodies that were quarantined since the last call.
    pub(super) fn note_quarantined(&mut self) {
        let told = self.quarantines.note(&self.sim, &self.recorder);
        told.into_iter().for_each(|told| self.notices.say(Topic::Other, told));
    }
}
