//! Kernels: methods on blocks of rows, whose new states are checked before they are stored.
//!
//! The row of a body is four lanes, (velocity, inverse mass), so that one body is one register; constants leave the
//! last lane unchanged. The whole tick of a block, with all substeps and stages, is computed before the next block. A
//! row that would turn non-finite keeps its state and is refused. No fused multiply-add is used: it would change the
//! bits.
//!
//! There are two kernels. The affine kernel handles gravity, linear drag, damping and applied forces, a body per
//! register. The kernel of blocks handles everything: laws that are called, and the options of single bodies. Both use
//! the vector instructions of the machine, chosen at run time, with the same bits on all machines.

mod affine;
mod block;
mod block_field;
mod blocks;
pub(crate) mod cubic;
mod drive;
pub(crate) mod evaluations;
mod field;
mod lanes;
mod method_state;
mod options;
pub(crate) mod record;

use std::ops::Range;

use smallvec::SmallVec;

use crate::kernels::evaluations::Iterations;
use crate::kernels::record::Recorder;
use crate::laws::damping::{Damping, Decay};
use crate::laws::tick_times::{Segment, Segments, TickTimes};
use crate::laws::{Affine, Law};
use crate::methods::{Integrator, Traits};
use crate::state::range::{Bounds, Breach};
use crate::units::Scalar;
use crate::units::Vector;

pub(crate) use block::{Block, load_axes, store_axes};

pub(crate) use drive::{TickField, drive};
pub(crate) use field::restrain;
pub(crate) use method_state::MethodStateRows;
pub(crate) use options::{BodyOptions, OfRows, RowOptions};

/// Rows of a block, computed together before the first of them is stored.
pub(crate) const BLOCK: usize = 4;

type Row = [f64; 4];

/// The parameters of a tick of one method, computed from the environment.
#[derive(Clone, Copy)]
pub(crate) struct TickParameters<'a> {
    /// Acceleration by the constant laws, m/s².
    pub gravity: Vector,
    /// Rate of linear drag of the laws, 1/s.
    pub drag: f64,
    /// Total rate of linear drag, 1/s: includes exact damping where the method has damping around its ticks.
    pub rate: f64,
    /// Damping, for segments of other lengths.
    pub damping: Option<Damping>,
    /// The factors of damping: of a substep if the method damps inside its steps, otherwise of the tick.
    pub decay: Decay,
    /// Laws that are called.
    pub laws: &'a [&'a dyn Law],
    /// Changes whenever one of these laws changes.
    pub epoch: u64,
    /// The times of the tick.
    pub times: TickTimes,
    /// Bounds of the states that are stored.
    pub bounds: Bounds,
    /// The constants of the method.
    pub traits: Traits,
}

impl<'a> TickParameters<'a> {
    /// The parameters of a tick of a method, without bounds.
    pub fn new(
        traits: Traits,
        affine: Affine,
        damping: Option<Damping>,
        laws: &'a [&'a dyn Law],
        epoch: u64,
        times: TickTimes,
    ) -> Self {
        let decay = Decay::none(times.substep());
        let Affine { constant: gravity, rate: drag } = affine;
        let parameters = Self {
            gravity,
            drag,
            rate: drag,
            damping: None,
            decay,
            laws,
            epoch,
            times,
            bounds: Bounds::FINITE,
            traits,
        };
        parameters.damped(damping)
    }

    /// The same parameters with `bounds`.
    #[must_use]
    pub const fn within(mut self, bounds: Bounds) -> Self {
        self.bounds = bounds;
        self
    }

    /// The same parameters with other damping.
    #[must_use]
    pub fn damped(mut self, damping: Option<Damping>) -> Self {
        self.damping = damping;
        (self.decay, self.rate) = match damping {
            None => (Decay::none(self.times.substep()), self.drag),
            Some(damping) if self.traits.damps_inside => {
                (damping.factors(self.times.substep()), self.drag)
            }
            Some(damping) => {
                let (decay, rate) = damping.factors_around_tick(self.times.tick);
                (decay, self.drag + rate)
            }
        };
        if !self.traits.passes_time {
            self.times.substeps = 1;
            self.decay = Decay::none(self.times.tick);
        }
        self
    }

    /// The same parameters for a body that is born at `time`, s: its tick is the rest of the tick.
    #[must_use]
    pub fn since(&self, time: Scalar) -> Self {
        Self { times: self.times.since(time), ..*self }.damped(self.damping)
    }

    /// The factors of damping in a segment; those around a tick are the same in every segment.
    fn decay_in(&self, segment: Segment) -> Decay {
        if !self.traits.damps_inside || segment.length == self.times.substep() {
            return self.decay;
        }
        self.damping.map_or(Decay::none(segment.length), |damping| damping.factors(segment.length))
    }

    /// The laws that are called for bodies with these own laws.
    fn called<'l>(
        &'l self,
        own: impl Iterator<Item = &'l Box<dyn Law>>,
    ) -> impl Iterator<Item = &'l dyn Law> {
        self.laws.iter().copied().chain(own.map(|law| &**law))
    }

    /// The segments of the tick for bodies with these own laws, split at `more` times, s, too.
    pub fn segments<'l>(
        &'l self,
        own: impl Iterator<Item = &'l Box<dyn Law>>,
        more: impl Iterator<Item = &'l Scalar>,
    ) -> Segments {
        let of_laws = self.called(own).flat_map(|law| law.discontinuities());
        self.times.segments(&mut of_laws.chain(more))
    }

    /// Whether a called law depends on the velocity, for bodies with these own laws.
    pub fn calls_with_velocity<'l>(&'l self, own: impl Iterator<Item = &'l Box<dyn Law>>) -> bool {
        self.called(own).any(|law| law.depends_on_velocity())
    }
}

