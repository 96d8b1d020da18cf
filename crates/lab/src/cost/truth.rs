//! The truth that runs are compared with, tick by tick. Only the largest errors of a run and their mean square are
//! stored, so that a long run takes no more memory than a short one.

use super::problem::State;
use super::record::{BLOWN_UP, Counts, Errors, Failure, Outcome, Phase};
use super::runner::{Runner, Sample};
use super::subject::Subject;
use crate::run::movable;

/// Intervals at whose ends a closed form is evaluated to find its scales.
const LOOKS: u32 = 1024;

/// Number of parts into which the first search for the nearest state of a closed form divides a period.
const PHASES: f64 = 256.0;

/// Scales of the motion of a truth: the largest distance of a body from the origin, m, and the largest speed, m/s.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Scales {
    pub position_m: f64,
    pub velocity_m_s: f64,
}

impl Scales {
    /// The scales of errors in meters and meters per second.
    pub const ONE: Self = Self { position_m: 1.0, velocity_m_s: 1.0 };

    fn add(&mut self, states: &[Sample]) {
        for (_, x, v) in states {
            self.position_m = self.position_m.max(x.length());
            self.velocity_m_s = self.velocity_m_s.max(v.length());
        }
    }

    /// The scales as divisors: 1 if a scale is 0 or not finite.
    pub const fn divisors(self) -> Self {
        let Self { position_m, velocity_m_s } = self;
        Self { position_m: divisor(position_m), velocity_m_s: divisor(velocity_m_s) }
    }
}

const fn divisor(scale: f64) -> f64 {
    if scale > 0.0 && scale.is_finite() { scale } else { 1.0 }
}

/// The source of the states of a target.
enum Source {
    Closed(fn(f64) -> Vec<State>),
    Run(Box<dyn Runner>),
}

/// The true motion of the bodies that can move, one tick after the other.
pub(crate) struct Target {
    source: Source,
    movable: Vec<u32>,
    tick: u64,
    step_hz: f64,
    states: Vec<Sample>,
}

impl Target {
    fn of(subject: &Subject, source: Source) -> Self {
        let movable = movable(&subject.scene).map(|(id, _)| id).collect();
        Self { source, movable, tick: 0, step_hz: subject.scene.step_hz, states: Vec::new() }
    }

    /// The closed form of a problem.
    pub fn closed(subject: &Subject, exact: fn(f64) -> Vec<State>) -> Self {
        Self::of(subject, Source::Closed(exact))
    }

    /// A run at far finer steps.
    pub fn run(subject: &Subject, runner: Box<dyn Runner>) -> Self {
        Self::of(subject, Source::Run(runner))
    }

    /// Advances to the end of the next tick.
    pub fn tick(&mut self) {
        self.tick += 1;
        match &mut self.source {
            Source::Closed(exact) => {
                let states = exact(self.tick as f64 / self.step_hz);
                self.states =
                    self.movable.iter().zip(states).map(|(id, (x, v))| (*id, x, v)).collect();
            }
            Source::Run(runner) => {
                runner.tick();
                self.states = runner.states();
                self.states.retain(|(id, ..)| self.movable.binary_search(id).is_ok());
            }
        }
    }

    /// Errors of phase and amplitude of a run at this tick, for a closed form with a `period`, s.
    fn phase(&self, period: Option<f64>, run: &[Sample], scales: Scales) -> Option<Phase> {
        let (Source::Closed(exact), Some(period)) = (&self.source, period) else { return None };
        let now = self.tick as f64 / self.step_hz;
        let run: Vec<_> =
            run.iter().filter(|(id, ..)| self.movable.binary_search(id).is_ok()).collect();
        let off_path = |late: f64| {
            let apart = |((x, v), (_, ox, ov)): (State, &&Sample)| {
                (ox.distance(x) / scales.position_m).hypot(ov.distance(v) / scales.velocity_m_s)
            };
            exact(now - late).into_iter().zip(&run).map(apart).fold(0.0, larger)
        };
        let step = period / PHASES;
        let coarse = (0..=PHASES as u32).map(|k| f64::from(k) * step - 0.5 * period);
        let near = coarse.min_by(|a, b| off_path(*a).total_cmp(&off_path(*b)))?;
        let late_s = least(near - step, near + step, off_path);
        Some(Phase { late_s, off_path: off_path(late_s) })
    }

    /// Scales of the closed form of a problem over its run.
    pub fn scales(subject: &Subject, exact: fn(f64) -> Vec<State>) -> Scales {
        let mut scales = Scales::default();
        for k in 0..=LOOKS {
            let states = exact(subject.seconds() * f64::from(k) / f64::from(LOOKS));
            scales.add(&states.into_iter().map(|(x, v)| (0, x, v)).collect::<Vec<_>>());
        }
        scales
    }
}

/// Pairs each state with that of the same body in `others`, if there is one. Both lists ascend by stable id.
pub(crate) fn paired<'a>(
    states: &'a [Sample],
    others: &'a [Sample],
) -> impl Iterator<Item = (&'a Sample, Option<&'a Sample>)> {
    let mut rest = others.iter().peekable();
    states.iter().map(move |state| {
        while rest.next_if(|(other, ..)| *other < state.0).is_some() {}
        (state, rest.next_if(|(other, ..)| *other == state.0))
    })
}

/// The errors of a run so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Deviation {
    largest: Errors,
    /// Sum of squares of distances, m².
    squares: f64,
    /// Number of distances.
    count: f64,
}

