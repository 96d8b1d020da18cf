//! What runs are compared with.

use glam::DVec3;

use super::problem::State;
use super::record::{BLOWN_UP, Errors, Failure, Outcome, SAMPLES};
use super::runner::{Runner, Sample};
use super::subject::Subject;
use crate::run::movable;

/// The states of a run at its sample times, each of the bodies that can move.
pub(crate) type Samples = Vec<Vec<Sample>>;

/// A run that is looked at at its sample times.
pub(crate) struct Sampled {
    runner: Box<dyn Runner>,
    tick: u64,
    ticks: u64,
    samples: Samples,
    /// States between the samples, for scales.
    more: Option<Samples>,
}

/// States of a reference that its scales are read from, about: the samples alone might all be of one phase.
const LOOKS: u64 = 64;

impl Sampled {
    pub fn new(runner: Box<dyn Runner>, ticks: u64) -> Self {
        Self { runner, tick: 0, ticks, samples: Vec::new(), more: None }
    }

    /// The same with looks in between.
    pub fn reference(runner: Box<dyn Runner>, ticks: u64) -> Self {
        Self { more: Some(Vec::new()), ..Self::new(runner, ticks) }
    }

    /// Simulates one tick; whether it was the last.
    pub fn tick(&mut self) -> bool {
        self.runner.tick();
        self.tick += 1;
        if self.tick.is_multiple_of(self.ticks / SAMPLES) {
            self.samples.push(self.runner.states());
        } else if let Some(more) = &mut self.more
            && self.tick.is_multiple_of((self.ticks / LOOKS).max(1))
        {
            more.push(self.runner.states());
        }
        self.tick == self.ticks
    }

    /// The states at the sample times, those in between, and the run.
    pub fn finish(self) -> (Samples, Samples, Box<dyn Runner>) {
        (self.samples, self.more.unwrap_or_default(), self.runner)
    }
}

/// The truth at the sample times, and its scales.
#[derive(Clone, Debug)]
pub(crate) struct Target {
    pub samples: Samples,
    pub position_scale: f64,
    pub velocity_scale: f64,
}

impl Target {
    /// The target from states of `subject` at the sample times, with `more` states in between; keeps movable bodies only.
    pub fn new(mut samples: Samples, mut more: Samples, subject: &Subject) -> Self {
        let movable: Vec<u32> = movable(&subject.scene).map(|(id, _)| id).collect();
        for sample in samples.iter_mut().chain(&mut more) {
            sample.retain(|(id, ..)| movable.binary_search(id).is_ok());
        }
        let largest = |part: fn(&Sample) -> DVec3| {
            let states = samples.iter().chain(&more).flatten();
            let lengths = states.map(|sample| part(sample).length());
            let largest = lengths.fold(0.0, f64::max);
            if largest > 0.0 && largest.is_finite() { largest } else { 1.0 }
        };
        let (position_scale, velocity_scale) = (largest(|(_, x, _)| *x), largest(|(.., v)| *v));
        Self { samples, position_scale, velocity_scale }
    }

    /// The target from the closed form of a problem.
    pub fn closed(subject: &Subject, exact: fn(f64) -> Vec<State>) -> Self {
        let time = |k: u64| (subject.ticks / SAMPLES * k) as f64 / subject.scene.step_hz;
        let state = |t| movable(&subject.scene).zip(exact(t)).map(|((id, _), (x, v))| (id, x, v)).collect();
        let between = |k: u64| time(SAMPLES) * k as f64 / (16 * LOOKS) as f64;
        let samples = (1..=SAMPLES).map(|k| state(time(k))).collect();
        Self::new(samples, (0..=16 * LOOKS).map(|k| state(between(k))).collect(), subject)
    }

    /// How far `run` is from it.
    pub fn errors(&self, run: &Samples) -> Errors {
        let mut errors = Errors { relative: 0.0, position_m: 0.0, velocity_m_s: 0.0 };
        for (truth, sample) in self.samples.iter().zip(run) {
            let mut rest = sample.iter();
            for (id, x, v) in truth {
                let found = rest.find(|(other, ..)| other == id);
                let (dx, dv) =
                    found.map_or((f64::NAN, f64::NAN), |(_, ox, ov)| (ox.distance(*x), ov.distance(*v)));
                let relative = (dx / self.position_scale).hypot(dv / self.velocity_scale);
                errors.relative = larger(errors.relative, relative);
                errors.position_m = larger(errors.position_m, dx);
                errors.velocity_m_s = larger(errors.velocity_m_s, dv);
            }
        }
        errors
    }

    /// What became of a run.
    pub fn judge(&self, samples: &Samples, runner: &mut dyn Runner) -> Outcome {
        if let Some(failure) = runner.failure() {
            return Outcome::Failed(failure);
        }
        let errors = self.errors(samples);
        // Written so that an error that is not a number fails.
        if errors.relative <= BLOWN_UP { Outcome::Finished(errors) } else { Outcome::Failed(Failure::BlewUp) }
    }
}

/// The one of the larger magnitude; what is not a number stays.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.abs() <= a.abs() { a } else { b }
}
