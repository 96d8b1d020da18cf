//! A running study: a list of jobs, done in small pieces.
//!
//! A piece is one tick of a run, the making of one, or one timing. The command line runs pieces one after the other, the window spends a
//! tenth of each frame on them. Both get the same numbers, because a job does not depend on the time between its
//! pieces.

use std::ops::Range;

use history::REFERENCE_METHOD;
use motion::Method;

use super::drift::DriftRun;
use super::hosts::{Make, make};
use super::plan::{Plan, Probe, work};
use super::record::{Cell, Failure, Host, Outcome, Setting, Study, Truth};
use super::runner::Runner;
use super::subject::Subject;
use super::timing::Timings;
use super::truth::{Compared, Comparison, Reference, Scales, Target};
use crate::clock::{Clock, thread_time};
use crate::jobs::Jobs;
use crate::run::movable;

/// Relative error of a reference above which the run is shortened, if it may be, or a note says how far to trust it.
const TRUSTED: f64 = 1e-2;

/// The note on damping per tick, which limits methods of higher order.
const TICKWISE: &str = "the damping of this scene is a factor per substep in the two explicit Eulers, and a factor per tick in every \
                        other method: more substeps do not make that part of their error smaller";

/// Why a run was made shorter.
const CHAOTIC: &str = "later, references of different steps no longer agree";

/// A study in progress. [`Bench::work`] continues it.
pub struct Bench {
    subject: Subject,
    plan: Plan,
    make: Box<Make>,
    clock: Box<Clock>,
    study: Study,
    /// Scales of the truth, once it is known.
    scales: Option<Scales>,
    timings: Timings,
    jobs: Jobs<Job, CurrentRun>,
    /// The runs of the next comparison so far, by their cells: making one of a large scene takes as long as its ticks.
    made: Vec<(usize, Box<dyn Runner>)>,
    /// Thread CPU time that may be spent, s; below 0 after a piece that took longer than the rest of it.
    credit: f64,
}

/// A run that takes many pieces.
enum CurrentRun {
    Probe(Box<Probe>),
    Reference(Box<Reference>),
    Comparison(Box<Comparison>),
    DriftRun(Box<DriftRun>),
}

