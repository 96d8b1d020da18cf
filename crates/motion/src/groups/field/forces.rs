//! The accelerations of a group in a state.

use super::classes::Class;
use super::{GroupField, Layout, Push};
use crate::groups::combination::{APPLIED, Combination};
use crate::groups::coupling::is_open;
use crate::groups::rows::{Element, numbers, numbers_mut, row_of};
use crate::laws::{EvaluationTime, Law};
use crate::methods::Field as _;
use crate::simd::vectorize_many;
use crate::state::threads::Threads;

impl<'a, E: Layout> GroupField<'a, E> {
    pub(super) fn apply_pushes(&mut self) {
        self.pushed = !self.scratch.pushes.is_empty();
        if !self.pushed {
            return;
        }
        let mut pushes = std::mem::take(&mut self.scratch.pushes);
        let mut applied = std::mem::take(&mut self.scratch.slots[APPLIED]);
        applied.resize(self.rows.x.len());
        numbers_mut(&mut applied).fill(0.0);
        for Push { lane: group, row, force } in pushes.drain(..) {
            let (element, lane) = self.place(row, group);
            let w = self.rows.w[element * E::LANES + lane];
            if row < self.coupling.movable && w > 0.0 {
                let closed = self.class(row).closed;
                for (axis, force) in force.iter().enumerate().take(3) {
                    let a = if is_open(closed, axis) { force * w } else { 0.0 };
                    applied[element].axis_mut(axis)[lane] = a;
                }
            }
        }
        (self.scratch.pushes, self.scratch.slots[APPLIED]) = (pushes, applied);
    }

    /// Computes the accelerations by all laws in a state into a new array.
    pub(super) fn accelerate(
        &mut self,
        at: EvaluationTime,
        x: Combination,
        v: Combination,
    ) -> usize {
        let out = self.claim();
        let mut sum = std::mem::take(&mut self.scratch.slots[out]);
        let [mut stage_x, mut stage_v] = std::mem::take(&mut self.scratch.stage);
        let calls = self.calls();
        let looks = calls || self.depends_on_velocity();
        // Anchors that follow a motion are not where the method has them.
        let follows = !self.coupling.motions.is_empty();
        let own_x = x.slot().filter(|_| !follows);
        let mut state = Vec::new();
        {
            let own_v = v.slot().filter(|_| !calls && !follows);
            if own_x.is_none() {
                self.compute(&x, &mut stage_x);
            }
            if own_v.is_none() && looks {
                self.compute(&v, &mut stage_v);
            }
            self.follow_motions(at, &mut stage_x, &mut stage_v);
            let x = own_x.map_or(&*stage_x, |slot| self.array(slot));
            let v: &[E] = match own_v {
                Some(slot) => self.array(slot),
                None if looks => &stage_v,
                // Not read.
                None => self.rows.v,
            };
            if self.looks() {
                state.extend(self.broken(x));
                if looks && state.is_empty() {
                    state.extend(self.broken(v));
                }
            }
            E::pull(self, at.time, x, v, &mut sum);
            self.add_constants(v, &mut sum);
        }
        if calls {
            let x = own_x.map_or(&*stage_x, |slot| self.array(slot));
            E::call(self, at, x, &mut stage_v, &mut sum);
        }
        self.lock(&mut sum);
        self.evaluations += 1;
        self.look(|field| if state.is_empty() { field.broken(&sum).collect() } else { state });
        (self.scratch.slots[out], self.scratch.stage) = (sum, [stage_x, stage_v]);
        out
    }

    /// Puts the anchors that follow a motion where they are at a time, in arrays that may be too short if they are not read.
    pub(super) fn follow_motions(&self, at: EvaluationTime, x: &mut [E], v: &mut [E]) {
        for (row, motion) in &self.coupling.motions {
            // A group with such anchors is integrated alone.
            let (element, lane) = self.place(*row, 0);
            for (rows, state) in [&mut *x, &mut *v].into_iter().zip(motion.at(at)) {
                if let Some(element) = rows.get_mut(element) {
                    element.set_row(lane, row_of(state));
                }
            }
        }
    }

