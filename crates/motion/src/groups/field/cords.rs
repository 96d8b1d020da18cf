//! Cords, springs that only pull, in a step of a group: which are slack, and when within the step that changes.
//!
//! Within a step a cord either acts as a spring (taut) or does not act (slack), so that a method meets no kink or jump inside
//! a step. A step in which a cord changes is repeated up to the time of the change; the rest is a step of its own.

use smallvec::SmallVec;

use super::{GroupField, Layout};
use crate::groups::combination::{Combination, FIRST};
use crate::groups::pull::{SpringRow, Springs, pulls};
use crate::kernels::cubic::Cubic;
use crate::kernels::record::{Recorder, vector};
use crate::state::springs::Elastic;
use crate::units::{Scalar, Vector};

/// Most changes per tick that end a step; later ones take effect in the next step.
const MOST: u32 = 256;
/// A change within this fraction of a step from one of its ends counts as at that end.
const NEAR: Scalar = 1e-9;

/// Equal parts of a step or tick, as (start, end) in fractions of it, at whose ends cords are checked.
pub(crate) fn equal_parts() -> impl Iterator<Item = (f64, f64)> {
    const PARTS: u32 = 8;
    (0..PARTS).map(|i| (f64::from(i) / f64::from(PARTS), f64::from(i + 1) / f64::from(PARTS)))
}

/// Finds by bisection where between `from` and `to` the condition `holds` ends. It must hold at `from` and not at `to`.
pub(crate) fn bisect_end(holds: impl Fn(f64) -> bool, mut from: f64, mut to: f64) -> f64 {
    loop {
        let middle = 0.5 * (from + to);
        if middle <= from || middle >= to || to - from < 1e-14 {
            return to;
        }
        if holds(middle) { from = middle } else { to = middle }
    }
}

/// The cords of a group in a tick.
#[derive(Debug, Default)]
pub(super) struct Cords {
    /// The springs of the group, with those of slack cords loose.
    springs: Springs,
    /// Whether each cord is taut in this step.
    taut: Vec<bool>,
    /// Whether each cord was taut in the previous step.
    before: Vec<bool>,
    /// Indices of the cords that change at the start of the next step.
    changing: Vec<usize>,
    /// Indices of the cords that changed at the start of this step.
    changed: Vec<usize>,
    /// Whether the next step starts at the same time as this one.
    again: bool,
    /// Changes that ended a step in this tick.
    changes: u32,
    /// The record at the start of the step, which is restored if the step is repeated.
    record: Option<Recorder>,
    /// Whether no failed row had been found at the start of the step.
    found_none: bool,
}

impl Cords {
    /// Sets taut cords to their springs in `all` and loosens slack ones, as in this step or, with `before`, as in the previous
    /// one.
    fn tune(&mut self, all: &Springs, before: bool) {
        let taut = if before { &self.before } else { &self.taut };
        for (number, taut) in all.cords().iter().zip(taut) {
            let elastic = if *taut { all.get(*number).elastic } else { Elastic::default() };
            self.springs.tune(*number, &elastic);
        }
    }
}

/// The motion in a step of the second end of a cord relative to the first.
struct Way {
    elastic: Elastic,
    cubic: Cubic,
    h: Scalar,
}

impl Way {
    /// Whether the cord pulls at the fraction `s` of the step.
    fn is_taut(&self, s: Scalar) -> bool {
        let [d, u] = self.cubic.at(s, self.h * s);
        pulls(&self.elastic, d, u)
    }

    /// The fraction of the step after which the cord first differs from `taut`.
    fn change(&self, taut: bool) -> Option<Scalar> {
        let is_as_before = |s| self.is_taut(s) == taut;
        let (before, after) = equal_parts().find(|(_, after)| !is_as_before(*after))?;
        Some(bisect_end(is_as_before, before, after))
    }
}