impl CurrentRun {
    fn tick(&mut self, clock: &Clock) -> bool {
        match self {
            Self::Probe(run) => run.tick(clock),
            Self::Reference(run) => run.tick(),
            Self::Comparison(runs) => runs.tick(),
            Self::DriftRun(run) => run.tick(),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Job {
    /// The price of an evaluation, which decides how many rungs are run.
    Price,
    /// The reference with this number of substeps: its own error, and its scales.
    Reference(u32),
    /// The errors of the cells from the first index up to the second, side by side.
    Errors(usize, usize),
    /// One pass of a timing.
    Time(usize),
    /// The ledger of a setting.
    Drift(Setting),
    /// A second at each frame rate.
    Rates,
}

impl Bench {
    /// A study of `subject`, of which nothing was run yet.
    pub fn new(subject: Subject, plan: Plan) -> Self {
        Self::with(subject, plan, Box::new(make), Box::new(thread_time))
    }

    /// [`Self::new`] with runs from `make` and times from `clock`.
    pub fn with(subject: Subject, plan: Plan, make: Box<Make>, clock: Box<Clock>) -> Self {
        let rungs = plan.rungs_of(&subject);
        let mut bench = Self::of_rungs(subject, plan, make, clock, &rungs);
        bench.jobs.waiting.push_front(Job::Price);
        bench
    }

    fn of_rungs(
        subject: Subject,
        plan: Plan,
        make: Box<Make>,
        clock: Box<Clock>,
        rungs: &[u32],
    ) -> Self {
        let (_, exact_damping) = subject.continuous();
        let mut study = Study {
            subject: subject.scene.name.clone(),
            description: subject.scene.description.clone(),
            step_hz: subject.scene.step_hz,
            ticks: subject.ticks,
            simulated_s: subject.seconds(),
            bodies: movable(&subject.scene).count(),
            period_s: subject.problem.and_then(|problem| problem.period),
            own: subject.own(),
            truth: match subject.exact() {
                Some((_, source)) => Truth::ClosedForm { source: source.to_owned() },
                None => Truth::Reference {
                    method: REFERENCE_METHOD,
                    substeps: 0,
                    relative_error: 0.0,
                    position_error_m: 0.0,
                    exact_damping,
                },
            },
            position_scale_m: 1.0,
            velocity_scale_m_s: 1.0,
            cells: plan.settings(&subject, rungs).into_iter().map(Cell::not_run).collect(),
            timed_bodies: None,
            tick_times: Vec::new(),
            drifts: Vec::new(),
            rates: Vec::new(),
            notes: subject.notes.clone(),
        };
        if exact_damping {
            study.notes.push(TICKWISE.to_owned());
        }
        let mut bench = Self {
            subject,
            plan,
            make,
            clock,
            study,
            scales: None,
            timings: Timings::default(),
            jobs: Jobs::default(),
            made: Vec::new(),
            credit: 0.0,
        };
        bench.plan_jobs(rungs);
        bench
    }

    /// Takes over the results of an earlier study of the same subject and plan: those cells are not run again.
    pub fn resume(&mut self, earlier: &Study) {
        self.find_price();
        let same = (&earlier.subject, earlier.ticks, earlier.step_hz.to_bits())
            == (&self.study.subject, self.study.ticks, self.study.step_hz.to_bits());
        if !same {
            return;
        }
        let known = |setting: Setting| {
            earlier.cells.iter().find(|cell| cell.setting == setting && cell.is_run())
        };
        for cell in &mut self.study.cells {
            if let Some(known) = known(cell.setting) {
                cell.clone_from(known);
            }
        }
        self.study.drifts.clone_from(&earlier.drifts);
        self.study.rates.clone_from(&earlier.rates);
        if earlier.timed_bodies == self.study.timed_bodies {
            self.study.tick_times.clone_from(&earlier.tick_times);
        }
        let drifted = |setting: &Setting| {
            earlier.drifts.iter().any(|drift| drift.long && drift.setting == *setting)
        };
        self.study.drifts.retain(|drift| drifted(&drift.setting));
        let (study, timings) = (&self.study, &self.timings);
        self.jobs.waiting.retain(|job| match job {
            Job::Drift(setting) => !drifted(setting),
            Job::Rates => earlier.rates.is_empty(),
            Job::Errors(from, to) => !study.cells[*from..*to].iter().all(Cell::is_run),
            Job::Time(at) => !timings.is_known(*at, study),
            Job::Price | Job::Reference(_) => true,
        });
        if !self.jobs.waiting.iter().any(|job| matches!(job, Job::Errors(..))) {
            self.jobs.waiting.retain(|job| !matches!(job, Job::Reference(_)));
            self.study.truth.clone_from(&earlier.truth);
            (self.study.position_scale_m, self.study.velocity_scale_m_s) =
                (earlier.position_scale_m, earlier.velocity_scale_m_s);
        }
        self.weigh();
    }

    /// Finds the price of an evaluation, if it is not known: with it, the length of the run and the cells are final.
    fn find_price(&mut self) {
        let is_unknown = |bench: &Self| {
            let current = bench.jobs.current.as_ref().map(|(job, _)| job);
            current.or(bench.jobs.waiting.front()) == Some(&Job::Price)
        };
        while is_unknown(self) {
            self.piece();
        }
    }

    fn plan_jobs(&mut self, rungs: &[u32]) {
        match self.subject.exact() {
            Some((exact, _)) => self.set_scales(Target::scales(&self.subject, exact)),
            None => {
                self.jobs
                    .waiting
                    .push_back(Job::Reference(self.plan.reference(rungs).substeps.least()));
            }
        }
        let batches = self.plan.batches(&self.subject, rungs);
        self.jobs
            .waiting
            .extend(batches.into_iter().map(|cells| Job::Errors(cells.start, cells.end)));
        if self.plan.passes > 0 {
            let middle = rungs[rungs.len() / 2];
            self.timings = Timings::of(&mut self.study, &self.subject, &self.plan, middle);
        }
        for _ in 0..self.plan.passes {
            self.jobs.waiting.extend((0..self.timings.len()).map(Job::Time));
        }
        if self.plan.longer > 0 {
            self.jobs.waiting.extend(self.drifts(rungs).map(Job::Drift));
        }
        if self.plan.rates
            && self.subject.problem.is_none()
            && super::rates::are_compared(&self.subject)
        {
            self.jobs.waiting.push_back(Job::Rates);
        }
        self.weigh();
    }

    /// The settings with a ledger: every method at the scene's own step, or at the middle of the ladder.
    fn drifts(&self, rungs: &[u32]) -> impl Iterator<Item = Setting> + use<> {
        let own = self.subject.own();
        let middle = rungs[rungs.len() / 2];
        let substeps = if self.subject.problem.is_some() { middle.into() } else { own.substeps };
        let solves = |method: &Method| self.subject.refusal(*method).is_none();
        let methods: Vec<_> = self.plan.methods.iter().copied().filter(solves).collect();
        methods.into_iter().map(move |method| Setting { method, substeps })
    }

    /// Works for about `seconds` of thread CPU time. Returns whether the study is done.
    ///
    /// A piece cannot be divided and may take longer; the next calls then do less.
    pub fn work(&mut self, seconds: f64) -> bool {
        self.credit = (self.credit + seconds).min(seconds);
        while self.credit > 0.0 {
            let start = (self.clock)();
            let more = self.piece();
            self.credit -= (self.clock)() - start;
            if !more {
                return true;
            }
        }
        self.is_done()
    }

    /// Whether everything that was planned is run.
    pub fn is_done(&self) -> bool {
        self.jobs.is_done()
    }

    /// The part of the work that is done, in [0, 1].
    pub fn progress(&self) -> f64 {
        self.jobs.progress()
    }

    /// The subject, with the present length of its run.
    pub const fn subject(&self) -> &Subject {
        &self.subject
    }

    /// The study so far: a cell that was not run yet is [`Failure::NotRun`](super::Failure::NotRun).
    pub const fn study(&self) -> &Study {
        &self.study
    }

    /// The start of a reference with this number of substeps.
    fn reference_of(&self, substeps: u32) -> Result<Box<dyn Runner>, Failure> {
        let setting = Setting { method: REFERENCE_METHOD, substeps: substeps.into() };
        // Not `self.make`: the truth is a run of the program itself.
        make(&self.subject.continuous().0, setting, Host::World)
    }

    /// The start of the run that errors are measured against; `None` for a closed form, or before the error of the
    /// reference is known.
    pub fn reference(&self) -> Option<Box<dyn Runner>> {
        match self.study.truth {
            Truth::Reference { substeps, .. } if substeps > 0 => self.reference_of(substeps).ok(),
            Truth::ClosedForm { .. } | Truth::Reference { .. } => None,
        }
    }

    /// Does one piece. Returns false if no work is left.
    fn piece(&mut self) -> bool {
        if let Some((job, run)) = &mut self.jobs.current {
            let job = *job;
            if run.tick(&*self.clock)
                && let Some((_, run)) = self.jobs.current.take()
            {
                self.finish(job, run);
                self.jobs.done += self.weight(job);
            }
            return true;
        }
        let Some(job) = self.jobs.waiting.pop_front() else { return false };
        let run = match job {
            Job::Price => {
                let coarsest = self.plan.rungs_of(&self.subject)[0];
                Some(CurrentRun::Probe(Box::new(Probe::new(&self.subject, coarsest))))
            }
            Job::Reference(substeps) => {
                let pair = self.reference_of(substeps).and_then(|fine| {
                    let target = Target::run(&self.subject, fine);
                    Ok(Reference::new(target, self.reference_of(substeps / 2)?, self.subject.ticks))
                });
                pair.map(|pair| CurrentRun::Reference(Box::new(pair)))
                    .map_err(|failure| self.study.notes.push(format!("no reference: {failure}")))
                    .ok()
            }
            Job::Errors(from, to) => {
                if self.make_one(from..to) {
                    self.jobs.waiting.push_front(job);
                    return true;
                }
                self.compare().map(|runs| CurrentRun::Comparison(Box::new(runs)))
            }
            Job::Time(timing) => {
                let Self { timings, study, subject, plan, make, clock, .. } = self;
                timings.pass(timing, study, subject, plan, make, clock);
                if !self.jobs.waiting.iter().any(|job| matches!(job, Job::Time(_))) {
                    self.timings.finish(&mut self.study);
                }
                None
            }
            Job::Drift(setting) => {
                let run = DriftRun::new(&self.subject, setting, self.plan.longer);
                Some(CurrentRun::DriftRun(Box::new(run)))
            }
            Job::Rates => {
                self.study.rates = super::rates::rates(&self.subject);
                None
            }
        };
        match run {
            Some(run) => self.jobs.current = Some((job, run)),
            None => self.jobs.done += self.weight(job),
        }
        true
    }

    fn finish(&mut self, job: Job, run: CurrentRun) {
        match (job, run) {
            (_, CurrentRun::Probe(probe)) => {
                let mut subject = self.subject.clone();
                let rungs = self.plan.affordable(&mut subject, probe.evaluation_s());
                if rungs != self.rungs() || subject.ticks != self.subject.ticks {
                    self.restart(subject, &rungs);
                }
            }
            (_, CurrentRun::DriftRun(run)) => self.study.drifts.extend(run.finish()),
            (Job::Reference(substeps), CurrentRun::Reference(run)) => {
                self.finish_reference(substeps, *run);
            }
            (_, CurrentRun::Comparison(runs)) => {
                for Compared { cell, outcome, counts } in runs.finish() {
                    let cell = &mut self.study.cells[cell];
                    (cell.outcome, cell.counts) = (outcome, counts);
                }
            }
            (_, CurrentRun::Reference(_)) => {}
        }
    }

    /// Makes the run of the first of those cells that was neither run nor made. Returns whether there was one.
    fn make_one(&mut self, cells: Range<usize>) -> bool {
        let is_made = |at: usize| self.made.iter().any(|(cell, _)| *cell == at);
        let waits = |at: &usize| !self.study.cells[*at].is_run() && !is_made(*at);
        let Some(at) = cells.into_iter().find(waits).filter(|_| self.scales.is_some()) else {
            return false;
        };
        let setting = self.study.cells[at].setting;
        let made = match self.subject.exact() {
            // A closed form is known at every step, so each step becomes a tick.
            Some(_) => {
                let (subject, inner) = self.subject.by_steps(setting);
                (self.make)(&subject, inner, Host::World)
            }
            None => (self.make)(&self.subject, setting, Host::World),
        };
        match made {
            Ok(run) => self.made.push((at, run)),
            Err(failure) => self.study.cells[at].outcome = Outcome::Failed(failure),
        }
        true
    }

    /// Starts the runs that were made, beside the truth; `None` without runs, or while the truth is not known.
    fn compare(&mut self) -> Option<Comparison> {
        let runs = std::mem::take(&mut self.made);
        let (at, _) = runs.first()?;
        let (target, ticks) = match self.subject.exact() {
            Some((exact, _)) => {
                let (subject, _) = self.subject.by_steps(self.study.cells[*at].setting);
                (Target::closed(&subject, exact), subject.ticks)
            }
            None => (Target::run(&self.subject, self.reference()?), self.subject.ticks),
        };
        let period = self.subject.problem.and_then(|problem| problem.period);
        Some(Comparison::new(target, period, self.scales?, runs, ticks))
    }

    fn finish_reference(&mut self, substeps: u32, run: Reference) {
        let (scales, [relative, position_m], failure) = run.finish();
        if let Some(failure) = failure {
            self.study.notes.push(format!("the reference itself failed: {failure}"));
        }
        // An error that is NaN gives no bound.
        if relative.is_nan() || relative > TRUSTED {
            let mut shorter = self.subject.clone();
            if shorter.halve(CHAOTIC) {
                self.restart(shorter, &self.rungs());
                return;
            }
            self.study.notes.push(format!(
                "the reference itself may be off by {relative:.1e}: smaller errors cannot be compared"
            ));
        }
        if let Truth::Reference { substeps: own, relative_error, position_error_m, .. } =
            &mut self.study.truth
        {
            (*own, *relative_error, *position_error_m) = (substeps, relative, position_m);
        }
        self.set_scales(scales);
    }

    /// The numbers of substeps of the cells, ascending.
    fn rungs(&self) -> Vec<u32> {
        let cells = self.study.cells.iter();
        let mut rungs: Vec<_> = cells.filter_map(|cell| cell.setting.substeps.fixed()).collect();
        rungs.dedup();
        rungs
    }

    /// Restarts with a shorter run, or other rungs.
    fn restart(&mut self, subject: Subject, rungs: &[u32]) {
        let make = std::mem::replace(&mut self.make, Box::new(make));
        let clock = std::mem::replace(&mut self.clock, Box::new(thread_time));
        let credit = self.credit;
        *self = Self { credit, ..Self::of_rungs(subject, self.plan.clone(), make, clock, rungs) };
    }

    fn set_scales(&mut self, scales: Scales) {
        let Scales { position_m, velocity_m_s } = scales.divisors();
        (self.study.position_scale_m, self.study.velocity_scale_m_s) = (position_m, velocity_m_s);
        self.scales = Some(scales);
    }

    /// Sums up the work of all jobs.
    fn weigh(&mut self) {
        self.jobs.total = self.jobs.waiting.iter().map(|job| self.weight(*job)).sum();
    }

    /// Approximate work of a job, in evaluations.
    fn weight(&self, job: Job) -> f64 {
        let ticks = self.subject.ticks as f64;
        let reference = || work(self.plan.reference(&self.rungs()));
        match job {
            Job::Price => 0.0,
            Job::Reference(_) => 1.5 * reference() * ticks,
            Job::Errors(from, to) => {
                let cells =
                    self.study.cells[from..to].iter().map(|cell| work(cell.setting)).sum::<f64>();
                let beside = if self.subject.exact().is_some() { 0.0 } else { reference() };
                (cells + beside) * ticks
            }
            Job::Time(at) => match self.timings.what(at, &self.study) {
                // Copies are timed for a fixed time, at some tenths of a microsecond per evaluation.
                Some((Some(copies), _)) => (1e7 * self.plan.timed).max(f64::from(copies)),
                Some((None, setting)) => work(setting) * ticks.min(20.0),
                None => 0.0,
            },
            Job::Drift(setting) => work(setting) * ticks * f64::from(self.plan.longer),
            Job::Rates => {
                super::rates::seconds(&self.subject) as f64
                    * work(self.subject.own())
                    * self.study.step_hz
            }
        }
    }
}
