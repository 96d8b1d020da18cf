//! One cell on its way.

use std::rc::Rc;

use history::REFERENCE_METHOD;
use motion::Method;
use scene::{Measure, Scene, SurvivalRow, unsolvable};

use super::class::{Class, Extremes, Verdict};
use super::gauge::{Gauge, Target};
use super::host::Host;
use super::record::{Cell, PREFIX, Prefix};

/// A run whose positions others are compared with.
pub(super) struct Targeting {
    host: Host,
    gauge: Gauge,
    target: Target,
}

impl Targeting {
    /// The fine run of a row.
    pub fn reference(scene: &Scene, row: &SurvivalRow) -> Self {
        let mut fine = row.scene(scene).damped_by_law();
        (fine.method, fine.substeps) = (REFERENCE_METHOD, row.reference_substeps);
        Self::new(&fine, row)
    }

    /// The same method at the origin.
    pub fn origin(scene: &Scene, row: &SurvivalRow, method: Method) -> Self {
        let row = SurvivalRow { offset: motion::units::Vector::ZERO, ..row.clone() };
        let mut there = row.scene(scene);
        there.method = method;
        Self::new(&there, &row)
    }

    fn new(scene: &Scene, row: &SurvivalRow) -> Self {
        let row = SurvivalRow { single: false, ..row.clone() };
        let mut host = Host::new(scene, &row, false);
        let gauge = Gauge::new(scene, &row, None);
        let target = Target::new(&mut host);
        Self { host, gauge, target }
    }

    /// Simulates one tick; whether it was the last: one in which something turned non-finite is.
    pub fn tick(&mut self) -> bool {
        self.host.tick();
        if self.host.failure().is_some() {
            return true;
        }
        if self.gauge.is_look(self.host.ticks()) {
            self.target.look(&mut self.host);
        }
        self.host.ticks() == self.gauge.ticks
    }

    /// What others are compared with, up to where something turned non-finite.
    pub fn finish(self) -> Target {
        let mut target = self.target;
        target.failure = self.host.failure();
        target
    }
}

/// The cell of a method without a number.
const fn refused(method: Method, why: String) -> Cell {
    Cell { method, class: Class::Refused, number: f64::NAN, bound: f64::NAN, why, prefix: None }
}

/// A run of one method.
pub(super) struct Running {
    row: SurvivalRow,
    method: Method,
    host: Host,
    gauge: Gauge,
    target: Option<Rc<Target>>,
    looks: usize,
    extremes: Extremes,
    prefix: Option<Prefix>,
    /// Whether it went on where what it is compared with did not.
    outlived: bool,
    why: String,
}

impl Running {
    /// The start of `row` of `scene` by `method`; `target` is what it is compared with, if it is.
    ///
    /// # Errors
    /// Why the method is refused, as the cell that it is then.
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
        let host = Host::new(&own, row, row.measure == Measure::Energy);
        Ok(Self {
            row: row.clone(),
            method,
            host,
            gauge: Gauge::new(&own, row, target.as_deref()),
            target,
            looks: 0,
            extremes: Extremes::default(),
            prefix: None,
            outlived: false,
            why: String::new(),
        })
    }

    /// Simulates one tick; whether it was the last: of a run that has exploded nothing more is to be learned.
    pub fn tick(&mut self) -> bool {
        self.host.tick();
        let ticks = self.host.ticks();
        let last = ticks == self.row.ticks;
        let mut over = false;
        if let Some(why) = self.host.failure() {
            self.extremes.look(f64::INFINITY);
            (self.why, over) = (why, true);
        } else if self.gauge.is_look(ticks) {
            if let Some(why) = self.target.as_ref().and_then(|target| target.ends_before(self.looks)) {
                self.why = format!("the run that it is compared with failed: {why}");
                (self.outlived, over) = (true, true);
            } else {
                self.extremes.look(self.gauge.number(&mut self.host, self.target.as_deref(), self.looks));
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
        let steps = self.host.unconverged();
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
