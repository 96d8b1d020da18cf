//! The accelerations of a group in a state.

use super::classes::Class;
use super::{GroupField, Scratch};
use crate::groups::combination::{APPLIED, Combination};
use crate::groups::coupling::is_open;
use crate::groups::direct_sum::DirectSum;
use crate::groups::pull::Shares;
use crate::groups::rows::Row;
use crate::kernels::Block;
use crate::laws::{BLOCK_BODIES, BodyBlock, EvaluationTime, Law};
use crate::methods::Field as _;
use crate::state::threads::Threads;

impl<'a> GroupField<'a> {
    pub(super) fn apply_pushes(&mut self) {
        self.pushed = !self.scratch.pushes.is_empty();
        if !self.pushed {
            return;
        }
        let Scratch { slots, pushes, classes, .. } = &mut *self.scratch;
        let applied = &mut slots[APPLIED];
        applied.resize(self.coupling.rows);
        applied.fill([0.0; 4]);
        for (row, force) in pushes.drain(..) {
            let w = self.rows.w[row];
            if row < self.coupling.movable && w > 0.0 {
                let closed = classes.of(row).closed;
                for axis in 0..3 {
                    applied[row][axis] = if is_open(closed, axis) { force[axis] * w } else { 0.0 };
                }
            }
        }
    }

    /// Computes the accelerations by all laws in a state into a new array.
    pub(super) fn accelerate(&mut self, at: EvaluationTime, x: Combination, v: Combination) -> usize {
        let out = self.claim();
        let mut sum = std::mem::take(&mut self.scratch.slots[out]);
        let [mut stage_x, mut stage_v] = std::mem::take(&mut self.scratch.stage);
        let calls = self.calls();
        let looks = calls || self.depends_on_velocity();
        let mut state = Vec::new();
        {
            let x = match x.slot() {
                Some(slot) => self.array(slot),
                None => {
                    self.compute(&x, &mut stage_x);
                    &stage_x
                }
            };
            let v: &[Row] = match v.slot() {
                Some(slot) if !calls => self.array(slot),
                _ if looks => {
                    self.compute(&v, &mut stage_v);
                    &stage_v
                }
                // Not read.
                _ => self.rows.v,
            };
            if self.looks() {
                state.extend(self.broken(x));
                if looks && state.is_empty() {
                    state.extend(self.broken(v));
                }
            }
            self.coupling_forces(at.time, x, v, &mut sum);
            self.add_constants(v, &mut sum);
        }
        if calls {
            let x = match x.slot() {
                Some(slot) => self.array(slot),
                None => &stage_x,
            };
            self.call(at, x, &mut stage_v, &mut sum);
        }
        self.lock(&mut sum);
        self.count();
        self.look(|field| if state.is_empty() { field.broken(&sum).collect() } else { state });
        (self.scratch.slots[out], self.scratch.stage) = (sum, [stage_x, stage_v]);
        out
    }

