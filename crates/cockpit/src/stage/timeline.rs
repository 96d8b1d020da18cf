//! The position of a stage in the last minute, and the times of its ticks.

use std::ops::RangeInclusive;

use history::Fault;

/// The position of a stage in the last minute.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Within {
    pub range: RangeInclusive<u64>,
    /// The tick that is shown, or the target of an unfinished seek.
    pub at: u64,
    /// Number of ticks left to simulate in the seek.
    pub left: u64,
    pub keyframes: Vec<u64>,
    pub times: Times,
    pub fault: Option<Fault>,
    /// Whether continuing repeats the recording ahead instead of dropping it.
    pub repeats: bool,
    pub bytes: usize,
    pub cap: usize,
}

/// The times of a scene at the ends of its ticks, known at some of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Times {
    /// Ticks and scene times, s, ascending; at least one.
    pub known: Vec<(u64, f64)>,
    /// Length of a tick after the last known time, s.
    pub step: f64,
}

#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of ticks below 2^53"
)]
impl Times {
    /// The last known tick for which `before` holds (or the first known one), its scene time, s, and the length of the ticks from
    /// there to the next known one, s.
    fn around(&self, before: impl Fn(&(u64, f64)) -> bool) -> (u64, f64, f64) {
        let next = self.known.partition_point(before).max(1);
        let (tick, seconds) = self.known[next - 1];
        let step =
            self.known.get(next).map(|(then, later)| (later - seconds) / (then - tick) as f64);
        (tick, seconds, step.unwrap_or(self.step))
    }

    /// The scene time at the end of tick number `tick`, s.
    pub fn seconds(&self, tick: u64) -> f64 {
        let (then, seconds, step) = self.around(|(known, _)| *known <= tick);
        seconds + (tick as f64 - then as f64) * step
    }

    /// The tick that ends nearest to the scene time `seconds`, s.
    pub fn tick(&self, seconds: f64) -> u64 {
        let (tick, then, step) = self.around(|(_, known)| *known <= seconds);
        (tick as f64 + ((seconds - then) / step).round()).max(0.0) as u64
    }

    /// The scene time at the end of tick number `tick`, as text, with enough decimals (2 to 9) to tell it from the next tick.
    pub fn words(&self, tick: u64) -> String {
        let decimals = (-self.step.log10()).ceil().clamp(2.0, 9.0) as usize;
        // Rounding may make the sum negative, which would print as -0.00.
        format!("{:.decimals$} s", self.seconds(tick).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_the_ticks_and_lead_back_to_them() {
        // At 100 Hz, then at 50 Hz.
        let times = Times { known: vec![(1000, 0.0), (1100, 1.0), (1150, 2.0)], step: 0.02 };
        for (tick, seconds) in [(1000, 0.0), (1050, 0.5), (1100, 1.0), (1125, 1.5), (1200, 3.0)] {
            assert!((times.seconds(tick) - seconds).abs() < 1e-12);
            assert_eq!(times.tick(seconds), tick);
        }
        assert_eq!(times.words(1051), "0.51 s");
        assert_eq!(Times { step: 1.0 / 120.0, ..times }.words(1000), "0.000 s");
    }
}
