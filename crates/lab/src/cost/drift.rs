//! Energy that a method invents or loses over short and long runs, by the ledger.

use glam::DVec3;
use history::Simulation;
use motion::ledger::Ledger;
use motion::snapshot::LastStep;
use motion::{Method, PhysicsBody, forces_on};

use super::record::{Drift, EnergyScale, Setting};
use super::subject::Subject;
use super::truth::larger;

/// Approximate number of points of a series.
const POINTS: u64 = 200;

/// Kinetic energy of position Verlet at the time of its positions minus that of its velocities, J, which lag half a
/// step behind; 0 for every other method.
fn late_energy(run: &Simulation) -> f64 {
    if run.method() != Method::PositionVerlet {
        return 0.0;
    }
    let bodies = run.bodies.iter().filter_map(|body| {
        let (last, state) =
            (run.world.get::<LastStep>(*body)?, run.world.get::<PhysicsBody>(*body)?);
        (last.0 != 0.0 && state.inverse_mass > 0.0).then(|| {
            let force: DVec3 =
                forces_on(&run.world, *body).into_iter().map(|(_, newtons)| newtons).sum();
            let now = state.velocity + force * (state.inverse_mass * 0.5 * last.0);
            0.5 * (now.length_squared() - state.velocity.length_squared()) / state.inverse_mass
        })
    });
    bodies.sum()
}

/// Energy that the method of `run` has invented since `ledger` was opened, J; negative if it has lost energy.
pub(crate) fn invented(ledger: &Ledger, run: &Simulation) -> f64 {
    ledger.since_opening().energy.residual + late_energy(run)
}

/// A run with a ledger.
pub(crate) struct DriftRun {
    setting: Setting,
    run: Simulation,
    ledger: Ledger,
    short: u64,
    ticks: u64,
    /// Length of a tick, s.
    length: f64,
    every: u64,
    /// Largest magnitude of the residual so far, J.
    largest: f64,
    /// Peak kinetic energy so far, J.
    peak_kinetic: f64,
    /// Times, s, and residuals, J.
    series: Vec<(f64, f64)>,
    found: Vec<Drift>,
}

impl DriftRun {
    /// A run of `setting` that is `longer` times as long as the subject's, at least once.
    pub fn new(subject: &Subject, setting: Setting, longer: u32) -> Self {
        // Each step of a problem becomes a tick, because a ledger samples once per tick and ticks are far longer than
        // substeps.
        let by_steps = subject.problem.is_some();
        let (subject, inner) =
            if by_steps { subject.by_steps(setting) } else { (subject.clone(), setting) };
        let run = subject.run(inner);
        let ledger = Ledger::open(&run.world);
        let ticks = subject.ticks * u64::from(longer.max(1));
        Self {
            setting,
            run,
            short: subject.ticks,
            ticks,
            length: 1.0 / subject.scene.step_hz,
            every: (ticks / POINTS).max(1),
            largest: 0.0,
            peak_kinetic: ledger.energies().kinetic,
            ledger,
            series: Vec::new(),
            found: Vec::new(),
        }
    }

    /// Simulates one tick. Returns whether it was the last.
    pub fn tick(&mut self) -> bool {
        self.run.tick_with(&mut self.ledger);
        let tick = self.run.ticks();
        self.peak_kinetic = self.peak_kinetic.max(self.ledger.energies().kinetic);
        let residual = invented(&self.ledger, &self.run);
        self.largest = larger(self.largest, residual).abs();
        if tick.is_multiple_of(self.every) && residual.is_finite() {
            self.series.push((self.time(), residual));
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
        let failed = self.run.failure().is_some();
        let (start, peak) = (self.ledger.energies_at_opening().total(), self.peak_kinetic);
        let (scale, joules) = if peak > start.abs() {
            (EnergyScale::PeakKinetic, peak)
        } else {
            (EnergyScale::Start, start.abs())
        };
        // Both energies are 0 where nothing moves.
        let relative = |energy: f64| if energy == 0.0 { 0.0 } else { energy / joules };
        let largest = relative(self.largest);
        self.found.push(Drift {
            setting: self.setting,
            long: self.run.ticks() > self.short,
            simulated_s: self.time(),
            scale,
            start: relative(start),
            largest: (largest.is_finite() && !failed).then_some(largest),
            series: self
                .series
                .iter()
                .map(|(time, residual)| (*time, relative(*residual)))
                .collect(),
        });
    }

    pub fn finish(self) -> Vec<Drift> {
        self.found
    }
}