/// Counts by name.
pub(crate) type Counts = SmallVec<[(&'static str, u64); 8]>;

/// Adds `more` to the count of `name`, which is listed once it is not 0.
pub(crate) fn count(counts: &mut Counts, name: &'static str, more: u64) {
    // Names are constants: most are found by their place in memory.
    match counts.iter_mut().find(|(known, _)| std::ptr::eq(*known, name) || *known == name) {
        Some((_, count)) => *count += more,
        None if more > 0 => counts.push((name, more)),
        None => {}
    }
}

/// Statistics of a tick, counted where rows are integrated.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct StepStatistics {
    /// Evaluations of the acceleration of one body by all laws.
    pub accelerations: u64,
    /// Evaluations of the called laws, by name.
    pub laws: Counts,
    /// Iterations of implicit steps.
    pub iterations: Iterations,
    /// Records of every row, if the tick has a ledger.
    pub record: Option<Recorder>,
}

impl StepStatistics {
    pub fn count_law(&mut self, name: &'static str, rows: u64) {
        count(&mut self.laws, name, rows);
    }

    /// Counts an evaluation of `rows` rows in which the laws `called` were called.
    pub fn count<'l>(&mut self, rows: u64, called: impl Iterator<Item = &'l dyn Law>) {
        self.accelerations += rows;
        called.for_each(|law| self.count_law(law.name(), rows));
    }

    /// Adds the counts of `other`.
    pub fn add(&mut self, other: &Self) {
        self.accelerations += other.accelerations;
        other.laws.iter().for_each(|(name, calls)| self.count_law(name, *calls));
        self.iterations.add(other.iterations);
    }
}

/// Bodies that are integrated together: the rows of a table, or a single body.
pub(crate) struct Batch<'a> {
    /// x, y, z of every body.
    pub positions: &'a mut [[f64; 3]],
    /// (velocity, inverse mass) of every body.
    pub bodies: &'a mut [Row],
    /// The applied forces, if any body is pushed.
    pub applied: Option<AppliedForces<'a>>,
    /// The method state of every body.
    pub method_state: MethodStateRows<'a>,
}

impl<'a> Batch<'a> {
    /// Some of the rows.
    pub fn part(&mut self, rows: Range<usize>) -> Batch<'_> {
        Batch {
            positions: &mut self.positions[rows.clone()],
            bodies: &mut self.bodies[rows.clone()],
            applied: self.applied.map(|applied| applied.part(rows.clone())),
            method_state: self.method_state.part(rows),
        }
    }

    /// Splits the first `rows` off.
    pub fn split_at(self, rows: usize) -> (Self, Self) {
        let Self { positions, bodies, applied, method_state } = self;
        let of_rows = |rows| applied.map(|applied| applied.part(rows));
        let applied = (of_rows(0..rows), of_rows(rows..bodies.len()));
        let (positions, bodies) = (positions.split_at_mut(rows), bodies.split_at_mut(rows));
        let method_state = method_state.split_at(rows);
        let batch = |positions, bodies, applied, method_state| Self {
            positions,
            bodies,
            applied,
            method_state,
        };
        (
            batch(positions.0, bodies.0, applied.0, method_state.0),
            batch(positions.1, bodies.1, applied.1, method_state.1),
        )
    }
}

/// The applied forces of a batch and the rows that are pushed; the forces of all other rows are zero and are not
/// read.
#[derive(Clone, Copy)]
pub(crate) struct AppliedForces<'a> {
    /// The force on every body, N.
    pub forces: &'a [[f64; 3]],
    /// Table and row of the pushed bodies, rows ascending.
    pub rows: &'a [(usize, usize)],
    /// The row of the table at which the batch begins.
    pub offset: usize,
}

