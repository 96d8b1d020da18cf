//! The run of a cell, and the run of the states that cells are compared with.

use std::rc::Rc;

use history::REFERENCE_METHOD;
use motion::Method;
use scene::{Measure, Scene, SurvivalRow, unsolvable};

use super::class::{Class, Extremes, Verdict};
use super::metric::{Metric, Target};
use super::record::{Cell, PREFIX, Prefix};
use super::row_run::RowRun;

/// A run whose states the cells are compared with.
pub(super) struct TargetRun {
    run: RowRun,
    metric: Metric,
    target: Target,
}

impl TargetRun {
    /// The fine run of a row.
    pub fn reference(scene: &Scene, row: &SurvivalRow) -> Self {
        let mut fine = row.scene(scene).damped_by_law();
        (fine.method, fine.substeps) = (REFERENCE_METHOD, row.reference_substeps.into());
        Self::new(&fine, row)
    }

    /// The run of the same method at the origin.
    pub fn origin(scene: &Scene, row: &SurvivalRow, method: Method) -> Self {
        let row = SurvivalRow { offset: motion::units::Vector::ZERO, ..row.clone() };
        let mut there = row.scene(scene);
        there.method = method;
        Self::new(&there, &row)
    }

    fn new(scene: &Scene, row: &SurvivalRow) -> Self {
        let mut run = RowRun::new(scene, row, false);
        let metric = Metric::new(scene, row, None);
        let target = Target::new(&mut run);
        Self { run, metric, target }
    }

    /// Simulates one tick. Returns whether it was the last: a run ends when a state turns non-finite.
    pub fn tick(&mut self) -> bool {
        self.run.tick();
        if self.run.failure().is_some() {
            return true;
        }
        if self.metric.is_look(self.run.ticks()) {
            self.target.look(&mut self.run);
        }
        self.run.ticks() == self.metric.ticks
    }

    /// The states that others are compared with, up to the first that is not finite.
    pub fn finish(self) -> Target {
        let mut target = self.target;
        target.failure = self.run.failure();
        target
    }
}

/// The cell of a refused method.
const fn refused(method: Method, why: String) -> Cell {
    Cell { method, class: Class::Refused, number: f64::NAN, bound: f64::NAN, why, prefix: None }
}

/// A run of one method.
pub(super) struct CellRun {
    row: SurvivalRow,
    method: Method,
    run: RowRun,
    metric: Metric,
    target: Option<Rc<Target>>,
    looks: usize,
    extremes: Extremes,
    prefix: Option<Prefix>,
    /// Whether it outlived the run that it is compared with.
    outlived: bool,
    why: String,
}

impl CellRun {
    /// The start of `row` of `scene` by `method`, compared with `target` if it is given.
    ///
    /// # Errors
    /// The cell of a refused method.
    pub fn new(
        scene: &Scene,
        row: &SurvivalRow,
        method: Method,
        target: Option<Rc<Target>>,
    ) -> Result<Self, Cell> {
        if let Some(why) = unsolvable(method, scene.mutual_gravity.is_some()) {
            return Err(refused(method, why.to_string()));
        }
        let mut own = row.scene(scene);
        own.method = method;
        let run = RowRun::new(&own, row, row.measure == Measure::Energy);
        Ok(Self {
            row: row.clone(),
            method,
            run,
            metric: Metric::new(&own, row, target.as_deref()),
            target,
            looks: 0,
            extremes: Extremes::default(),
            prefix: None,
            outlived: false,
            why: String::new(),
        })
    }

    /// Simulates one tick. Returns whether it was the last: a run ends when it has exploded.
    pub fn tick(&mut self) -> bool {
        self.run.tick();
        let ticks = self.run.ticks();
        let last = ticks == self.row.ticks;
        let mut over = false;
        if let Some(why) = self.run.failure() {
            self.extremes.look(f64::INFINITY);
            (self.why, over) = (why, true);
        } else if self.metric.is_look(ticks) {
            if let Some(why) =
                self.target.as_ref().and_then(|target| target.ends_before(self.looks))
            {
                self.why = format!("the run that it is compared with failed: {why}");
                (self.outlived, over) = (true, true);
            } else {
                self.extremes.look(self.metric.number(
                    &mut self.run,
                    self.target.as_deref(),
                    self.looks,
                ));
                self.looks += 1;
                over = self.extremes.verdict(&self.row.bounds).class == Class::Explodes;
                if over && !last {
                    self.why = format!("given up after tick {ticks} of {}", self.row.ticks);
                }
            }
        }
        if (ticks == PREFIX && !last) || (over && ticks < PREFIX && self.row.ticks > PREFIX) {
            let Verdict { class, number, .. } = self.extremes.verdict(&self.row.bounds);
            self.prefix = Some(Prefix { class, number });
        }
        over || last
    }

    pub fn finish(self) -> Cell {
        let Verdict { class, number, bound } = self.extremes.verdict(&self.row.bounds);
        let mut why = self.why;
        let steps = self.run.unconverged();
        if steps > 0 {
            let separator = if why.is_empty() { "" } else { "; " };
            why += &format!("{separator}{steps} implicit steps did not converge");
        }
        if self.outlived {
            return refused(self.method, why);
        }
        Cell { method: self.method, class, number, bound, why, prefix: self.prefix }
    }
}
