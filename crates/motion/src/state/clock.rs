//! The clocks: frame time, simulated time, and the ticks that are due, computed from total time and never accumulated.

use bevy_ecs::prelude::*;

use crate::units::Scalar;

/// Length of a tick, s: finite and at least 0. A tick of length 0 moves nothing, as in a frame in which no time passes.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
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

/// Why a number was refused as a time or rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BadTime {
    /// Not a finite number.
    NotFinite(Scalar),
    /// Below zero, or before the end of the last frame.
    Negative(Scalar),
    /// A rate that is not above 0.
    NotPositive(Scalar),
}

impl std::fmt::Display for BadTime {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotFinite(value) => write!(out, "{value} is not a time; give a finite number"),
            Self::Negative(value) => write!(out, "{value} s is negative; time only goes forward"),
            Self::NotPositive(value) => write!(out, "{value} is not a rate; give a number above 0"),
        }
    }
}

impl std::error::Error for BadTime {}

/// The end and the length of a frame. Only a [`FrameClock`] makes one, so both numbers are valid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    total: Scalar,
    length: Scalar,
}

impl FrameTime {
    /// Time from the start of the clock to the end of this frame, s.
    #[must_use]
    pub const fn total(self) -> Scalar {
        self.total
    }

    /// Length of this frame, s.
    #[must_use]
    pub const fn length(self) -> Scalar {
        self.length
    }
}

/// The clock of frames: accepts frame times and refuses invalid ones.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameClock {
    total: Scalar,
    /// Rounding errors of the additions in [`FrameClock::advance_by`] (Neumaier 1974).
    residue: Scalar,
}

impl FrameClock {
    /// Begins a frame that ends `total` seconds after the start of the clock.
    ///
    /// # Errors
    /// If `total` is not finite, or is before the end of the last frame. The clock then stays unchanged.
    pub fn advance_to(&mut self, total: Scalar) -> Result<FrameTime, BadTime> {
        if !total.is_finite() {
            return Err(BadTime::NotFinite(total));
        }
        let length = total - self.now();
        if length < 0.0 {
            return Err(BadTime::Negative(length));
        }
        *self = Self { total, residue: 0.0 };
        Ok(FrameTime { total, length })
    }

    /// Begins a frame of `length` seconds.
    ///
    /// # Errors
    /// If `length` is negative or not finite. The clock then stays unchanged.
    pub fn advance_by(&mut self, length: Scalar) -> Result<FrameTime, BadTime> {
        if !length.is_finite() {
            return Err(BadTime::NotFinite(length));
        }
        if length < 0.0 {
            return Err(BadTime::Negative(length));
        }
        let sum = self.total + length;
        self.residue +=
            if self.total >= length { (self.total - sum) + length } else { (length - sum) + self.total };
        self.total = sum;
        Ok(FrameTime { total: self.now(), length })
    }

    /// The end of the last frame, s.
    #[must_use]
    pub fn now(&self) -> Scalar {
        self.total + self.residue
    }
}

/// The clock of ticks: how many were simulated, and the simulated time.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct StepClock(ClockState);

