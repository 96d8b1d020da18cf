//! Energy that a method invents or loses over short and long runs, by the books.

use history::Simulation;
use motion::ledger::Ledger;

use super::record::{Drift, Setting};
use super::subject::Subject;
use super::truth::larger;

/// Points of a series, about.
const POINTS: u64 = 200;

/// A run whose books are kept.
pub(crate) struct Drifting {
    setting: Setting,
    run: Simulation,
    ledger: Ledger,
    short: u64,
    ticks: u64,
    /// Length of a tick, s.
    length: f64,
    every: u64,
    largest: f64,
    series: Vec<(f64, f64)>,
    found: Vec<Drift>,
}

impl Drifting {
    /// A run of `setting` that is `longer` times as long as the subject's, at least once.
    pub fn new(subject: &Subject, setting: Setting, longer: u32) -> Self {
        // The ticks of a problem are far longer than its substeps, and books are kept by the tick.
        let (mut subject, mut inner) = (subject.clone(), setting);
        if subject.problem.is_some() {
            subject.scene.step_hz *= f64::from(setting.substeps);
            subject.ticks *= u64::from(setting.substeps);
            inner.substeps = 1;
        }
        let mut run = subject.run(inner);
        let ledger = Ledger::open(&mut run.world);
        let ticks = subject.ticks * u64::from(longer.max(1));
        Self {
            setting,
            run,
            ledger,
            short: subject.ticks,
            ticks,
            length: 1.0 / subject.scene.step_hz,
            every: (ticks / POINTS).max(1),
            largest: 0.0,
            series: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Simulates one tick; whether it was the last.
    pub fn tick(&mut self) -> bool {
        self.ledger.tick(&mut self.run.stepper, &mut self.run.world);
        let tick = self.run.ticks();
        let size = self.ledger.relative_residual();
        // Both energies are 0 where nothing moves.
        let size = if size.is_nan() && self.ledger.energies().total() == 0.0 { 0.0 } else { size };
        self.largest = larger(self.largest, size);
        if tick.is_multiple_of(self.every) && size.is_finite() {
            let sign = self.ledger.since_opening().energy.residual;
            self.series.push((self.time(), size.copysign(sign)));
        }
        if tick == self.short || tick == self.ticks {
            self.note();
        }
        tick == self.ticks
    }

    fn time(&self) -> f64 {
        self.run.ticks() as f64 * self.length
    }

    fn note(&mut self) {
        let failed = !self.run.world.resource::<motion::Quarantine>().records().is_empty();
        self.found.push(Drift {
            setting: self.setting,
            long: self.run.ticks() > self.short,
            simulated_s: self.time(),
            largest: (self.largest.is_finite() && !failed).then_some(self.largest),
            series: self.series.clone(),
        });
    }

    pub fn finish(self) -> Vec<Drift> {
        self.found
    }
}
