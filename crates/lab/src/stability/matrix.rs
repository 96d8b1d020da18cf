//! The stability run: fills the survival matrix cell by cell, a little at a time.

use std::rc::Rc;

use history::REFERENCE_METHOD;
use motion::Method;
use scene::{Measure, Scene, SurvivalRow};

use crate::clock::thread_time;
use crate::jobs::Jobs;

use super::metric::Target;
use super::record::{CaseRow, FORMAT, Matrix};
use super::run::{CellRun, TargetRun};

/// Ticks between two looks at the clock.
const PIECE: u32 = 64;

/// A survival matrix in progress. [`StabilityRun::work`] continues it.
pub struct StabilityRun {
    scenes: Vec<Scene>,
    /// The rows, each with the index of its scene.
    rows: Vec<(usize, SurvivalRow)>,
    matrix: Matrix,
    jobs: Jobs<Job, CurrentRun>,
    /// The states that the current row or cell is compared with.
    target: Option<Rc<Target>>,
}

/// A run of a method on a row.
#[derive(Clone, Copy)]
struct Job {
    row: usize,
    method: Method,
    kind: JobKind,
}

#[derive(Clone, Copy, PartialEq)]
enum JobKind {
    /// The fine run that the cells of the row are compared with.
    Reference,
    /// A run of the same method at the origin, which its cell is compared with.
    Origin,
    Cell,
}

enum CurrentRun {
    Target(Box<TargetRun>),
    Cell(Box<CellRun>),
}

impl StabilityRun {
    /// The rows of `scenes` by `methods`, each of at most `ticks`, of which nothing was run yet. A scene without
    /// survival rows adds none.
    pub fn new(scenes: Vec<Scene>, methods: &[Method], ticks: Option<u64>) -> Self {
        let mut rows = Vec::new();
        for (at, scene) in scenes.iter().enumerate() {
            for row in scene.survival.iter().flatten() {
                let ticks = ticks.map_or(row.ticks, |ticks| ticks.clamp(1, row.ticks));
                rows.push((at, SurvivalRow { ticks, ..row.clone() }));
            }
        }
        let mut jobs = Jobs::default();
        for (at, (_, row)) in rows.iter().enumerate() {
            let job = |kind, method| Job { row: at, method, kind };
            if row.measure == Measure::Reference {
                jobs.waiting.push_back(job(JobKind::Reference, REFERENCE_METHOD));
            }
            for &method in methods {
                if row.measure == Measure::Origin {
                    jobs.waiting.push_back(job(JobKind::Origin, method));
                }
                jobs.waiting.push_back(job(JobKind::Cell, method));
            }
        }
        let open = rows.iter().map(|(at, row)| open(&scenes[*at], row)).collect();
        let mut run = Self {
            scenes,
            rows,
            matrix: Matrix { format: FORMAT, rows: open },
            jobs,
            target: None,
        };
        run.jobs.total = run.jobs.waiting.iter().map(|job| run.weight(*job)).sum();
        run
    }

    /// Works for about `seconds` of thread CPU time. Returns whether the matrix is done.
    pub fn work(&mut self, seconds: f64) -> bool {
        let start = thread_time();
        while self.piece() {
            if thread_time() - start >= seconds {
                break;
            }
        }
        self.is_done()
    }

    /// Whether every cell is run.
    pub fn is_done(&self) -> bool {
        self.jobs.is_done()
    }

    /// The part of the work that is done, in [0, 1].
    pub fn progress(&self) -> f64 {
        self.jobs.progress()
    }

    /// The title of the row that is being run.
    pub fn now(&self) -> Option<String> {
        let Jobs { waiting, current, .. } = &self.jobs;
        let job = current.as_ref().map(|(job, _)| job).or(waiting.front())?;
        Some(self.matrix.rows[job.row].title())
    }

    /// The matrix so far, with the cells that were run.
    pub const fn matrix(&self) -> &Matrix {
        &self.matrix
    }

    /// Approximate evaluations of a job.
    fn weight(&self, job: Job) -> f64 {
        let row = &self.rows[job.row].1;
        let substeps = if job.kind == JobKind::Reference {
            row.reference_substeps
        } else {
            row.substeps.least()
        };
        row.ticks as f64 * f64::from(substeps) * f64::from(job.method.claims().evaluations)
    }

    /// Runs some ticks. Returns false if no work is left.
    fn piece(&mut self) -> bool {
        if let Some((job, run)) = &mut self.jobs.current {
            let over = (0..PIECE).any(|_| match run {
                CurrentRun::Target(run) => run.tick(),
                CurrentRun::Cell(run) => run.tick(),
            });
            let job = *job;
            if over && let Some((_, run)) = self.jobs.current.take() {
                self.finish(job, run);
            }
            return true;
        }
        let Some(job) = self.jobs.waiting.pop_front() else { return false };
        let (at, row) = &self.rows[job.row];
        let scene = &self.scenes[*at];
        let target = |run| CurrentRun::Target(Box::new(run));
        let begun = match job.kind {
            JobKind::Reference => Ok(target(TargetRun::reference(scene, row))),
            JobKind::Origin => Ok(target(TargetRun::origin(scene, row, job.method))),
            JobKind::Cell => {
                let is_compared = matches!(row.measure, Measure::Reference | Measure::Origin);
                let run = CellRun::new(
                    scene,
                    row,
                    job.method,
                    self.target.clone().filter(|_| is_compared),
                );
                let cells = &mut self.matrix.rows[job.row].cells;
                run.map(|run| CurrentRun::Cell(Box::new(run))).map_err(|cell| cells.push(cell))
            }
        };
        match begun {
            Ok(run) => self.jobs.current = Some((job, run)),
            Err(()) => self.jobs.done += self.weight(job),
        }
        true
    }

    fn finish(&mut self, job: Job, run: CurrentRun) {
        match run {
            CurrentRun::Target(run) => self.target = Some(Rc::new(run.finish())),
            CurrentRun::Cell(run) => self.matrix.rows[job.row].cells.push(run.finish()),
        }
        self.jobs.done += self.weight(job);
    }
}

/// A row without cells.
fn open(scene: &Scene, row: &SurvivalRow) -> CaseRow {
    CaseRow {
        case: scene.name.clone(),
        description: scene.description.clone(),
        label: row.label.clone(),
        measure: row.measure.name().to_owned(),
        ticks: row.ticks,
        cells: Vec::new(),
    }
}
