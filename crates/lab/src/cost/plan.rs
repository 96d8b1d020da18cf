//! What a study runs: methods, rungs, how carefully times are measured, and how long all of it may take.

use std::ops::Range;

use history::{REFERENCE_METHOD, Simulation};
use motion::Method;
use scene::{Keeps, Substepping};

use super::record::Setting;
use super::subject::Subject;
use crate::clock::Clock;
use crate::run::{decade, size};

/// Least work of a batch of runs, as a multiple of the work of their reference: each batch runs the reference again,
/// which adds a third at most.
const LEAST_BATCH_WORK: f64 = 3.0;

/// Most memory of a batch of runs, bytes.
const MOST_BATCH_BYTES: u64 = 1 << 30;

/// Share of the machine's memory (1/n) that also bounds a batch.
const MEMORY_SHARE: u64 = 4;

/// Rungs that are never left out, however long they take.
const RUNGS_ALWAYS_KEPT: usize = 3;

/// Rungs that are left out only after the run was shortened.
const RUNGS_KEPT_BEFORE_SHORTENING: usize = 5;

/// A run of fewer ticks is not shortened to save time.
const LEAST_TICKS_TO_SHORTEN: u64 = 64;

/// Errors of a tick of plans that are short of time.
const FEW_ERRORS: [i32; 3] = [4, 6, 8];

/// Why a run was made shorter.
const WHY_SHORTENED: &str = "more would have taken too long for this plan";

/// What a study runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The methods that are compared.
    pub methods: Vec<Method>,
    /// The numbers of substeps to try (the *rungs* of a ladder), ascending; those outside the subject's own range are skipped.
    pub rungs: Vec<u32>,
    /// The errors of a tick to try where substeps are chosen: decades below the size of the subject, ascending. Up to as many
    /// substeps are chosen as the reference has.
    pub errors: Vec<i32>,
    /// How much finer than the finest rung the reference is, at least 2.
    pub finer: u32,
    /// Number of bodies, at least 1, at which methods are ranked by time, rounded up to whole copies of a problem side by
    /// side. A scene is timed as it is.
    pub bodies: u32,
    /// How often each setting is timed; 0 for not at all.
    pub passes: u32,
    /// Most thread CPU time of one timing, s; of a longer run only the beginning is timed.
    pub timed: f64,
    /// How many times longer the long runs of energy are; 0 for none.
    pub longer: u32,
    /// Whether the first simulated second is also run at several frame rates.
    pub rates: bool,
    /// Thread CPU time after which finer rungs are left out, s.
    pub patience: f64,
}

impl Plan {
    /// The plan that runs everything.
    pub fn full() -> Self {
        Self {
            methods: Method::ALL.to_vec(),
            rungs: half_octaves(1, 8192),
            errors: (4..=8).collect(),
            finer: 4,
            bodies: 1000,
            passes: 9,
            timed: 0.05,
            longer: 10,
            rates: true,
            patience: 600.0,
        }
    }

    /// The plan that answers for this number of subjects within a minute.
    pub fn quick(subjects: usize) -> Self {
        let share = 1.0 / subjects.max(1) as f64;
        Self {
            rungs: octaves(1, 8192),
            errors: FEW_ERRORS.to_vec(),
            passes: 5,
            timed: 0.01 * share.max(0.2),
            longer: 4,
            patience: 24.0 * share,
            ..Self::full()
        }
    }

    /// The plan for a running window: the same errors and counts at fewer rungs, without what the window does not
    /// show.
    pub fn live() -> Self {
        Self {
            rungs: octaves(1, 16),
            errors: FEW_ERRORS.to_vec(),
            passes: 5,
            timed: 0.005,
            longer: 0,
            rates: false,
            patience: 20.0,
            ..Self::full()
        }
    }