    /// Puts the anchors that follow a motion where they are at a time.
    pub(super) fn follow_motions_to(&mut self, at: EvaluationTime) {
        if !self.coupling.motions.is_empty() {
            let [x, v] = [&mut self.rows.x, &mut self.rows.v].map(std::mem::take);
            self.follow_motions(at, x, v);
            (self.rows.x, self.rows.v) = (x, v);
        }
    }

    /// Turns forces into accelerations, and adds gravity and linear drag.
    pub(super) fn add_constants(&self, v: &[E], sum: &mut [E]) {
        let movable = self.movable();
        let (w, classes, width) =
            (&self.rows.w[..movable * E::LANES], &self.scratch.classes, self.width);
        Threads::share(self.threads, &mut sum[..movable], |first, sum| {
            let (v, w) = (&v[first..], w[first * E::LANES..].chunks_exact(E::LANES));
            let rows = sum.iter_mut().zip(w).zip(v);
            match classes.uniform() {
                Some(class) => vectorize_many(
                    numbers(v).len(),
                    #[inline(always)]
                    || {
                        for ((sum, w), v) in rows {
                            to_acceleration(&class, sum, w, v);
                        }
                    },
                ),
                None => {
                    for (element, ((sum, w), v)) in (first..).zip(rows) {
                        to_acceleration(classes.of(element / width), sum, w, v);
                    }
                }
            }
        });
        numbers_mut(&mut sum[movable..]).fill(0.0);
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

    pub(super) fn lock(&self, sum: &mut [E]) {
        for row in self.rows.with_options {
            let row = *row as usize;
            let closed = self.class(row).closed;
            for axis in (0..3).filter(|axis| !is_open(closed, *axis)) {
                let elements = &mut sum[row * self.width..][..self.width];
                elements.iter_mut().for_each(|element| element.axis_mut(axis).fill(0.0));
            }
        }
    }

    /// Counts the evaluations of all laws in the tick and the iterations of solvers, except those of groups that failed:
    /// `broken` lists their rows that failed, each with its group.
    pub(super) fn count(&mut self, broken: &[(usize, usize)]) {
        let Self { coupling, environment, rows, options, with_gravity, statistics, .. } = self;
        let is_apart = |group: &usize| rows.apart.binary_search(group).is_ok();
        let counts = |group: &usize| !is_apart(group) && !broken.iter().any(|(_, of)| of == group);
        let groups = match (rows.apart, broken) {
            ([], []) => rows.groups,
            _ => (0..rows.groups).filter(counts).count(),
        };
        let not_cached = self.scratch.not_cached.iter().filter(|group| counts(group)).count();
        let evaluations = self.evaluations * groups as u64 + not_cached as u64;
        let iterations =
            self.scratch.iterations.iter().enumerate().filter(|(group, _)| counts(group));
        iterations.for_each(|(_, iterations)| statistics.iterations.add(*iterations));
        let movable = coupling.movable as u64 * evaluations;
        statistics.count_law("gravity", *with_gravity * evaluations);
        environment.summed.iter().for_each(|law| statistics.count_law(law, movable));
        statistics.count(movable, environment.parameters.laws.iter().copied());
        for row in rows.with_laws {
            let laws = options.row(*row as usize).laws.iter();
            laws.for_each(|law| statistics.count_law(law.name(), evaluations));
        }
        if !coupling.springs.is_empty() {
            statistics.count_law("springs", movable);
        }
        if coupling.attracts {
            statistics.count_law("mutual_gravity", movable);
        }
    }
}

/// Replaces a force F by `F w + g - c v`, or by 0 for an immovable row.
#[inline(always)]
fn to_acceleration<E: Element>(class: &Class, sum: &mut E, w: &[f64], v: &E) {
    let Class { constant, rate, .. } = class;
    for (axis, g) in constant.to_array().into_iter().enumerate() {
        let (sum, v) = (sum.axis_mut(axis), v.axis(axis));
        for k in 0..E::LANES {
            let g = if *rate == 0.0 { g } else { g - v[k] * *rate };
            let a = sum[k] * w[k] + g;
            // A selection, not a factor: 0 times an infinite force would be NaN.
            sum[k] = if w[k] > 0.0 { a } else { 0.0 };
        }
    }
}