impl AppliedForces<'_> {
    /// The forces of some rows.
    pub fn part(&self, rows: Range<usize>) -> Self {
        let before = |pushed: &[(usize, usize)], row: usize| {
            pushed.partition_point(|(_, pushed)| *pushed < self.offset + row)
        };
        let pushed = &self.rows[before(self.rows, rows.start)..];
        // At most as many are pushed as there are rows: this shortens the second search.
        let pushed = &pushed[..pushed.len().min(rows.len())];
        Self {
            forces: &self.forces[rows.clone()],
            rows: &pushed[..before(pushed, rows.end)],
            offset: self.offset + rows.start,
        }
    }
}

/// Called with a row that was refused, and why.
pub(crate) type Refuse<'a> = &'a mut dyn FnMut(usize, Breach);

/// A method compiled for batches of bodies. The code around it is compiled once for all methods.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernel {
    pub traits: Traits,
    /// Integrates a tick of some rows of a batch. The options are `None` if no row has any.
    pub integrate: fn(
        &TickParameters<'_>,
        &mut Batch<'_>,
        Range<usize>,
        Option<&dyn RowOptions>,
        &mut StepStatistics,
        Refuse<'_>,
    ),
}

impl Kernel {
    /// The kernel of `M`.
    pub const fn of<M: Integrator>() -> Self {
        Self { traits: Traits::of::<M>(), integrate: integrate_batch::<M> }
    }

    /// Integrates a tick of one row with these options, or returns why it was refused.
    pub fn integrate_row(
        self,
        parameters: &TickParameters<'_>,
        options: BodyOptions<'_>,
        batch: &mut Batch<'_>,
        row: usize,
        statistics: &mut StepStatistics,
    ) -> Result<(), Breach> {
        let mut outcome = Ok(());
        let refuse = &mut |_, breach| outcome = Err(breach);
        (self.integrate)(parameters, batch, row..row + 1, Some(&options), statistics, refuse);
        outcome
    }
}

/// Integrates a tick of some rows of a batch. Consecutive rows whose options differ only in own laws are integrated together.
fn integrate_batch<M: Integrator>(
    parameters: &TickParameters<'_>,
    batch: &mut Batch<'_>,
    rows: Range<usize>,
    options: Option<&dyn RowOptions>,
    statistics: &mut StepStatistics,
    refuse: Refuse<'_>,
) {
    assert_eq!(batch.positions.len(), batch.bodies.len(), "a position for every body");
    if let Some(options) = options {
        let mut start = rows.start;
        while start < rows.end {
            let first = options.row(start);
            let mut own = *parameters;
            if let Some(substeps) = first.substeps {
                own.times.substeps = substeps;
            }
            let own = own.damped(first.damping(parameters.damping));
            let joins_first = |row: &usize| {
                let next = options.row(*row);
                first.is_like(&next) && !next.jumps(&own.times)
            };
            // A solver takes one body at a time.
            let alone = M::SOLVES || first.jumps(&own.times);
            let more =
                if alone { 0 } else { (start + 1..rows.end).take_while(joins_first).count() };
            let alike = start..start + 1 + more;
            start = alike.end;
            let own_laws = (more > 0).then_some(options);
            blocks::run::<M>(&own, &first, own_laws, batch, alike, statistics, refuse);
        }
        return;
    }
    let TickParameters { laws, decay, times, .. } = parameters;
    // Linear drag and damping in the same step: only the kernel of blocks does that.
    let drags_and_damps = parameters.rate != 0.0 && parameters.damping.is_some() && M::DAMPS_INSIDE;
    if !laws.is_empty() || drags_and_damps || !M::PASSES_TIME {
        blocks::run::<M>(parameters, &BodyOptions::NONE, None, batch, rows, statistics, refuse);
        return;
    }
    // The affine kernel does not know the first and the last substep, where factors around a tick act.
    let factors = decay.before_move.is_some() || decay.after_move.is_some();
    let around = !M::DAMPS_INSIDE && times.substeps > 1 && factors;
    let in_registers = !around && statistics.record.is_none();
    let done = in_registers.then(|| affine::run::<M>(parameters, batch, rows.clone(), refuse));
    match done.flatten() {
        Some(evaluations) => statistics.accelerations += evaluations,
        // The kernel of blocks gives the same bits.
        None => {
            blocks::run::<M>(parameters, &BodyOptions::NONE, None, batch, rows, statistics, refuse);
        }
    }
}
