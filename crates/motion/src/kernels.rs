//! Methods on blocks of rows: the arithmetic of a tick, checked before it is committed.
//!
//! A row of a body is four lanes, (velocity, inverse mass), and every update is written on four lanes whose
//! constants leave the last one alone, so that one body is one register. The whole tick of a block, every
//! substep and stage, is computed before the next block is looked at; a row that would turn non-finite is left
//! as it was and refused. There is no fused multiply-add: it would change the bits.
//!
//! Two kernels do it. The affine one knows gravity, linear drag, damping and applied forces, and is compiled
//! for the vector instructions of the machine, chosen at run time, with the same bits on all of them. The
//! calling one knows everything: laws that are called and what single bodies ask for.

mod affine;
mod calling;
mod compensated;
mod drive;
pub(crate) mod evaluations;
mod field;
mod lanes;
mod method_state;
mod options;
pub(crate) mod record;

use std::ops::Range;

use smallvec::SmallVec;

use crate::kernels::record::Recorder;
use crate::laws::damping::{Damping, Decay};
use crate::laws::tick_times::{Segment, Segments, TickTimes};
use crate::laws::{Affine, Law};
use crate::methods::Integrator;
use crate::real::Real;
use crate::state::range::{Bounds, Breach};
use crate::units::Scalar;

pub(crate) use affine::LEVEL;
pub(crate) use calling::{Plain, Sums};
pub(crate) use compensated::{Residues, add_compensated};
pub(crate) use drive::{TickField, drive};
pub(crate) use field::restrain;
pub(crate) use method_state::MethodStateRows;
pub(crate) use options::{BodyOptions, RowOptions};

/// Rows that are computed before the first of them is stored.
pub(crate) const BLOCK: usize = 4;

type Row<T> = [T; 4];

/// What acts on every body of a table in a tick.
#[derive(Clone, Copy)]
pub(crate) struct Terms<'a, T: Real> {
    /// Acceleration by the constant laws, m/s².
    pub gravity: T::Vector,
    /// Rate of linear drag by the laws, 1/s.
    pub drag: T,
    /// Rate of linear drag altogether, 1/s: exact damping is in it where the method has damping around its ticks.
    pub rate: T,
    /// Damping, for steps of other lengths.
    pub damping: Option<Damping>,
    /// What damping does in a step or, around it, in a tick.
    pub decay: Decay<T>,
    /// Laws that have to be called.
    pub laws: &'a [&'a dyn Law<T>],
    /// Changes whenever one of these laws does.
    pub epoch: u64,
    /// The times of the tick.
    pub times: TickTimes,
    /// What the state that is stored may be at most.
    pub bounds: Bounds<T>,
}

impl<'a, T: Real> Terms<'a, T> {
    /// What is taken from the drag and damping that are in force: for a method that has damping inside its steps
    /// or around its ticks.
    pub fn new<M: Integrator>(
        affine: Affine<T>,
        damping: Option<Damping>,
        laws: &'a [&'a dyn Law<T>],
        epoch: u64,
        times: TickTimes,
    ) -> Self {
        let decay = Decay::none(times.substep());
        let Affine { constant: gravity, rate: drag } = affine;
        let bounds = Bounds::FINITE;
        let terms = Self { gravity, drag, rate: drag, damping: None, decay, laws, epoch, times, bounds };
        terms.damped::<M>(damping)
    }

    /// The same for states that stay within `bounds`.
    #[must_use]
    pub const fn within(mut self, bounds: Bounds<T>) -> Self {
        self.bounds = bounds;
        self
    }

    /// The same with other damping.
    #[must_use]
    pub fn damped<M: Integrator>(mut self, damping: Option<Damping>) -> Self {
        self.damping = damping;
        (self.decay, self.rate) = match damping {
            None => (Decay::none(self.times.substep()), self.drag),
            Some(damping) if M::DAMPS_INSIDE => (damping.factors(self.times.substep()), self.drag),
            Some(damping) => {
                let (decay, rate) = damping.factors_around_tick(T::of(self.times.tick));
                (decay, self.drag + rate)
            }
        };
        if !M::PASSES_TIME {
            self.times.substeps = 1;
            self.decay = Decay::none(T::of(self.times.tick));
        }
        self
    }

    /// The same for a body that is born at `time`, s: what is left of the tick is a tick.
    #[must_use]
    pub fn since<M: Integrator>(&self, time: Scalar) -> Self {
        Self { times: self.times.since(time), ..*self }.damped::<M>(self.damping)
    }

    /// Accelerations of a body in a tick of `M` in which no law is called.
    pub fn evaluations<M: Integrator>(&self) -> u64 {
        let claims = M::METHOD.claims();
        let of_a_step = match self.rate == T::ZERO {
            true => claims.evaluations,
            false => claims.evaluations_with_velocity_laws,
        };
        if M::PASSES_TIME { u64::from(of_a_step) * u64::from(self.times.substeps) } else { 0 }
    }

    /// What damping does in a segment; around a tick it is the same in every segment.
    fn decay_in<M: Integrator>(&self, segment: Segment<T>) -> Decay<T> {
        if !M::DAMPS_INSIDE || segment.length == self.times.substep() {
            return self.decay;
        }
        self.damping.map_or(Decay::none(segment.length), |damping| damping.factors(segment.length))
    }

    /// The segments of the tick for a body with laws of its own.
    fn segments(&self, own: &[Box<dyn Law<T>>]) -> Segments {
        let discontinuities = self.laws.iter().flat_map(|law| law.discontinuities());
        self.times.segments(&mut discontinuities.chain(own.iter().flat_map(|law| law.discontinuities())))
    }

    fn calls_with_velocity(&self, own: &[Box<dyn Law<T>>]) -> bool {
        self.laws.iter().any(|law| law.depends_on_velocity())
            || own.iter().any(|law| law.depends_on_velocity())
    }
}

