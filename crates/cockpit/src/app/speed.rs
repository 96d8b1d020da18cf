//! The speed at which a shell draws and simulates, over the last frames.

use std::collections::VecDeque;
use std::time::Duration;

use crate::app::session::Session;
use crate::view::Measured;

/// The settings that change how long a frame or a tick takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedSetting {
    pub pace: f64,
    pub paused: bool,
    pub ghosts: bool,
}

impl SpeedSetting {
    /// The settings of a session.
    pub fn of(session: &Session) -> Self {
        Self {
            pace: session.stage.playback().pace(),
            paused: session.stage.playback().paused(),
            ghosts: session.tools.shows_ghosts(),
        }
    }
}

/// Time over which means are taken, s.
const SPAN_S: f64 = 0.5;

/// One frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub length_s: f64,
    pub simulated_s: f64,
    pub ticks: u64,
    /// Time that the ticks took.
    pub ticking: Duration,
    pub setting: SpeedSetting,
}

/// The frames of the last half second, none older than the last change of the settings.
#[derive(Debug, Default)]
pub(crate) struct Speed {
    samples: VecDeque<Sample>,
    last: Measured,
}

impl Speed {
    pub fn frame(&mut self, sample: Sample) {
        if self.samples.back().is_some_and(|last| last.setting != sample.setting) {
            self.samples.clear();
        }
        self.samples.push_back(sample);
        let mut length: f64 = self.samples.iter().map(|sample| sample.length_s).sum();
        while self.samples.len() > 1 && length - self.samples[0].length_s >= SPAN_S {
            length -= self.samples.pop_front().map_or(0.0, |sample| sample.length_s);
        }
        self.last = self.means(length);
    }

    #[expect(clippy::cast_precision_loss, reason = "counts of half a second")]
    fn means(&self, length: f64) -> Measured {
        if length <= 0.0 {
            return self.last;
        }
        let ticks: u64 = self.samples.iter().map(|sample| sample.ticks).sum();
        let ticking: Duration = self.samples.iter().map(|sample| sample.ticking).sum();
        let simulated: f64 = self.samples.iter().map(|sample| sample.simulated_s).sum();
        Measured {
            frames_per_second: self.samples.len() as f64 / length,
            tick: if ticks > 0 { ticking.as_secs_f64() / ticks as f64 } else { self.last.tick },
            simulated_over_real: simulated / length,
        }
    }

    pub const fn measured(&self) -> Measured {
        self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(speed: &mut Speed, frames: u32, pace: f64, ghosts: bool) -> Measured {
        let tick = Duration::from_micros(if ghosts { 90 } else { 10 });
        for _ in 0..frames {
            speed.frame(Sample {
                length_s: 0.025,
                simulated_s: 0.025 * pace,
                ticks: 3,
                ticking: 3 * tick,
                setting: SpeedSetting { pace, paused: false, ghosts },
            });
        }
        speed.measured()
    }

    #[test]
    fn a_changed_pace_and_closed_ghosts_are_seen_in_the_next_frame() {
        let mut speed = Speed::default();
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-9, "{a} is not {b}");
        let before = run(&mut speed, 100, 1.0, true);
        close(before.frames_per_second, 40.0);
        close(before.simulated_over_real, 1.0);
        close(before.tick, 90e-6);
        close(run(&mut speed, 1, 0.125, true).simulated_over_real, 0.125);
        close(run(&mut speed, 1, 0.125, false).tick, 10e-6);
    }

    #[test]
    fn means_are_those_of_half_a_second() {
        let mut speed = Speed::default();
        run(&mut speed, 1000, 1.0, false);
        assert_eq!(speed.samples.len(), 20);
        // A hitch is forgotten as soon as half a second of other frames has passed.
        speed.frame(Sample { length_s: 3.0, simulated_s: 0.25, ..speed.samples[0] });
        assert!(speed.measured().simulated_over_real < 0.25);
        let after = run(&mut speed, 21, 1.0, false);
        assert!((after.simulated_over_real - 1.0).abs() < 1e-9);
    }
}
