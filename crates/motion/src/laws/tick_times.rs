//! The times of a tick: substeps, split at the discontinuities of laws.

use smallvec::SmallVec;

use crate::laws::EvaluationTime;
use crate::state::clock::StepClock;
use crate::units::Scalar;

/// A time interval that is integrated in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Segment {
    /// Time at the start, s.
    pub start: f64,
    /// Time at the end, s: bit for bit the start of the next interval.
    pub end: f64,
    /// Length, s: that of a substep unless the interval was split off one.
    pub length: f64,
    /// Length of the interval before it, s.
    pub preceding: f64,
    /// Whether a law may jump at the start.
    pub jump: bool,
}

impl Segment {
    /// Time in the middle, s.
    fn middle(&self) -> f64 {
        self.start + self.length * 0.5
    }

    /// The time at the fraction `part`, bit for bit `start` at 0 and `end` at 1.
    pub fn evaluation_time(&self, part: f64) -> EvaluationTime {
        let time = if part == 0.0 {
            self.start
        } else if part == 1.0 {
            self.end
        } else {
            self.start + part * self.length
        };
        EvaluationTime { time, within_step: self.middle() }
    }

    /// The first `length` seconds, and the rest after a discontinuity.
    pub fn split(self, length: f64) -> (Self, Self) {
        let time = self.start + length;
        // The rest after a part of length 0 follows the interval before it.
        let preceding = if length > 0.0 { length } else { self.preceding };
        let rest =
            Self { start: time, length: self.length - length, preceding, jump: true, ..self };
        (Self { end: time, length, ..self }, rest)
    }

    /// The start, seen from before a discontinuity.
    pub fn before(&self) -> EvaluationTime {
        // Within the preceding interval: laws that jump at the start of that interval have jumped.
        EvaluationTime {
            time: self.start,
            within_step: self.start - self.length.min(self.preceding) * 0.25,
        }
    }
}

/// The times of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TickTimes {
    /// Time at the start of the tick, s.
    pub start: Scalar,
    /// Time at its end, s.
    pub end: Scalar,
    /// Length of the tick, s.
    pub tick: Scalar,
    /// Number of substeps of equal length, at least 1.
    pub substeps: u32,
}

/// A discontinuity within this fraction of a substep from its end counts as at the end: it would split off an interval of
/// rounding errors.
const NEAR: Scalar = 1e-9;

impl TickTimes {
    /// The times of a tick of `tick` seconds that begins at the time of `clock`.
    pub fn new(clock: StepClock, tick: Scalar, substeps: u32) -> Self {
        Self {
            start: clock.scene_seconds(),
            end: clock.after(tick).scene_seconds(),
            tick,
            substeps,
        }
    }

    /// Length of a substep, s.
    pub fn substep(&self) -> f64 {
        self.part()
    }

    /// The rest of the tick from `time`, s, in as many substeps as the whole: the first tick of a body that is born
    /// then.
    pub fn since(self, time: Scalar) -> Self {
        Self { start: time, tick: self.end - time, ..self }
    }

    /// Start and end of the tick, s.
    pub const fn ends(&self) -> [Scalar; 2] {
        [self.start, self.end]
    }

    fn part(&self) -> Scalar {
        self.tick / Scalar::from(self.substeps)
    }

    /// Whether a discontinuity at `time`, s, is one of this tick.
    pub fn holds(&self, time: Scalar) -> bool {
        let near = self.part() * NEAR;
        time >= self.start - near && time < self.end - near
    }

    /// Splits the tick at `discontinuities`, s, in any order.
    pub fn segments(&self, discontinuities: &mut dyn Iterator<Item = &Scalar>) -> Segments {
        let mut inside: SmallVec<[Scalar; 8]> = SmallVec::new();
        inside.extend(discontinuities.copied().filter(|time| self.holds(*time)));
        inside.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        Segments { times: *self, discontinuities: inside }
    }
}

/// The intervals of a tick, computed one by one: a list would have to be allocated.
#[derive(Clone, Debug)]
pub(crate) struct Segments {
    times: TickTimes,
    /// Discontinuities within the tick, s, ascending.
    discontinuities: SmallVec<[Scalar; 8]>,
}

impl Segments {
    /// The intervals in order; there is at least one.
    pub fn iter(&self) -> impl Iterator<Item = Segment> + Clone + '_ {
        let TickTimes { start, end, substeps, .. } = self.times;
        let h = self.times.part();
        let near = h * NEAR;
        let mut discontinuities = self.discontinuities.iter().copied().peekable();
        let (mut part, mut next) =
            (1, Segment { start, end, length: h, preceding: h, jump: false });
        std::iter::from_fn(move || {
            if part > substeps {
                return None;
            }
            let end = if part == substeps { end } else { start + h * Scalar::from(part) };
            while let Some(time) = discontinuities.next_if(|time| *time < end - near) {
                let before = next;
                next.jump = true;
                if time - before.start > near {
                    let length = time - before.start;
                    (next.start, next.length, next.preceding) = (time, end - time, length);
                    return Some(Segment { end: time, length, ..before });
                }
            }
            let last = Segment { end, ..next };
            next = Segment { start: end, end, length: h, preceding: last.length, jump: false };
            part += 1;
            Some(last)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segments(times: TickTimes, discontinuities: &[f64]) -> Vec<(f64, f64, bool)> {
        let segments: Vec<_> = times.segments(&mut discontinuities.iter()).iter().collect();
        assert!(segments.windows(2).all(|pair| pair[0].end == pair[1].start));
        assert_eq!((segments[0].start, segments[segments.len() - 1].end), (times.start, times.end));
        segments.into_iter().map(|segment| (segment.start, segment.length, segment.jump)).collect()
    }

    #[test]
    fn a_tick_is_split_at_substeps_and_discontinuities() {
        let times = TickTimes { start: 1.0, end: 2.0, tick: 1.0, substeps: 2 };
        assert_eq!(segments(times, &[]), [(1.0, 0.5, false), (1.5, 0.5, false)]);
        assert_eq!(segments(times, &[0.9, 2.0, 7.0]), [(1.0, 0.5, false), (1.5, 0.5, false)]);
        assert_eq!(
            segments(times, &[1.75, 1.25]),
            [(1.0, 0.25, false), (1.25, 0.25, true), (1.5, 0.25, false), (1.75, 0.25, true)]
        );
    }

    #[test]
    fn a_discontinuity_within_rounding_of_an_end_splits_nothing_and_marks_the_next_start() {
        let times = TickTimes { start: 1.0, end: 2.0, tick: 1.0, substeps: 2 };
        for error in [-1e-15, 0.0, 1e-15] {
            assert_eq!(
                segments(times, &[1.0 + error]),
                [(1.0, 0.5, true), (1.5, 0.5, false)],
                "{error}"
            );
            assert_eq!(
                segments(times, &[1.5 + error]),
                [(1.0, 0.5, false), (1.5, 0.5, true)],
                "{error}"
            );
        }
    }
}