impl Deviation {
    /// Compares a run with the truth at the end of a tick.
    pub fn look(&mut self, truth: &[Sample], run: &[Sample], scales: Scales) {
        for ((_, x, v), found) in paired(truth, run) {
            let (dx, dv) = found
                .map_or((f64::NAN, f64::NAN), |(_, ox, ov)| (ox.distance(*x), ov.distance(*v)));
            let relative = (dx / scales.position_m).hypot(dv / scales.velocity_m_s);
            let Errors { relative: r, position_m: p, velocity_m_s: w, .. } = &mut self.largest;
            (*r, *p, *w) = (larger(*r, relative), larger(*p, dx), larger(*w, dv));
            self.squares += dx * dx;
        }
        self.count += truth.len() as f64;
    }

    pub fn errors(&self) -> Errors {
        let mean = if self.count > 0.0 { self.squares / self.count } else { 0.0 };
        Errors { position_rms_m: mean.sqrt(), ..self.largest }
    }
}

/// A reference of a subject beside a run with half its substeps, to find its scales and how uncertain it is.
pub(crate) struct Reference {
    truth: Target,
    coarse: Box<dyn Runner>,
    apart: Deviation,
    scales: Scales,
    ticks: u64,
}

impl Reference {
    pub fn new(truth: Target, coarse: Box<dyn Runner>, ticks: u64) -> Self {
        Self { truth, coarse, apart: Deviation::default(), scales: Scales::default(), ticks }
    }

    /// Simulates one tick. Returns whether it was the last.
    pub fn tick(&mut self) -> bool {
        self.truth.tick();
        self.coarse.tick();
        self.scales.add(&self.truth.states);
        self.apart.look(&self.truth.states, &self.coarse.states(), Scales::ONE);
        self.truth.tick == self.ticks
    }

    /// The scales, the reference's own relative error and its own error of positions, m, and why it failed, if it
    /// did.
    pub fn finish(self) -> (Scales, [f64; 2], Option<Failure>) {
        let (Errors { position_m, velocity_m_s, .. }, scales) =
            (self.apart.errors(), self.scales.divisors());
        // Not less than the largest relative error at any one time.
        let relative = (position_m / scales.position_m).hypot(velocity_m_s / scales.velocity_m_s);
        let failure = match self.truth.source {
            Source::Run(mut runner) => runner.failure(),
            Source::Closed(_) => None,
        };
        (self.scales, [relative, position_m], failure)
    }
}

/// One of the runs that are compared with the same truth.
struct Run {
    cell: usize,
    runner: Box<dyn Runner>,
    deviation: Deviation,
}

/// Runs side by side with the truth, all at the same tick.
pub(crate) struct Comparison {
    truth: Target,
    period: Option<f64>,
    scales: Scales,
    runs: Vec<Run>,
    /// The run whose turn it is.
    turn: usize,
    ticks: u64,
}

/// The outcome and the counts of the run of a cell.
pub(crate) struct Compared {
    pub cell: usize,
    pub outcome: Outcome,
    pub counts: Counts,
}

impl Comparison {
    /// Compares runs, given by their cells, with `truth` for `ticks` ticks; `period` is that of the problem, s, if it
    /// has one.
    pub fn new(
        truth: Target,
        period: Option<f64>,
        scales: Scales,
        runs: Vec<(usize, Box<dyn Runner>)>,
        ticks: u64,
    ) -> Self {
        let run = |(cell, runner)| Run { cell, runner, deviation: Deviation::default() };
        let runs = runs.into_iter().map(run).collect();
        Self { truth, period, scales: scales.divisors(), runs, turn: 0, ticks }
    }

    /// Simulates one tick of one run. Returns whether it was the last tick of the last run.
    pub fn tick(&mut self) -> bool {
        if self.turn == 0 {
            self.truth.tick();
        }
        if let Some(Run { runner, deviation, .. }) = self.runs.get_mut(self.turn) {
            runner.tick();
            deviation.look(&self.truth.states, &runner.states(), self.scales);
        }
        self.turn += 1;
        if self.turn < self.runs.len() {
            return false;
        }
        self.turn = 0;
        self.truth.tick == self.ticks
    }

    /// The outcome of each run.
    pub fn finish(self) -> impl Iterator<Item = Compared> {
        let Self { truth, period, scales, runs, .. } = self;
        runs.into_iter().map(move |Run { cell, mut runner, deviation }| {
            let (counts, failure) = (runner.counts(), runner.failure());
            // Otherwise the velocities of position Verlet would be half a step late.
            runner.synchronize();
            let phase = truth.phase(period, &runner.states(), scales);
            let errors = Errors { phase, ..deviation.errors() };
            let outcome = match failure {
                Some(failure) => Outcome::Failed(failure),
                // An error that is NaN fails this comparison.
                None if errors.relative <= BLOWN_UP => Outcome::Finished(errors),
                None => Outcome::Failed(Failure::BlewUp),
            };
            Compared { cell, outcome, counts }
        })
    }
}

/// The number of larger magnitude; NaN if either is NaN.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.abs() <= a.abs() { a } else { b }
}

/// The place of the minimum of `f` between `low` and `high`, by golden-section search (Kiefer 1953). `f` has to fall
/// and then rise there.
fn least(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    for _ in 0..80 {
        let part = GOLDEN * (high - low);
        if f(high - part) <= f(low + part) {
            high = low + part;
        } else {
            low = high - part;
        }
    }
    0.5 * (low + high)
}