/// A count a name.
pub(crate) type Counts = SmallVec<[(&'static str, u64); 8]>;

/// Adds `more` to the count of that name, which is first heard of when it is not 0.
pub(crate) fn count(counts: &mut Counts, name: &'static str, more: u64) {
    match counts.iter_mut().find(|(known, _)| *known == name) {
        Some((_, count)) => *count += more,
        None if more > 0 => counts.push((name, more)),
        None => {}
    }
}

/// What a tick took: counted where laws are called, so that it is exact.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct StepStatistics {
    /// Accelerations of one body, by all laws together.
    pub accelerations: u64,
    /// Evaluations of the laws of all bodies, one number a law of [`Terms::laws`].
    pub calls: SmallVec<[u64; 8]>,
    /// Evaluations of the laws of single bodies, by name.
    pub own: Counts,
    /// Newton iterations of implicit steps.
    pub newton_iterations: u64,
    /// Implicit steps that did not converge.
    pub unconverged: u64,
    /// Iterations of conjugate gradients.
    pub cg_iterations: u64,
    /// What is written down of every row, if it is.
    pub record: Option<Recorder>,
}

impl StepStatistics {
    pub(crate) fn count_own(&mut self, name: &'static str, rows: u64) {
        count(&mut self.own, name, rows);
    }

    /// Takes the counts of another account into this one.
    pub fn add(&mut self, other: &Self) {
        self.accelerations += other.accelerations;
        self.calls.resize(self.calls.len().max(other.calls.len()), 0);
        let calls = self.calls.iter_mut().zip(&other.calls);
        calls.for_each(|(sum, calls)| *sum += calls);
        other.own.iter().for_each(|(name, calls)| self.count_own(name, *calls));
        self.newton_iterations += other.newton_iterations;
        self.unconverged += other.unconverged;
        self.cg_iterations += other.cg_iterations;
    }
}

/// Bodies that are integrated together: rows of a table or of plain arrays, or a single one.
pub(crate) struct Batch<'a, T: Real> {
    /// x, y, z of every body.
    pub positions: &'a mut [[T; 3]],
    /// (velocity, inverse mass) of every body.
    pub bodies: &'a mut [Row<T>],
    /// Their forces, if any of them is pushed.
    pub applied: Option<Applied<'a, T>>,
    /// What the method keeps of them.
    pub method_state: MethodStateRows<'a, T>,
}

impl<'a, T: Real> Batch<'a, T> {
    /// Some of the rows.
    pub fn part(&mut self, rows: Range<usize>) -> Batch<'_, T> {
        Batch {
            positions: &mut self.positions[rows.clone()],
            bodies: &mut self.bodies[rows.clone()],
            applied: self.applied.map(|applied| applied.part(rows.clone())),
            method_state: self.method_state.part(rows),
        }
    }

    /// Splits the first `rows` off.
    pub fn split_at(self, rows: usize) -> (Self, Self) {
        let (first, others) = (0..rows, rows..self.bodies.len());
        let positions = self.positions.split_at_mut(rows);
        let bodies = self.bodies.split_at_mut(rows);
        let method_state = self.method_state.split_at(rows);
        let applied = |rows: Range<usize>| self.applied.map(|applied| applied.part(rows));
        (
            Self {
                positions: positions.0,
                bodies: bodies.0,
                applied: applied(first),
                method_state: method_state.0,
            },
            Self {
                positions: positions.1,
                bodies: bodies.1,
                applied: applied(others),
                method_state: method_state.1,
            },
        )
    }
}