    /// The rungs for `subject`: those of a scene go up to 64, beyond which hardly any is worth its price, and include
    /// its own.
    pub(crate) fn rungs_of(&self, subject: &Subject) -> Vec<u32> {
        let (coarsest, finest) = subject.problem.map_or((1, 64), |problem| problem.ladder);
        let fits = |rung: &u32| (coarsest..=finest).contains(rung);
        let own = subject.own().substeps.fixed().filter(|_| subject.problem.is_none());
        let mut rungs: Vec<_> = self.rungs.iter().copied().filter(fits).chain(own).collect();
        rungs.sort_unstable();
        rungs.dedup();
        if rungs.is_empty() { vec![coarsest] } else { rungs }
    }

    /// The rungs that can be run in the plan's time, if an evaluation of all bodies takes `evaluation_s` of thread CPU time. Long
    /// runs are shortened before the ladder gets too short to show a slope; what is left out is noted.
    pub(crate) fn affordable(&self, subject: &mut Subject, evaluation_s: f64) -> Vec<u32> {
        let mut rungs = self.rungs_of(subject);
        let before = rungs.len();
        let price = |subject: &Subject, rungs: &[u32]| {
            evaluation_s * subject.ticks as f64 * self.evaluations(subject, rungs)
        };
        while price(subject, &rungs) > self.patience {
            let may_shorten = rungs.len() <= RUNGS_KEPT_BEFORE_SHORTENING
                && subject.ticks >= LEAST_TICKS_TO_SHORTEN;
            if may_shorten && subject.halve(WHY_SHORTENED) {
                continue;
            }
            if rungs.len() <= RUNGS_ALWAYS_KEPT {
                break;
            }
            rungs.pop();
        }
        if rungs.len() < before {
            let finest = rungs.last().copied().unwrap_or(1);
            subject.notes.push(format!(
                "more than {finest} substeps would have taken too long for this plan"
            ));
        }
        rungs
    }

    /// Approximate evaluations per tick of all runs that measure errors.
    fn evaluations(&self, subject: &Subject, rungs: &[u32]) -> f64 {
        let batches = self.batches(subject, rungs).len() as f64;
        let reference = work(self.reference(rungs));
        // One run of the reference and one of half its substeps for its own error, then one per batch.
        let references = if subject.exact().is_some() { 0.0 } else { (1.5 + batches) * reference };
        self.settings(subject, rungs).into_iter().map(work).sum::<f64>() + references
    }

    /// The reference for these rungs.
    pub(crate) fn reference(&self, rungs: &[u32]) -> Setting {
        let finest = rungs.last().copied().unwrap_or(1);
        let substeps = finest.saturating_mul(self.finer.max(2));
        Setting { method: REFERENCE_METHOD, substeps: substeps.into() }
    }

    /// Ranges of the settings that are compared with the truth side by side; with a closed form, each setting alone.
    pub(crate) fn batches(&self, subject: &Subject, rungs: &[u32]) -> Vec<Range<usize>> {
        let enough = LEAST_BATCH_WORK * work(self.reference(rungs));
        let room = scene::memory()
            .map_or(MOST_BATCH_BYTES, |bytes| MOST_BATCH_BYTES.min(bytes / MEMORY_SHARE));
        let most = usize::try_from(room / subject.scene.estimated_bytes(Keeps::default()).max(1))
            .unwrap_or(usize::MAX);
        let most = if subject.exact().is_some() { 1 } else { most.max(1) };
        let (mut batches, mut first, mut sum) = (Vec::new(), 0, 0.0);
        let works: Vec<_> = self.settings(subject, rungs).into_iter().map(work).collect();
        for (at, work) in works.iter().enumerate() {
            sum += work;
            if sum >= enough || at + 1 - first >= most || at + 1 == works.len() {
                batches.push(first..at + 1);
                (first, sum) = (at + 1, 0.0);
            }
        }
        batches
    }