    pub(super) fn shares(&self) -> Shares<'a> {
        let shares = self.threads.map(|threads| (threads, self.rows.shares));
        shares.filter(|(_, shares)| !shares.is_empty())
    }

    /// The forces of the coupling, N.
    pub(crate) fn coupling_forces(&self, time: f64, x: &[Row], v: &[Row], sum: &mut [Row]) {
        sum.fill([0.0; 4]);
        self.coupling.springs.pull(self.shares(), x, v, sum);
        if let Some(drag) = self.environment.shared.laws.drag {
            self.coupling.blow(drag, time, x, v, sum);
        }
        if let (true, Some(law)) = (self.coupling.attracts, self.environment.shared.attraction) {
            let sum = &mut sum[..self.coupling.movable];
            DirectSum { law, x, masses: &self.scratch.masses }.attract(self.environment.threads, sum);
        }
    }

    /// Turns forces into accelerations, and adds gravity and linear drag.
    pub(super) fn add_constants(&self, v: &[Row], sum: &mut [Row]) {
        let movable = self.coupling.movable;
        let classes = &self.scratch.classes;
        let w = &self.rows.w[..movable];
        Threads::share(self.threads, &mut sum[..movable], |first, sum| match classes.uniform() {
            Some(Class { constant, rate, .. }) => {
                let g = constant.to_array();
                let rows = sum.iter_mut().zip(&w[first..]).zip(&v[first..]);
                if rate == 0.0 {
                    rows.for_each(|((row, w), _)| to_acceleration(row, *w, g));
                } else {
                    rows.for_each(|((row, w), v)| {
                        to_acceleration(row, *w, [0, 1, 2].map(|i| g[i] - v[i] * rate));
                    });
                }
            }
            None => {
                for (row, (sum, w)) in (first..).zip(sum.iter_mut().zip(&w[first..])) {
                    let Class { constant, rate, .. } = *classes.of(row);
                    let (g, v) = (constant.to_array(), &v[row]);
                    to_acceleration(
                        sum,
                        *w,
                        [0, 1, 2].map(|i| if rate == 0.0 { g[i] } else { g[i] - v[i] * rate }),
                    );
                }
            }
        });
        sum[movable..].fill([0.0; 4]);
    }

    /// Rows on which a called law does not act, because air acts on their triangles instead.
    pub(super) fn in_sheets(&self, law: &dyn Law) -> &'a [u32] {
        match self.environment.shared.laws.drag {
            Some(drag) if std::ptr::addr_eq(std::ptr::from_ref(law), std::ptr::from_ref(drag)) => {
                &self.coupling.in_sheets
            }
            _ => &[],
        }
    }

    /// Adds the accelerations of the called laws; stores inverse masses beside the velocities.
    pub(super) fn call(&self, at: EvaluationTime, x: &[Row], v: &mut [Row], sum: &mut [Row]) {
        let movable = self.coupling.movable;
        v.iter_mut().zip(self.rows.w).for_each(|(row, w)| row[3] = *w);
        for law in self.environment.parameters.laws {
            let in_sheets = self.in_sheets(*law);
            // Laws skip rows of inverse mass 0.
            in_sheets.iter().for_each(|row| v[*row as usize][3] = 0.0);
            add_called(*law, at, &x[..movable], &v[..movable], &mut sum[..movable]);
            in_sheets.iter().for_each(|row| v[*row as usize][3] = self.rows.w[*row as usize]);
        }
        for row in self.rows.with_laws {
            let row = *row as usize;
            for law in self.options.row(row).laws {
                add_called(&**law, at, &x[row..=row], &v[row..=row], &mut sum[row..=row]);
            }
        }
    }

    pub(super) fn lock(&self, sum: &mut [Row]) {
        for row in self.rows.with_options {
            let row = *row as usize;
            let closed = self.class(row).closed;
            (0..3).filter(|axis| !is_open(closed, *axis)).for_each(|axis| sum[row][axis] = 0.0);
        }
    }

    /// Counts an evaluation of all laws.
    pub(super) fn count(&mut self) {
        let Self { coupling, environment, rows, options, with_gravity, statistics, .. } = self;
        let (movable, parameters) = (coupling.movable as u64, &environment.parameters);
        statistics.accelerations += movable;
        statistics.count_own("gravity", *with_gravity);
        environment.summed.iter().for_each(|law| statistics.count_own(law, movable));
        for law in parameters.laws {
            statistics.count_own(law.name(), movable);
        }
        for row in rows.with_laws {
            options.row(*row as usize).laws.iter().for_each(|law| statistics.count_own(law.name(), 1));
        }
        if !coupling.springs.is_empty() {
            statistics.count_own("springs", movable);
        }
        if coupling.attracts {
            statistics.count_own("mutual_gravity", movable);
        }
    }
}

/// Adds the accelerations of a law to `sum`. The rows of `v` are velocity and inverse mass.
fn add_called(law: &dyn Law, at: EvaluationTime, x: &[Row], v: &[Row], sum: &mut [Row]) {
    let chunks = x.chunks(BLOCK_BODIES).zip(v.chunks(BLOCK_BODIES)).zip(sum.chunks_mut(BLOCK_BODIES));
    for ((x, v), sum) in chunks {
        let [positions, velocities, mut block] = [x, v, sum].map(Block::<BLOCK_BODIES>::of);
        // Laws skip bodies of inverse mass 0; a block that is almost full is faster without such bodies.
        let filler = if x.len() > BLOCK_BODIES / 4 { v[0][3] } else { 0.0 };
        let mut inverse_masses = [filler; BLOCK_BODIES];
        inverse_masses.iter_mut().zip(v).for_each(|(w, row)| *w = row[3]);
        let bodies =
            BodyBlock { positions: &positions.0, velocities: &velocities.0, inverse_masses: &inverse_masses };
        law.accelerate(at, &bodies, &mut block.0);
        for (k, row) in sum.iter_mut().enumerate() {
            row[..3].copy_from_slice(&block.body(k));
        }
    }
}

/// Replaces a force F by `F w + g`, or by 0 for an immovable row.
#[inline(always)]
pub(super) fn to_acceleration(row: &mut Row, w: f64, g: [f64; 3]) {
    // A selection, not a factor: 0 times an infinite force would be NaN.
    let moves = w > 0.0;
    for axis in 0..3 {
        let a = row[axis] * w + g[axis];
        row[axis] = if moves { a } else { 0.0 };
    }
}