/// The forces of a table, or a part of it, and the rows that have one; all other rows are zero and are not looked
/// at.
#[derive(Clone, Copy)]
pub(crate) struct Applied<'a, T> {
    /// Of every body of the part.
    pub forces: &'a [[T; 3]],
    /// Table and row of the bodies of this part that were pushed, rows ascending.
    pub rows: &'a [(usize, usize)],
    /// The row of the table at which the part begins.
    pub offset: usize,
}

impl<T> Applied<'_, T> {
    /// A part of this part.
    pub fn part(&self, rows: Range<usize>) -> Self {
        let before = |pushed: &[(usize, usize)], row: usize| {
            pushed.partition_point(|(_, pushed)| *pushed < self.offset + row)
        };
        let pushed = &self.rows[before(self.rows, rows.start)..];
        // No more of them than rows: the second search is a short one.
        let pushed = &pushed[..pushed.len().min(rows.len())];
        Self {
            forces: &self.forces[rows.clone()],
            rows: &pushed[..before(pushed, rows.end)],
            offset: self.offset + rows.start,
        }
    }
}

/// What to tell about a row that was not updated, and why it was not.
pub(crate) type Refuse<'a> = &'a mut dyn FnMut(usize, Breach);

/// Integrates a tick of some rows of a batch, one by one where they have options.
pub(crate) fn integrate_batch<T: Real, M: Integrator>(
    terms: &Terms<'_, T>,
    batch: &mut Batch<'_, T>,
    rows: Range<usize>,
    options: Option<&dyn RowOptions<T>>,
    sums: &mut impl Sums<T>,
    statistics: &mut StepStatistics,
    refuse: Refuse<'_>,
) {
    assert_eq!(batch.positions.len(), batch.bodies.len(), "a position for every body");
    if let Some(options) = options {
        for row in rows {
            let options = options.row(row);
            if let Err(breach) = integrate_row::<T, M>(terms, &options, batch, row, sums, statistics) {
                refuse(row, breach);
            }
        }
        return;
    }
    let Terms { laws, rate, damping, decay, times, .. } = terms;
    let drags_and_damps = *rate != T::ZERO && damping.is_some() && M::DAMPS_INSIDE;
    if !laws.is_empty() || drags_and_damps || !M::PASSES_TIME {
        calling::run::<T, M>(terms, &BodyOptions::NONE, batch, rows, sums, statistics, refuse);
        return;
    }
    // Factors of a tick, between whose substeps the affine kernel does not know the first from the last.
    let factors = decay.before_move.is_some() || decay.after_move.is_some();
    let around = !M::DAMPS_INSIDE && times.substeps > 1 && factors;
    let in_registers = !around && sums.are_plain() && statistics.record.is_none();
    let start = rows.start;
    let refuse_part = &mut |row, breach| refuse(start + row, breach);
    if !in_registers || !affine::run::<T, M>(terms, &mut batch.part(rows.clone()), refuse_part) {
        // The same bits; what it would count is known without it.
        let mut uncounted = StepStatistics { record: statistics.record.take(), ..StepStatistics::default() };
        calling::run::<T, M>(terms, &BodyOptions::NONE, batch, rows, sums, &mut uncounted, refuse);
        statistics.record = uncounted.record;
    }
}

/// Integrates a tick of one row with these options, or says why it was refused.
pub(crate) fn integrate_row<T: Real, M: Integrator>(
    terms: &Terms<'_, T>,
    options: &BodyOptions<'_, T>,
    batch: &mut Batch<'_, T>,
    row: usize,
    sums: &mut impl Sums<T>,
    statistics: &mut StepStatistics,
) -> Result<(), Breach> {
    let mut own = *terms;
    if let Some(substeps) = options.substeps {
        own.times.substeps = substeps;
    }
    let own = own.damped::<M>(options.damping(terms.damping));
    let mut outcome = Ok(());
    calling::run::<T, M>(&own, options, batch, row..row + 1, sums, statistics, &mut |_, breach| {
        outcome = Err(breach);
    });
    outcome
}