    /// Numbers of copies that a problem with `bodies` bodies is timed with, ascending: for powers of ten, and for
    /// [`Self::bodies`].
    pub(crate) fn copies(&self, bodies: u32) -> Vec<u32> {
        let powers = (0..=5).map(|power| 10_u32.pow(power));
        let mut copies: Vec<_> =
            powers.chain([self.bodies]).map(|size| size.div_ceil(bodies.max(1))).collect();
        copies.sort_unstable();
        copies.dedup();
        copies
    }

    /// Every setting, coarse ones first.
    pub(crate) fn settings(&self, subject: &Subject, rungs: &[u32]) -> Vec<Setting> {
        let most = self.reference(rungs).substeps.least();
        let size = size(&subject.scene, subject.seconds());
        let chosen = |below: &i32| Substepping::auto(decade(size - below)).up_to(most);
        let own = Some(subject.own().substeps).filter(|own| own.fixed().is_none());
        let divisions = rungs.iter().copied().map(Substepping::Fixed);
        let divisions = divisions.chain(own).chain(self.errors.iter().map(chosen));
        let of_all =
            |substeps| self.methods.iter().map(move |&method| Setting { method, substeps });
        divisions.flat_map(of_all).collect()
    }
}

/// Approximate evaluations per tick of a setting: an implicit step iterates.
///
/// This weighs the runs of a study against each other. Estimates of time in [`crate::duration`] count more iterations, because
/// they decide what is refused.
pub(crate) fn work(Setting { method, substeps }: Setting) -> f64 {
    let solves = if method == Method::ImplicitEuler { 10.0 } else { 1.0 };
    // Most ticks need few of the substeps that could be chosen.
    let steps = substeps.choice().map_or(substeps.least(), |choice| choice.most / 4);
    f64::from(method.claims().evaluations_with_velocity_laws) * f64::from(steps) * solves
}

/// Thread CPU time after which the price of an evaluation is known well enough, s.
const PROBE_S: f64 = 0.02;

/// Ticks after which it is known well enough.
const PROBE_TICKS: f64 = 8.0;

/// A run that finds the price of an evaluation.
pub(crate) struct Probe {
    run: Simulation,
    setting: Setting,
    /// Whether the first tick, which is not timed, was run.
    is_warm: bool,
    ticks: f64,
    seconds: f64,
}

impl Probe {
    /// A run of `subject` with that number of substeps.
    pub fn new(subject: &Subject, substeps: u32) -> Self {
        let probe = Setting { method: REFERENCE_METHOD, substeps: substeps.into() };
        // With a closed form, runs are compared after every step: `by_steps` makes each step a tick.
        let (run, setting) = if subject.exact().is_some() {
            let (by_steps, step) = subject.by_steps(probe);
            (by_steps.run(step), step)
        } else {
            (subject.run(probe), probe)
        };
        Self { run, setting, is_warm: false, ticks: 0.0, seconds: 0.0 }
    }

    /// Simulates one tick. Returns whether the price is known.
    pub fn tick(&mut self, clock: &Clock) -> bool {
        let start = clock();
        self.run.tick();
        if !std::mem::replace(&mut self.is_warm, true) {
            return false;
        }
        self.seconds += clock() - start;
        self.ticks += 1.0;
        self.ticks >= PROBE_TICKS || self.seconds >= PROBE_S
    }

    /// Approximate thread CPU time of one evaluation of all bodies, s.
    pub fn evaluation_s(&self) -> f64 {
        self.seconds / self.ticks / work(self.setting)
    }
}

fn octaves(from: u32, to: u32) -> Vec<u32> {
    std::iter::successors(Some(from), |rung| rung.checked_mul(2))
        .take_while(|rung| *rung <= to)
        .collect()
}

/// 1, 2, 3, 4, 6, 8, 12, ...
fn half_octaves(from: u32, to: u32) -> Vec<u32> {
    let rung_and_half_octave =
        |rung: u32| [Some(rung), rung.is_multiple_of(2).then_some(rung / 2 * 3)];
    octaves(from, to)
        .into_iter()
        .flat_map(rung_and_half_octave)
        .flatten()
        .filter(|rung| *rung <= to)
        .collect()
}
