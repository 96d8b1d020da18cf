//! The clocks of frames: frame time, and the ticks that are due, computed from total time and never accumulated.

use scene::shown;

/// Why a number was refused as a time or rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BadTime {
    /// Not a finite number.
    NotFinite(f64),
    /// Below zero, or before the end of the last frame.
    Negative(f64),
    /// A rate that is not above 0.
    NotPositive(f64),
}

impl std::fmt::Display for BadTime {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotFinite(value) => write!(out, "{value} is not a time; give a finite number"),
            Self::Negative(value) => {
                write!(out, "{} s is negative; time only goes forward", shown(*value))
            }
            Self::NotPositive(value) => {
                write!(out, "{} is not a rate; give a number above 0", shown(*value))
            }
        }
    }
}

impl std::error::Error for BadTime {}

/// The end and the length of a frame. Only a [`FrameClock`] makes one, so both numbers are valid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    total: f64,
    length: f64,
}

impl FrameTime {
    /// Time from the start of the clock to the end of this frame, s.
    #[must_use]
    pub const fn total(self) -> f64 {
        self.total
    }

    /// Length of this frame, s.
    #[must_use]
    pub const fn length(self) -> f64 {
        self.length
    }
}

/// The clock of frames: accepts frame times and refuses invalid ones.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameClock {
    total: f64,
    /// Rounding errors of the additions in [`FrameClock::advance_by`] (Neumaier 1974).
    residue: f64,
}

impl FrameClock {
    /// Begins a frame that ends `total` seconds after the start of the clock.
    ///
    /// # Errors
    /// If `total` is not finite, or is before the end of the last frame. The clock then stays unchanged.
    pub fn advance_to(&mut self, total: f64) -> Result<FrameTime, BadTime> {
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
    pub fn advance_by(&mut self, length: f64) -> Result<FrameTime, BadTime> {
        if !length.is_finite() {
            return Err(BadTime::NotFinite(length));
        }
        if length < 0.0 {
            return Err(BadTime::Negative(length));
        }
        let sum = self.total + length;
        self.residue += if self.total >= length {
            (self.total - sum) + length
        } else {
            (length - sum) + self.total
        };
        self.total = sum;
        Ok(FrameTime { total: self.now(), length })
    }

    /// The end of the last frame, s.
    #[must_use]
    pub fn now(&self) -> f64 {
        self.total + self.residue
    }
}

/// The ticks that a frame has to simulate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Due {
    /// Whole ticks to simulate now.
    pub ticks: u64,
    /// Simulated time dropped because the frame was longer than the catch-up limit, s.
    pub dropped: f64,
}

/// Turns frame times into ticks of a fixed rate.
///
/// The number of ticks due is the floor of the time since an anchor times the rate, so that no rounding accumulates.
/// The anchor moves only when the rate or pace changes, when time is dropped, or when the run is paused.
#[derive(Clone, Copy, Debug)]
pub struct TickClock {
    rate: f64,
    pace: f64,
    catch_up: f64,
    anchor: f64,
    /// Fraction of a tick that was open at the anchor.
    carried: f64,
    done: u64,
    open: f64,
    now: f64,
}

impl TickClock {
    /// Ticks within this fraction of being due are due: 1/60 s times 120 Hz may be one rounding error below 2.
    const NEARLY: f64 = 1e-6;

    /// Makes a clock of `rate` ticks per second. A frame catches up with at most `catch_up` seconds of frame time, but
    /// with at least one tick; an infinite limit is allowed.
    ///
    /// # Errors
    /// If `rate` is not above 0 and finite, or if `catch_up` is negative or NaN.
    pub fn new(rate: f64, catch_up: f64) -> Result<Self, BadTime> {
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
    pub const fn rate(&self) -> f64 {
        self.rate
    }

    /// Simulated seconds per second of frame time.
    #[must_use]
    pub const fn pace(&self) -> f64 {
        self.pace
    }

    /// Fraction of the next tick that has passed, in [0, 1): the point between two ticks at which to draw.
    #[must_use]
    pub const fn fraction(&self) -> f64 {
        self.open
    }

    /// Changes the tick rate, Hz. The fraction of the tick that has passed stays the same.
    ///
    /// # Errors
    /// If `rate` is not above 0 and finite.
    pub fn set_rate(&mut self, rate: f64) -> Result<(), BadTime> {
        let rate = checked_rate(rate)?;
        self.re_anchor(self.now);
        self.rate = rate;
        Ok(())
    }

    /// Changes the pace: 0.5 is slow motion, 2 is twice as fast. The length of a tick stays the same.
    ///
    /// # Errors
    /// If `pace` is not above 0 and finite.
    pub fn set_pace(&mut self, pace: f64) -> Result<(), BadTime> {
        let pace = checked_rate(pace)?;
        self.re_anchor(self.now);
        self.pace = pace;
        Ok(())
    }

    /// End of the last frame that the clock was given, s of frame time.
    #[must_use]
    pub const fn now(&self) -> f64 {
        self.now
    }

    /// Drops the time before `now`, s of frame time: no tick is due for it.
    pub const fn start_at(&mut self, now: f64) {
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
        // The limit is in frame time, so that a fast pace alone drops nothing.
        let most =
            ((self.catch_up * self.pace.max(1.0) * self.rate + Self::NEARLY).floor() as u64).max(1);
        if owed > most {
            let open = passed - whole;
            self.anchor = frame.total;
            self.carried = open.clamp(0.0, 1.0 - f64::EPSILON);
            self.done = 0;
            self.open = self.carried;
            return Due { ticks: most, dropped: (owed - most) as f64 / self.rate };
        }
        self.done += owed;
        self.open = (passed - whole).clamp(0.0, 1.0 - f64::EPSILON);
        Due { ticks: owed, dropped: 0.0 }
    }

    /// The time at which a tick was due, s of frame time, and the uncertainty of that time, s. `after_it` is the number of ticks
    /// after it among those that [`Self::due`] returned last.
    #[expect(clippy::cast_precision_loss, reason = "a count of ticks since the anchor")]
    #[must_use]
    pub fn end_of_tick(&self, after_it: u64) -> [f64; 2] {
        let tick = 1.0 / (self.pace * self.rate);
        let number = self.done as f64 - after_it as f64;
        [self.anchor + (number - self.carried) * tick, 2.0 * Self::NEARLY * tick]
    }

    const fn re_anchor(&mut self, now: f64) {
        self.carried = self.open;
        self.anchor = now;
        self.done = 0;
    }
}

fn checked_rate(rate: f64) -> Result<f64, BadTime> {
    match rate {
        rate if !rate.is_finite() => Err(BadTime::NotFinite(rate)),
        rate if rate <= 0.0 => Err(BadTime::NotPositive(rate)),
        rate => Ok(rate),
    }
}
