//! The timings of a study, pass by pass: of the cells of a scene, or of copies of a problem at several sizes.

use scene::Substepping;

use super::blocks::{Trial, Yardstick};
use super::hosts::Make;
use super::plan::Plan;
use super::record::{Host, Setting, Study, TickTime, Time, TimedTick};
use super::subject::Subject;
use crate::clock::Clock;

/// A method and host at one size.
struct Timing {
    /// The cell that is timed; for a problem, the cell with the same step.
    cell: usize,
    host: Host,
    /// Copies of a problem; `None` for a scene.
    copies: Option<u32>,
    trial: Trial,
}

/// All timings of a study, the smallest sizes first, so that methods take turns at each size.
#[derive(Default)]
pub(super) struct Timings {
    list: Vec<Timing>,
    yardstick: Yardstick,
    /// The copies that are being timed, and their number.
    many: Option<(u32, Subject)>,
    /// Time that all timings of that number of copies took besides the timed ticks, s.
    spent: f64,
}

impl Timings {
    /// The timings of every cell of a scene, or of every method of a problem at the rung `middle`.
    pub fn of(study: &mut Study, subject: &Subject, plan: &Plan, middle: u32) -> Self {
        let problem = subject.problem.is_some();
        let bodies = u32::try_from(study.bodies.max(1)).unwrap_or(u32::MAX);
        study.timed_bodies = problem.then(|| (plan.bodies.div_ceil(bodies) * bodies) as usize);
        let sizes: Vec<_> =
            if problem { plan.copies(bodies).into_iter().map(Some).collect() } else { vec![None] };
        let mut list = Vec::new();
        for copies in sizes {
            for (cell, Setting { substeps, .. }) in
                study.cells.iter().map(|cell| cell.setting).enumerate()
            {
                if problem && substeps != Substepping::Fixed(middle) {
                    continue;
                }
                let alone = subject.in_loop().map(|_| Host::Arithmetic);
                let hosts = [Host::World].into_iter().chain(alone);
                list.extend(hosts.map(|host| Timing {
                    cell,
                    host,
                    copies,
                    trial: Trial::default(),
                }));
            }
        }
        Self { list, ..Self::default() }
    }

    pub const fn len(&self) -> usize {
        self.list.len()
    }

    /// Copies of a timing, and its setting; `None` if it was given up.
    pub fn what(&self, at: usize, study: &Study) -> Option<(Option<u32>, Setting)> {
        let timing = self.list.get(at)?;
        Some((timing.copies, study.cells[timing.cell].setting))
    }

    /// Whether `study` has that time already.
    pub fn is_known(&self, at: usize, study: &Study) -> bool {
        let Timing { cell, host, copies, .. } = &self.list[at];
        match copies {
            Some(_) => !study.tick_times.is_empty(),
            None => study.cells[*cell].time_in(*host).is_some(),
        }
    }

    /// Runs one pass of a timing, unless its size would take too long: such sizes are given up.
    pub fn pass(
        &mut self,
        at: usize,
        study: &mut Study,
        subject: &Subject,
        plan: &Plan,
        make: &Make,
        clock: &Clock,
    ) {
        let Some(Timing { cell, copies, .. }) = self.list.get(at) else { return };
        let (cell, setting) = (*cell, study.cells[*cell].setting);
        let Some(copies) = *copies else {
            if study.cells[cell].errors().is_some() {
                self.time(at, subject, setting, plan, make, clock);
                self.note(at, study);
            }
            return;
        };
        if self.is_too_long(at, copies, study, plan) {
            self.list.truncate(at);
            let bodies = study.bodies.max(1) * copies as usize;
            study.notes.push(format!(
                "{bodies} bodies and more would have taken too long to time for this plan"
            ));
            return;
        }
        let many = self.many.take().filter(|(count, _)| *count == copies);
        let (_, many) =
            many.unwrap_or_else(|| (copies, subject.copies(copies, setting.substeps.least())));
        self.time(
            at,
            &many,
            Setting { substeps: Substepping::Fixed(1), ..setting },
            plan,
            make,
            clock,
        );
        self.many = Some((copies, many));
    }

    fn time(
        &mut self,
        at: usize,
        subject: &Subject,
        setting: Setting,
        plan: &Plan,
        make: &Make,
        clock: &Clock,
    ) {
        let start = clock();
        let Timing { trial, copies, host, .. } = &mut self.list[at];
        let Ok(mut runner) = make(subject, setting, *host) else { return };
        self.yardstick.measure(clock);
        let ticks = if copies.is_some() { u64::MAX / 2 } else { subject.ticks };
        trial.pass(&mut *runner, ticks, plan.timed, clock);
        self.spent += (clock() - start - plan.timed).max(0.0);
    }

    /// Whether the timings of this number of copies and more would take too long, judged by the first pass of the
    /// size before. Sizes up to the one that methods are ranked at never do.
    fn is_too_long(&mut self, at: usize, copies: u32, study: &Study, plan: &Plan) -> bool {
        let before = self.many.as_ref().map_or(1, |(count, _)| *count);
        if copies == before || self.list[at].trial.tick().is_some() {
            return false;
        }
        let spent = std::mem::take(&mut self.spent);
        let all = f64::from(copies) / f64::from(before) * spent * f64::from(plan.passes);
        study.timed_bodies < Some(study.bodies.max(1) * copies as usize)
            && all > plan.patience / 2.0
    }

    /// Writes the present time of a cell of a scene into `study`.
    fn note(&self, at: usize, study: &mut Study) {
        let Timing { cell, host, trial, .. } = &self.list[at];
        let Some(tick) = trial.tick() else { return };
        let setting = study.cells[*cell].setting;
        let steps = study.bodies.max(1) as f64 * study.steps(&study.cells[*cell]);
        let time = Time {
            ns_per_body_step: tick * 1e9 / steps,
            real_time_factor: 1.0 / (study.step_hz * tick),
            yardsticks: tick / steps / self.yardstick.seconds(),
            quartiles: trial.quartiles(),
        };
        match host {
            Host::World => study.cells[*cell].time = Some(time),
            Host::Arithmetic => study.cells[*cell].arithmetic_time = Some(time),
        }
        study.fit_substeps(setting, *host);
    }

    /// Writes the times of a problem into `study`, after the last timing.
    pub fn finish(&self, study: &mut Study) {
        let mut found: Vec<TickTime> = Vec::new();
        for Timing { cell, host, copies, trial } in &self.list {
            let (Some(copies), Some(tick)) = (copies, trial.tick()) else { continue };
            let setting = study.cells[*cell].setting;
            let body_steps = study.bodies.max(1) as f64 * f64::from(*copies);
            let point = TimedTick { body_steps, ns: 1e9 * tick, quartiles: trial.quartiles() };
            match found.iter_mut().find(|of| of.is_of(setting, *host)) {
                Some(of) => of.points.push(point),
                None => found.push(TickTime {
                    substeps: Some(setting.substeps.least()),
                    yardstick_ns: 1e9 * self.yardstick.seconds(),
                    ..TickTime::unfitted(setting, *host, vec![point])
                }),
            }
        }
        if !found.is_empty() {
            study.tick_times = found.into_iter().map(TickTime::fit).collect();
            study.time_cells();
        }
    }
}