impl<E: Layout> GroupField<'_, E> {
    fn has_cords(&self) -> bool {
        !self.coupling.springs.cords().is_empty()
    }

    /// The springs as they act in this step.
    pub(super) fn springs(&self) -> &Springs {
        if self.has_cords() { &self.scratch.cords.springs } else { &self.coupling.springs }
    }

    /// Begins a tick.
    pub(super) fn begin_cords(&mut self) {
        if self.has_cords() {
            let (springs, cords) = (&self.coupling.springs, &mut self.scratch.cords);
            cords.springs.copy(springs);
            cords.changing.clear();
            (cords.again, cords.changes, cords.record) = (false, 0, None);
            cords.taut.clear();
            cords.taut.resize(springs.cords().len(), false);
            // Laws are called before the first step begins, too.
            self.begin_step_of_cords();
        }
    }

    /// Begins a step: cords that ended the last step change; all others are taut or slack by the state at the start.
    pub(super) fn begin_step_of_cords(&mut self) {
        if !self.has_cords() {
            return;
        }
        let mut cords = std::mem::take(&mut self.scratch.cords);
        let (x, v) = (&*self.rows.x, &*self.rows.v);
        if !cords.again {
            cords.before.clone_from(&cords.taut);
            cords.changed.clear();
        }
        for (i, number) in self.coupling.springs.cords().iter().enumerate() {
            if cords.changing.contains(&i) {
                cords.taut[i] = !cords.taut[i];
            } else if !cords.changed.contains(&i) {
                let SpringRow { ends, elastic } = self.coupling.springs.get(*number);
                let [d, u] = self.apart(ends, x, v);
                cords.taut[i] = pulls(&elastic, d, u);
            }
        }
        let Cords { changed, changing, .. } = &mut cords;
        changed.append(changing);
        cords.again = false;
        cords.found_none = self.found.is_empty();
        cords.record.clone_from(&self.statistics.record);
        cords.tune(&self.coupling.springs, false);
        self.scratch.cords = cords;
    }

    /// The length of a step that would end in (`x`, `v`) up to the first change of a cord, s; the step is then undone. `None`
    /// if no cord changes, or only at the end of the step.
    pub(super) fn change_of_cords(&mut self, x: Combination, v: Combination) -> Option<Scalar> {
        if !self.has_cords() || self.scratch.cords.changes >= MOST {
            return None;
        }
        let h = self.segment.length;
        let [mut to_x, mut to_v] = std::mem::take(&mut self.scratch.stage);
        self.compute(&x, &mut to_x);
        self.compute(&v, &mut to_v);
        self.follow_motions(self.end(), &mut to_x, &mut to_v);
        let cords = &self.scratch.cords;
        let change = |(i, number): (usize, &u32)| {
            let SpringRow { ends, elastic } = self.coupling.springs.get(*number);
            let from = self.apart(ends, self.rows.x, self.rows.v);
            let to = self.apart(ends, &to_x, &to_v);
            // A state that is not finite fails anyway.
            if !(to[0] + to[1]).is_finite() {
                return None;
            }
            let change =
                Way { elastic, cubic: Cubic::new(from, to, h), h }.change(cords.taut[i])?;
            // Once per time: a cord that only touches the threshold must not change back and forth.
            (change > NEAR || !cords.changed.contains(&i)).then_some((i, change))
        };
        let changes: SmallVec<[(usize, Scalar); 8]> =
            self.coupling.springs.cords().iter().enumerate().filter_map(change).collect();
        self.scratch.stage = [to_x, to_v];
        let first = changes.iter().map(|(_, s)| *s).min_by(Scalar::total_cmp)?;
        if first > 1.0 - NEAR {
            return None;
        }
        let cords = &mut self.scratch.cords;
        cords.changing.extend(changes.iter().filter(|(_, s)| *s <= first + NEAR).map(|(i, _)| *i));
        cords.changes += 1;
        cords.again = first <= NEAR;
        self.statistics.record.clone_from(&cords.record);
        self.next = FIRST;
        if cords.found_none {
            self.found.clear();
        }
        Some(if first > NEAR { first * h } else { 0.0 })
    }

    /// Calls `of` with the cords as they were before they changed at the start of this step.
    pub(super) fn before_change_of_cords<T>(&mut self, of: impl FnOnce(&mut Self) -> T) -> T {
        if self.has_cords() {
            self.scratch.cords.tune(&self.coupling.springs, true);
        }
        let done = of(self);
        if self.has_cords() {
            self.scratch.cords.tune(&self.coupling.springs, false);
        }
        done
    }

    /// Position, m, and velocity, m/s, of the second end of a spring relative to the first.
    fn apart(&self, ends: [u32; 2], x: &[E], v: &[E]) -> [Vector; 2] {
        let row = |rows: &[E], row: u32| {
            let (element, lane) = self.place(row as usize, 0);
            vector(&rows[element].row(lane))
        };
        [x, v].map(|rows| row(rows, ends[1]) - row(rows, ends[0]))
    }
}
