//! What single bodies ask for, and which rows are integrated alike.

use std::ops::Range;

use crate::groups::{Askers, RowAsks};
use crate::laws::Law;
use crate::methods::table::Method;
use crate::real::Real;
use crate::units::Scalar;

/// How a row is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Kind {
    /// Its own method.
    pub method: Option<Method>,
    /// Gravity passes it by.
    pub weightless: bool,
    /// Its place among the bodies that ask for something else.
    pub own: Option<usize>,
    /// It is in a group, frozen or dormant: not integrated on its own.
    pub apart: bool,
    /// When it is born, s since the scene's start, if it is in the coming tick.
    pub born: Option<Scalar>,
}

/// What a body asks for beside its method.
#[derive(Debug, Default)]
pub(super) struct Own<T: Real> {
    pub asks: RowAsks,
    pub laws: Vec<Box<dyn Law<T>>>,
    pub substeps: Option<u32>,
}

/// Rows that are integrated one after the other in the same way.
#[derive(Clone, Debug, Default)]
pub(super) struct Run {
    pub rows: Range<usize>,
    pub method: Option<Method>,
    pub weightless: bool,
    /// The place of the first of them among those that ask.
    pub own: Option<usize>,
    /// How many of them can move.
    pub movable: u64,
    /// When the only one of them is born, s since the scene's start, if it is in the coming tick.
    pub born: Option<Scalar>,
}

/// The rows by what they ask for.
#[derive(Debug)]
pub(super) struct Individuals<T: Real> {
    /// Of every row of a world; none where all bodies are alike.
    pub kinds: Vec<Kind>,
    pub owns: Vec<Own<T>>,
    pub runs: Vec<Run>,
    /// A row may have come to rest, or to move.
    pub outdated: bool,
}

impl<T: Real> Default for Individuals<T> {
    fn default() -> Self {
        Self { kinds: Vec::new(), owns: Vec::new(), runs: Vec::new(), outdated: true }
    }
}

impl<T: Real> Individuals<T> {
    /// Another body that asks for nothing.
    pub fn add(&mut self) {
        if !self.kinds.is_empty() {
            self.kinds.push(Kind::default());
        }
        self.outdated = true;
    }

    /// Finds what is integrated alike. Of a world, what is immovable and at rest is passed by.
    pub fn plan(&mut self, bodies: &[[T; 4]]) {
        if self.kinds.is_empty() {
            if self.runs.first().is_none_or(|run| run.rows.len() != bodies.len()) {
                let movable = bodies.iter().filter(|body| body[3] > T::ZERO).count() as u64;
                self.runs = vec![Run { rows: 0..bodies.len(), movable, ..Run::default() }];
            }
            return;
        }
        if !std::mem::take(&mut self.outdated) {
            return;
        }
        self.runs.clear();
        for (row, (kind, [x, y, z, w])) in self.kinds.iter().zip(bodies).enumerate() {
            let Kind { method, weightless, own, apart, born } = *kind;
            if apart || w.is_at_most(T::ZERO) && [*x, *y, *z] == [T::ZERO; 3] {
                continue;
            }
            match self.runs.last_mut() {
                Some(run)
                    if run.rows.end == row
                        && run.born.or(born).is_none()
                        && (run.method, run.weightless) == (method, weightless)
                        && run.own.map(|first| first + run.rows.len()) == own =>
                {
                    run.rows.end += 1;
                    run.movable += u64::from(*w > T::ZERO);
                }
                _ => {
                    let movable = u64::from(*w > T::ZERO);
                    self.runs.push(Run { rows: row..row + 1, method, weightless, own, movable, born });
                }
            }
        }
    }

    /// What was born in the tick goes on like all others.
    pub fn grow_up(&mut self) {
        for run in self.runs.iter().filter(|run| run.born.is_some()) {
            self.kinds[run.rows.start].born = None;
            self.outdated = true;
        }
    }

    fn own(&self, row: usize) -> Option<&Own<T>> {
        self.kinds.get(row).and_then(|kind| kind.own).map(|own| &self.owns[own])
    }
}

/// Looks up what the rows of a group ask for.
pub(super) struct OfRows<'a, T: Real> {
    pub rows: &'a [usize],
    pub individuals: &'a Individuals<T>,
}

impl<T: Real> Askers<T> for OfRows<'_, T> {
    fn asks(&self, row: usize) -> RowAsks {
        let row = self.rows[row];
        let gravity_off = self.individuals.kinds[row].weightless;
        self.individuals.own(row).map_or(RowAsks { gravity_off, ..RowAsks::default() }, |own| own.asks)
    }

    fn laws(&self, row: usize) -> (&[Box<dyn Law<T>>], u64) {
        (self.individuals.own(self.rows[row]).map_or(&[], |own| &own.laws), 0)
    }
}
