//! The options of single bodies, and runs of rows that are integrated alike.

use std::ops::Range;

use crate::kernels::{BodyOptions, RowOptions};
use crate::laws::Law;
use crate::methods::table::Method;
use crate::units::Scalar;

/// How a row is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Kind {
    /// Its own method.
    pub method: Option<Method>,
    /// Whether gravity does not act on it.
    pub gravity_off: bool,
    /// Its index among the bodies with other options.
    pub own: Option<usize>,
    /// Whether it is in a group, quarantined or dormant: not integrated on its own.
    pub apart: bool,
    /// Time of its birth in the coming tick, s since the scene's start, if it is born then.
    pub born: Option<Scalar>,
}

/// The options of a body.
#[derive(Debug)]
pub(super) struct OwnOptions {
    /// The options except laws.
    pub options: BodyOptions<'static>,
    pub laws: Vec<Box<dyn Law>>,
}

impl OwnOptions {
    pub fn options(&self) -> BodyOptions<'_> {
        BodyOptions { laws: &self.laws, ..self.options }
    }
}

/// A run of consecutive rows that are integrated alike. A row that is born in the coming tick is a run of its own.
#[derive(Clone, Debug, Default)]
pub(super) struct Run {
    pub rows: Range<usize>,
    /// The kind of the first row. The kinds of the other rows differ only in `own`, which increases by 1 per row.
    pub kind: Kind,
}

/// How all rows are integrated.
#[derive(Debug)]
pub(super) struct Individuals {
    /// The kind of every row of a world; empty if all bodies are alike.
    pub kinds: Vec<Kind>,
    pub own_options: Vec<OwnOptions>,
    pub runs: Vec<Run>,
    /// Whether the runs must be found again: a row may have come to rest, or started to move.
    pub outdated: bool,
}

impl Default for Individuals {
    fn default() -> Self {
        Self { kinds: Vec::new(), own_options: Vec::new(), runs: Vec::new(), outdated: true }
    }
}

impl Individuals {
    /// Adds a body without options.
    pub fn add(&mut self) {
        if !self.kinds.is_empty() {
            self.kinds.push(Kind::default());
        }
        self.outdated = true;
    }

    /// Finds the runs. Skips bodies of a world that are immovable and at rest.
    pub fn plan(&mut self, bodies: &[[f64; 4]]) {
        if self.kinds.is_empty() {
            if self.runs.first().is_none_or(|run| run.rows.len() != bodies.len()) {
                self.runs = vec![Run { rows: 0..bodies.len(), ..Run::default() }];
            }
            return;
        }
        if !std::mem::take(&mut self.outdated) {
            return;
        }
        self.runs.clear();
        for (row, (kind, [x, y, z, w])) in self.kinds.iter().zip(bodies).enumerate() {
            if kind.apart || *w <= 0.0 && [*x, *y, *z] == [0.0; 3] {
                continue;
            }
            let continues = |run: &Run| {
                let own = run.kind.own.map(|first| first + run.rows.len());
                run.rows.end == row && kind.born.is_none() && *kind == Kind { own, ..run.kind }
            };
            match self.runs.last_mut().filter(|run| continues(run)) {
                Some(run) => run.rows.end += 1,
                None => self.runs.push(Run { rows: row..row + 1, kind: *kind }),
            }
        }
    }

    /// Makes the births of the tick ordinary rows.
    pub fn end_births(&mut self) {
        for run in self.runs.iter().filter(|run| run.kind.born.is_some()) {
            self.kinds[run.rows.start].born = None;
            self.outdated = true;
        }
    }
}

impl RowOptions for Individuals {
    fn row(&self, row: usize) -> BodyOptions<'_> {
        let Kind { gravity_off, own, .. } = self.kinds[row];
        own.map_or(BodyOptions { gravity_off, ..BodyOptions::NONE }, |own| {
            self.own_options[own].options()
        })
    }
}

/// The options of the rows of a run.
impl RowOptions for &[OwnOptions] {
    fn row(&self, row: usize) -> BodyOptions<'_> {
        self[row].options()
    }
}
