//! The length of a tick, and the clock of ticks.

use bevy_ecs::prelude::*;

use crate::units::Scalar;

/// Length of a tick, s: finite and at least 0. A tick of length 0, the default, moves nothing, as in a frame in which no time
/// passes.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Resource))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TimeStep(pub Scalar);

impl TimeStep {
    /// # Panics
    /// If the length is negative or not finite.
    pub(crate) fn check(self) {
        let Self(step) = self;
        assert!(
            step >= 0.0 && step.is_finite(),
            "a tick cannot take {step} s; give a finite `TimeStep` above 0"
        );
    }
}

/// The clock of ticks: how many were simulated, and the simulated time.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct StepClock(ClockState);

/// The state of a [`StepClock`] as plain numbers, to save and restore.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct ClockState {
    /// Ticks simulated since the start.
    pub ticks: u64,
    /// The tick at which the current run of equal steps began, at most `ticks`: a changed step begins a new one.
    pub since_tick: u64,
    /// Simulated time at that tick, s.
    pub since_time: Scalar,
    /// Length of each of these steps, s.
    pub step: Scalar,
    /// Simulated time at which the scene began, s.
    pub scene_began: Scalar,
}

impl StepClock {
    /// Ticks simulated since the start.
    #[must_use]
    pub const fn ticks(&self) -> u64 {
        self.0.ticks
    }

    /// Simulated time, s.
    #[must_use]
    pub fn seconds(&self) -> Scalar {
        self.0.since_time + self.seconds_of_equal_steps()
    }

    /// Time since the scene began, s: the time that laws see.
    #[must_use]
    pub fn scene_seconds(&self) -> Scalar {
        (self.0.since_time - self.0.scene_began) + self.seconds_of_equal_steps()
    }

    /// Length of the current run of equal steps, s.
    #[expect(
        clippy::cast_precision_loss,
        reason = "2^53 ticks are some two million years at 120 Hz"
    )]
    fn seconds_of_equal_steps(&self) -> Scalar {
        (self.0.ticks - self.0.since_tick) as Scalar * self.0.step
    }

    /// Sets the start of the scene to now. Ticks and simulated time continue. Until the step changes, the time of the scene has
    /// the bits of a first scene.
    pub fn begin_scene(&mut self) {
        let now = self.seconds();
        (self.0.since_tick, self.0.since_time, self.0.scene_began) = (self.0.ticks, now, now);
    }

    /// Counts one tick of `step` seconds.
    pub fn count(&mut self, step: Scalar) {
        if step != self.0.step {
            (self.0.since_tick, self.0.since_time, self.0.step) =
                (self.0.ticks, self.seconds(), step);
        }
        self.0.ticks += 1;
    }

    /// Returns the clock as it is after one more tick of `step` seconds.
    #[must_use]
    pub fn after(mut self, step: Scalar) -> Self {
        self.count(step);
        self
    }

    /// Restores a clock. `None` if no clock can have reached that state: if a time is negative or not finite, if there
    /// are more than 2^53 ticks, if the run of equal steps began after the last tick, or if the scene begins later than
    /// now.
    #[must_use]
    pub fn from_state(state: ClockState) -> Option<Self> {
        let ClockState { ticks, since_tick, since_time, step, scene_began } = state;
        let times =
            [since_time, step, scene_began].iter().all(|time| *time >= 0.0 && time.is_finite());
        let counted = since_tick <= ticks && ticks <= 1 << 53;
        // The present may be infinite, as it may in a run of very long ticks.
        (times && counted && scene_began <= Self(state).seconds()).then_some(Self(state))
    }
}

impl From<StepClock> for ClockState {
    fn from(clock: StepClock) -> Self {
        clock.0
    }
}
