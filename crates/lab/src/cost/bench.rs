//! A study on its way: runs one after the other, a little at a time.
//!
//! A study is a list of jobs, done a little at a time: one tick of a run, or one timing. The command line gives it all the
//! time there is and the window a tenth of each frame; both get the same numbers, because no job looks at who waits.

use std::collections::VecDeque;

use history::REFERENCE_METHOD;
use motion::Method;

use super::clock::{Clock, thread_time};
use super::drift::Drifting;
use super::plan::Plan;
use super::record::{Cell, Host, Outcome, Precision, Setting, Study, Truth};
use super::runner::{Make, Sample, make};
use super::subject::Subject;
use super::timing::Timings;
use super::truth::{Sampled, Samples, Target};
use crate::run::movable;

/// A relative error from which a reference is none.
const TRUSTED: f64 = 1e-2;

/// What damping by the tick does to methods of higher order.
const TICKWISE: &str = "the damping of this scene is a factor a substep of the two explicit Eulers, and a factor a tick of every \
                        other method: no substeps make that part of their error smaller";

/// Why a run was made shorter.
const CHAOTIC: &str = "later, references of different steps no longer agree";

/// A study that is being made. [`Bench::work`] goes on with it.
pub struct Bench {
    subject: Subject,
    plan: Plan,
    make: Box<Make>,
    clock: Box<Clock>,
    study: Study,
    target: Option<Target>,
    coarse: Option<Samples>,
    timings: Timings,
    jobs: VecDeque<Job>,
    current: Option<(Job, Going)>,
    /// Weight of the work that is done, and of all.
    done: f64,
    total: f64,
    /// Thread CPU time that may be spent, s; below 0 after a piece that was longer than what was left.
    credit: f64,
}

/// A run that takes many pieces.
enum Going {
    Sampled(Sampled),
    Drifting(Box<Drifting>),
}