/// The state of a [`StepClock`] as plain numbers, to save and restore.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClockState {
    /// Ticks simulated since the start.
    pub ticks: u64,
    /// The tick at which the current run of equal steps began, at most `ticks`: a changed step begins a new one.
    pub since_tick: u64,
    /// Simulated time then, s.
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
    #[expect(clippy::cast_precision_loss, reason = "2^53 ticks are some two million years at 120 Hz")]
    fn seconds_of_equal_steps(&self) -> Scalar {
        (self.0.ticks - self.0.since_tick) as Scalar * self.0.step
    }

    /// Sets the start of the scene to now. Ticks and simulated time continue. Until the step changes, the time of the scene has the
    /// bits of a first scene.
    pub fn begin_scene(&mut self) {
        let now = self.seconds();
        (self.0.since_tick, self.0.since_time, self.0.scene_began) = (self.0.ticks, now, now);
    }

    /// Counts one tick of `step` seconds.
    pub fn count(&mut self, step: Scalar) {
        if step != self.0.step {
            (self.0.since_tick, self.0.since_time, self.0.step) = (self.0.ticks, self.seconds(), step);
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
        let times = [since_time, step, scene_began].iter().all(|time| *time >= 0.0 && time.is_finite());
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

/// The ticks that a frame has to simulate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Due {
    /// Whole ticks to simulate now.
    pub ticks: u64,
    /// Simulated time dropped because the frame was longer than the catch-up limit, s.
    pub dropped: Scalar,
}

/// Turns frame times into ticks of a fixed rate.
///
/// The number of ticks due is the floor of the time since an anchor times the rate, so that no rounding accumulates.
/// The anchor moves only when the rate or pace changes, when time is dropped, or when the run is paused.
#[derive(Clone, Copy, Debug)]
pub struct TickClock {
    rate: Scalar,
    pace: Scalar,
    catch_up: Scalar,
    anchor: Scalar,
    /// Fraction of a tick that was open at the anchor.
    carried: Scalar,
    done: u64,
    open: Scalar,
    now: Scalar,
}

impl TickClock {
    /// Ticks within this fraction of being due are due: 1/60 s times 120 Hz may be one rounding error below 2.
    const NEARLY: Scalar = 1e-6;

    /// Makes a clock of `rate` ticks per second. A frame catches up with at most `catch_up` seconds of frame time, but
    /// with at least one tick; an infinite limit is allowed.
    ///
    /// # Errors
    /// If `rate` is not above 0 and finite, or if `catch_up` is negative or NaN.
    pub fn new(rate: Scalar, catch_up: Scalar) -> Result<Self, BadTime> {
        let clock = Self {
            rate: checked_rate(rate)?,
            pace: 1.0,
            catch_up,
            anchor: 0.0,
            carried: 0.0,
            done: 0,
            open: 0.0,
            now: 0.0,
        };
        match catch_up {
            limit if limit.is_nan() => Err(BadTime::NotFinite(limit)),
            limit if limit < 0.0 => Err(BadTime::Negative(limit)),
            _ => Ok(clock),
        }
    }

    /// Ticks per simulated second, Hz.
    #[must_use]
    pub const fn rate(&self) -> Scalar {
        self.rate
    }

    /// Simulated seconds per second of frame time.
    #[must_use]
    pub const fn pace(&self) -> Scalar {
        self.pace
    }

    /// Fraction of the next tick that has passed, in [0, 1): the point between two ticks at which to draw.
    #[must_use]
    pub const fn fraction(&self) -> Scalar {
        self.open
    }

    /// Changes the tick rate, Hz. The fraction of the tick that has passed stays the same.
    ///
    /// # Errors
    /// If `rate` is not above 0 and finite.
    pub fn set_rate(&mut self, rate: Scalar) -> Result<(), BadTime> {
        let rate = checked_rate(rate)?;
        self.re_anchor(self.now);
        self.rate = rate;
        Ok(())
    }

    /// Changes the pace: 0.5 is slow motion, 2 is twice as fast. The length of a tick stays the same.
    ///
    /// # Errors
    /// If `pace` is not above 0 and finite.
    pub fn set_pace(&mut self, pace: Scalar) -> Result<(), BadTime> {
        let pace = checked_rate(pace)?;
        self.re_anchor(self.now);
        self.pace = pace;
        Ok(())
    }

    /// End of the last frame that the clock was given, s of frame time.
    #[must_use]
    pub const fn now(&self) -> Scalar {
        self.now
    }

    /// Drops the time before `now`, s of frame time: no tick is due for it.
    pub const fn start_at(&mut self, now: Scalar) {
        self.now = now;
        self.re_anchor(now);
    }

    /// Lets a frame pass without simulating it: no tick is due for it afterwards.
    pub fn pause(&mut self, frame: FrameTime) {
        self.start_at(frame.total);
    }

    /// The ticks due at the end of `frame`.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count of ticks since the anchor, at least 0 and far below 2^53"
    )]
    pub fn due(&mut self, frame: FrameTime) -> Due {
        self.now = frame.total;
        let passed = self.carried + (frame.total - self.anchor) * self.pace * self.rate;
        let whole = (passed + Self::NEARLY).floor().max(0.0);
        let owed = whole as u64 - self.done.min(whole as u64);
        // The limit is one of frame time, so that a fast pace alone drops nothing.
        let most = ((self.catch_up * self.pace.max(1.0) * self.rate + Self::NEARLY).floor() as u64).max(1);
        if owed > most {
            let open = passed - whole;
            self.anchor = frame.total;
            self.carried = open.clamp(0.0, 1.0 - Scalar::EPSILON);
            self.done = 0;
            self.open = self.carried;
            return Due { ticks: most, dropped: (owed - most) as Scalar / self.rate };
        }
        self.done += owed;
        self.open = (passed - whole).clamp(0.0, 1.0 - Scalar::EPSILON);
        Due { ticks: owed, dropped: 0.0 }
    }

    const fn re_anchor(&mut self, now: Scalar) {
        self.carried = self.open;
        self.anchor = now;
        self.done = 0;
    }
}

fn checked_rate(rate: Scalar) -> Result<Scalar, BadTime> {
    match rate {
        rate if !rate.is_finite() => Err(BadTime::NotFinite(rate)),
        rate if rate <= 0.0 => Err(BadTime::NotPositive(rate)),
        rate => Ok(rate),
    }
}
