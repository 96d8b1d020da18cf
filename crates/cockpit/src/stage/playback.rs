//! The playback of a run: how frame time becomes ticks.

use history::{Simulation, rate_of};
use scene::{Scene, StepKind};

use crate::clock::{FrameTime, TickClock};
use crate::stage::options::Options;

/// Longest frame time that is caught up with, s. The excess of a longer frame is dropped and reported.
pub const CATCH_UP: f64 = 0.25;

/// Pause, pace, single ticks and a limit of ticks, with counts that continue from scene to scene.
pub struct Playback {
    clock: TickClock,
    /// Simulated seconds per second of frame time, until a person changes the pace.
    usual_pace: f64,
    paused: bool,
    /// Number of single ticks requested.
    steps_asked: u64,
    /// Ticks left to simulate, if they are limited.
    ticks_left: Option<u64>,
    frames: u64,
    /// Time dropped in hitches, s.
    dropped: f64,
    /// Time dropped in the last frame, s.
    dropped_lately: f64,
}

/// The ticks of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameTicks {
    pub number: u64,
    /// Length of the tick, s, in a scene with one tick per frame that is not paused.
    pub step: Option<f64>,
}

impl Playback {
    /// The playback of the first scene of a session.
    pub(super) fn new(scene: &Scene, options: &Options) -> Self {
        let clock = TickClock::new(scene.step_hz, options.catch_up.unwrap_or(CATCH_UP))
            .expect("a resolved scene has a positive, finite rate");
        let mut playback = Self {
            clock,
            usual_pace: options.pace.unwrap_or(scene.pace),
            paused: options.paused,
            steps_asked: 0,
            ticks_left: None,
            frames: 0,
            dropped: 0.0,
            dropped_lately: 0.0,
        };
        playback.reset_pace();
        playback
    }

    /// The playback of the next scene of the session.
    pub(super) fn next(&self, scene: &Scene, options: &Options) -> Self {
        let Self { clock, usual_pace, .. } = Self::new(scene, options);
        let mut next = Self { clock, usual_pace, paused: false, steps_asked: 0, ..*self };
        next.clock.start_at(self.now());
        next
    }

    /// Whether the run is paused.
    #[must_use]
    pub const fn paused(&self) -> bool {
        self.paused
    }

    pub(crate) const fn set_paused(&mut self, paused: bool) {
        self.paused = paused;
    }

    /// Pauses, and lets the next frame simulate one more tick.
    pub(crate) const fn step(&mut self) {
        self.paused = true;
        self.steps_asked += 1;
    }

    /// Limits the next frames to `ticks` more ticks in total; after that, frames change only the picture.
    pub const fn limit_ticks(&mut self, ticks: u64) {
        self.ticks_left = Some(ticks);
    }

    /// Number of frames so far.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    pub(crate) const fn count_frame(&mut self) {
        self.frames += 1;
    }

    /// Time dropped in hitches, s.
    #[must_use]
    pub const fn dropped(&self) -> f64 {
        self.dropped
    }

    /// Time dropped in the last frame, s.
    pub(crate) const fn dropped_lately(&self) -> f64 {
        self.dropped_lately
    }

    /// End of the last frame, s of frame time.
    pub(crate) const fn now(&self) -> f64 {
        self.clock.now()
    }

    /// Ticks per second, Hz.
    #[must_use]
    pub const fn step_hz(&self) -> f64 {
        self.clock.rate()
    }

    /// The part of the next tick that has passed, in [0, 1).
    pub(super) const fn fraction(&self) -> f64 {
        self.clock.fraction()
    }

    /// Simulated time of `sim` plus the elapsed part of the next tick, s.
    pub fn progress(&self, sim: &Simulation) -> f64 {
        sim.seconds() + self.fraction() / self.step_hz()
    }

    /// Simulated seconds per second of frame time.
    pub const fn pace(&self) -> f64 {
        self.clock.pace()
    }

    /// Simulated seconds per second of frame time, until a person changes the pace.
    pub(crate) const fn usual_pace(&self) -> f64 {
        self.usual_pace
    }

    /// Sets the pace, which must be positive and finite.
    pub(crate) fn set_pace(&mut self, pace: f64) {
        self.clock.set_pace(pace).expect("a checked pace is positive and finite");
    }

    pub(super) fn reset_pace(&mut self) {
        self.set_pace(self.usual_pace);
    }

    /// Sets the length of a tick, s. Returns whether it is positive and finite.
    pub(super) fn set_step(&mut self, step: f64) -> bool {
        self.clock.set_rate(rate_of(step)).is_ok()
    }

    /// Sets the length of a tick, s, unless it is the present one up to rounding.
    pub(super) fn follow_step(&mut self, step: f64) {
        if (rate_of(step) / self.clock.rate() - 1.0).abs() > 1e-9 {
            self.set_step(step);
        }
    }

    /// Lets a frame pass without a tick, during a seek.
    pub(super) fn pass(&mut self, time: FrameTime) {
        self.dropped_lately = 0.0;
        self.clock.pause(time);
    }

    /// Begins a frame.
    pub(super) fn begin_frame(&mut self, time: FrameTime, step: StepKind) -> FrameTicks {
        self.dropped_lately = 0.0;
        // Taken even if not paused: a step requested before the pause ended must not run in the next pause.
        let steps_asked = std::mem::take(&mut self.steps_asked);
        let (mut number, step) = if self.paused {
            self.clock.pause(time);
            (steps_asked, None)
        } else if step == StepKind::Frame {
            let length = time.length() * self.clock.pace();
            // No tick is due by the clock: the frame itself is the tick.
            self.clock.pause(time);
            (u64::from(length > 0.0), Some(length))
        } else {
            let due = self.clock.due(time);
            self.drop_time(due.dropped);
            (due.ticks, None)
        };
        if let Some(left) = &mut self.ticks_left {
            number = number.min(*left);
            *left -= number;
        }
        FrameTicks { number, step }
    }

    /// The frame time at which a tick ends, s, and its uncertainty, s. `after_it` is the number of ticks after it in its frame.
    /// Infinity while paused and in scenes with one tick per frame.
    pub(crate) fn end_of_tick(&self, after_it: u64, step: StepKind) -> [f64; 2] {
        if self.paused || step == StepKind::Frame {
            return [f64::INFINITY, 0.0];
        }
        self.clock.end_of_tick(after_it)
    }

    /// Takes back `undone` ticks of the frame. They count as dropped time if they were taken back because the
    /// frame was `late`.
    pub(super) fn leave_undone(&mut self, undone: u64, late: bool) {
        self.add_ticks_left(undone, 0);
        if late {
            #[expect(clippy::cast_precision_loss, reason = "a count of ticks")]
            self.drop_time(undone as f64 / self.clock.rate());
        }
    }

    /// Adds `more` ticks to the ticks left, if they are limited, and subtracts `fewer`.
    pub(super) const fn add_ticks_left(&mut self, more: u64, fewer: u64) {
        if let Some(left) = &mut self.ticks_left {
            *left = left.saturating_add(more).saturating_sub(fewer);
        }
    }

    fn drop_time(&mut self, seconds: f64) {
        self.dropped_lately += seconds;
        self.dropped += seconds;
    }
}