impl Going {
    fn tick(&mut self) -> bool {
        match self {
            Self::Sampled(run) => run.tick(),
            Self::Drifting(run) => run.tick(),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Job {
    /// A run of the reference of so many substeps.
    Reference(u32),
    /// The error of a cell.
    Error(usize),
    /// One pass of a timing.
    Time(usize),
    /// The books of a setting.
    Drift(Setting),
    /// A second at the frame rates.
    Rates,
}

impl Bench {
    /// A study of `subject`, nothing run yet.
    pub fn new(subject: Subject, plan: Plan) -> Self {
        Self::with(subject, plan, Box::new(make), Box::new(thread_time))
    }

    /// The same of runs that `make` makes, timed by `clock`.
    pub fn with(mut subject: Subject, plan: Plan, make: Box<Make>, clock: Box<Clock>) -> Self {
        let rungs = plan.affordable(&mut subject, &*clock);
        Self::of_rungs(subject, plan, make, clock, &rungs)
    }

    fn of_rungs(subject: Subject, plan: Plan, make: Box<Make>, clock: Box<Clock>, rungs: &[u32]) -> Self {
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
            cells: plan.settings(rungs).into_iter().map(Cell::open).collect(),
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
            target: None,
            coarse: None,
            timings: Timings::default(),
            jobs: VecDeque::new(),
            current: None,
            done: 0.0,
            total: 0.0,
            credit: 0.0,
        };
        bench.plan_jobs(rungs);
        bench
    }

    /// Takes over what an earlier study of the same subject and plan has: those cells are not run again.
    pub fn resume(&mut self, earlier: &Study) {
        let same = (&earlier.subject, earlier.ticks, earlier.step_hz.to_bits())
            == (&self.study.subject, self.study.ticks, self.study.step_hz.to_bits());
        if !same {
            return;
        }
        let known =
            |setting: Setting| earlier.cells.iter().find(|cell| cell.setting == setting && cell.is_run());
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
        let drifted =
            |setting: &Setting| earlier.drifts.iter().any(|drift| drift.long && drift.setting == *setting);
        self.study.drifts.retain(|drift| drifted(&drift.setting));
        let (study, timings) = (&self.study, &self.timings);
        self.jobs.retain(|job| match job {
            Job::Drift(setting) => !drifted(setting),
            Job::Rates => earlier.rates.is_empty(),
            Job::Error(at) => !study.cells[*at].is_run(),
            Job::Time(at) => !timings.is_known(*at, study),
            _ => true,
        });
        if !self.jobs.iter().any(|job| matches!(job, Job::Error(_))) {
            self.jobs.retain(|job| !matches!(job, Job::Reference(_)));
            self.study.truth.clone_from(&earlier.truth);
            (self.study.position_scale_m, self.study.velocity_scale_m_s) =
                (earlier.position_scale_m, earlier.velocity_scale_m_s);
        }
        self.weigh();
    }

    fn plan_jobs(&mut self, rungs: &[u32]) {
        match self.subject.exact() {
            Some((exact, _)) => self.aim(Target::closed(&self.subject, exact)),
            None => {
                let finest = rungs.last().copied().unwrap_or(1).saturating_mul(self.plan.finer.max(2));
                self.jobs.extend([Job::Reference(finest / 2), Job::Reference(finest)]);
            }
        }
        self.jobs.extend((0..self.study.cells.len()).map(Job::Error));
        if self.plan.passes > 0 {
            let middle = rungs[rungs.len() / 2];
            self.timings = Timings::of(&mut self.study, &self.subject, &self.plan, middle);
        }
        for _ in 0..self.plan.passes {
            self.jobs.extend((0..self.timings.len()).map(Job::Time));
        }
        if self.plan.longer > 0 {
            self.jobs.extend(self.drifts(rungs).map(Job::Drift));
        }
        if self.plan.rates && self.subject.problem.is_none() {
            self.jobs.push_back(Job::Rates);
        }
        self.weigh();
    }

    /// The settings whose books are kept: every method at the scene's own step, or at the middle of the ladder.
    fn drifts(&self, rungs: &[u32]) -> impl Iterator<Item = Setting> + use<> {
        let own = self.subject.own();
        let middle = rungs[rungs.len() / 2];
        let substeps = if self.subject.problem.is_some() { middle } else { own.substeps };
        let solves = |method: &Method| self.subject.refusal(*method).is_none();
        let methods: Vec<_> = self.plan.methods.iter().copied().filter(solves).collect();
        methods.into_iter().map(move |method| Setting { method, substeps, precision: Precision::F64 })
    }

    /// Goes on for about `seconds` of thread CPU time; `true`: it is done.
    ///
    /// A piece that cannot be divided may take longer; then less is done the next times.
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
        self.jobs.is_empty() && self.current.is_none()
    }

    /// What is done of all, in [0, 1].
    pub fn progress(&self) -> f64 {
        if self.is_done() { 1.0 } else { (self.done / self.total.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0) }
    }

    /// What is known so far: a cell that was not run yet is [`Failure::NotRun`](super::Failure::NotRun).
    pub const fn study(&self) -> &Study {
        &self.study
    }

    /// The states that errors are measured from, at each sample time, of the bodies that can move; `None` before the
    /// reference is run.
    pub fn truth(&self) -> Option<&[Vec<Sample>]> {
        self.target.as_ref().map(|target| target.samples.as_slice())
    }

    /// One tick, or one timing; `false`: there is nothing left.
    fn piece(&mut self) -> bool {
        if let Some((job, run)) = &mut self.current {
            let job = *job;
            if run.tick()
                && let Some((_, run)) = self.current.take()
            {
                self.finish(job, run);
                self.done += self.weight(job);
            }
            return true;
        }
        let Some(job) = self.jobs.pop_front() else { return false };
        let run = match job {
            Job::Reference(substeps) => {
                let setting = Setting { method: REFERENCE_METHOD, substeps, precision: Precision::F64 };
                // The truth is the program's own run, whatever is studied.
                let made = make(&self.subject.continuous().0, setting, Host::World);
                made.map(|runner| Going::Sampled(Sampled::reference(runner, self.subject.ticks)))
                    .map_err(|failure| self.study.notes.push(format!("no reference: {failure}")))
                    .ok()
            }
            Job::Error(cell) => {
                let Cell { setting, outcome, .. } = &mut self.study.cells[cell];
                let made = (self.make)(&self.subject, *setting, setting.precision.host());
                made.map(|runner| Going::Sampled(Sampled::new(runner, self.subject.ticks)))
                    .map_err(|failure| *outcome = Outcome::Failed(failure))
                    .ok()
            }
            Job::Time(timing) => {
                let how = (&*self.make, &*self.clock);
                self.timings.pass(timing, &mut self.study, &self.subject, &self.plan, how);
                if !self.jobs.iter().any(|job| matches!(job, Job::Time(_))) {
                    self.timings.finish(&mut self.study);
                }
                None
            }
            Job::Drift(setting) => {
                let run = Drifting::new(&self.subject, setting, self.plan.longer);
                Some(Going::Drifting(Box::new(run)))
            }
            Job::Rates => {
                self.study.rates = super::rates::rates(&self.subject);
                None
            }
        };
        match run {
            Some(run) => self.current = Some((job, run)),
            None => self.done += self.weight(job),
        }
        true
    }

    fn finish(&mut self, job: Job, run: Going) {
        match (job, run) {
            (_, Going::Drifting(run)) => self.study.drifts.extend(run.finish()),
            (Job::Reference(substeps), Going::Sampled(run)) => self.finish_reference(substeps, run),
            (Job::Error(cell), Going::Sampled(run)) => {
                let (samples, _, mut runner) = run.finish();
                let Some(target) = &self.target else { return };
                let cell = &mut self.study.cells[cell];
                cell.outcome = target.judge(&samples, &mut *runner);
                cell.counts = runner.counts();
                cell.bytes_per_body_step = runner.bytes_per_body();
            }
            // Done in one go, or without samples.
            (Job::Time(_) | Job::Drift(_) | Job::Rates, _) => {}
        }
    }

    fn finish_reference(&mut self, runs: u32, run: Sampled) {
        let (samples, more, mut runner) = run.finish();
        if let Some(failure) = runner.failure() {
            self.study.notes.push(format!("the reference itself failed: {failure}"));
        }
        let target = Target::new(samples.clone(), more, &self.subject);
        if let Some(coarse) = self.coarse.replace(samples) {
            let own = target.errors(&coarse);
            // An error that is not a number is none to go by either.
            if own.relative.is_nan() || own.relative > TRUSTED {
                let mut shorter = self.subject.clone();
                if shorter.halve(CHAOTIC) {
                    self.begin_again(shorter);
                    return;
                }
                self.study.notes.push(format!(
                    "the reference itself is only known to {:.1e}: what is nearer to it cannot be told apart",
                    own.relative
                ));
            }
            if let Truth::Reference { substeps, relative_error, position_error_m, .. } = &mut self.study.truth
            {
                (*substeps, *relative_error, *position_error_m) = (runs, own.relative, own.position_m);
            }
            self.coarse = None;
            self.aim(target);
        }
    }

    /// Starts over with a shorter run of the same rungs.
    fn begin_again(&mut self, subject: Subject) {
        let mut rungs: Vec<_> = self.study.cells.iter().map(|cell| cell.setting.substeps).collect();
        rungs.dedup();
        let make = std::mem::replace(&mut self.make, Box::new(make));
        let clock = std::mem::replace(&mut self.clock, Box::new(thread_time));
        let credit = self.credit;
        *self = Self { credit, ..Self::of_rungs(subject, self.plan.clone(), make, clock, &rungs) };
    }

    fn aim(&mut self, target: Target) {
        (self.study.position_scale_m, self.study.velocity_scale_m_s) =
            (target.position_scale, target.velocity_scale);
        self.target = Some(target);
    }

    /// Notes how much work all jobs are.
    fn weigh(&mut self) {
        self.total = self.jobs.iter().map(|job| self.weight(*job)).sum();
    }

    /// About how much work a job is, in evaluations of a tick.
    fn weight(&self, job: Job) -> f64 {
        let of = |setting: Setting| {
            // An implicit step iterates.
            let solves = if setting.method == Method::ImplicitEuler { 5.0 } else { 1.0 };
            f64::from(setting.method.claims().evaluations_with_velocity_laws)
                * f64::from(setting.substeps)
                * solves
        };
        let ticks = self.subject.ticks as f64;
        match job {
            Job::Reference(substeps) => 4.0 * f64::from(substeps) * ticks,
            Job::Error(cell) => of(self.study.cells[cell].setting) * ticks,
            Job::Time(at) => match self.timings.what(at, &self.study) {
                // As many as there is time for, of some tenths of a microsecond.
                Some((Some(copies), _)) => (1e7 * self.plan.timed).max(f64::from(copies)),
                Some((None, setting)) => of(setting) * ticks.min(20.0),
                None => 0.0,
            },
            Job::Drift(setting) => of(setting) * ticks * f64::from(self.plan.longer),
            Job::Rates => {
                super::rates::seconds(&self.subject) as f64 * of(self.subject.own()) * self.study.step_hz
            }
        }
    }
}
