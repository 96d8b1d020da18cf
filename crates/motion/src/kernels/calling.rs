//! The calling kernel: handles everything, with laws that are called and the options of single bodies.
//!
//! Bodies are copied into a block and back, and only baseline instructions are used: calling a law costs more than
//! either.

use std::ops::Range;

use fearless_simd::Fallback;

use super::affine::{is_missed, is_movable};
use super::compensated::drive_compensated;
use super::drive::{TickField, drive};
use super::field::{BlockField, Calls, Constants, parts::CALLS};
use super::lanes::Rows;
use super::method_state::MethodStateRows;
use super::{Applied, BLOCK, Batch, BodyOptions, Refuse, Row, StepStatistics, Terms};
use crate::laws::damping::Decay;
use crate::laws::tick_times::{Segment, Segments};
use crate::methods::{Field, Integrator, MethodStateKind, StepState};
use crate::real::Real;
use crate::state::components::AxisLocks;
use crate::state::method_state::CachedAcceleration;

/// Integrates a tick of some rows.
pub(super) fn run<T: Real, M: Integrator>(
    terms: &Terms<'_, T>,
    options: &BodyOptions<'_, T>,
    batch: &mut Batch<'_, T>,
    rows: Range<usize>,
    statistics: &mut StepStatistics,
    refuse: Refuse<'_>,
) {
    if M::SOLVES {
        run_by::<T, M, 1>(terms, options, batch, rows, statistics, refuse);
    } else {
        run_by::<T, M, BLOCK>(terms, options, batch, rows, statistics, refuse);
    }
}

/// Integrates a tick, `N` bodies at a time.
fn run_by<T: Real, M: Integrator, const N: usize>(
    terms: &Terms<'_, T>,
    options: &BodyOptions<'_, T>,
    batch: &mut Batch<'_, T>,
    rows: Range<usize>,
    statistics: &mut StepStatistics,
    refuse: Refuse<'_>,
) {
    statistics.calls.resize(terms.laws.len(), 0);
    let segments = terms.segments(options.laws);
    let closed = options.closed_axes(M::LIMITS_AFTER_KICK);
    let kernel = CallingKernel { terms, options, closed, segments };
    let (mut start, end) = (rows.start, rows.end);
    while start < end {
        let mut rows = start..end.min(start + N);
        if let MethodStateRows::LastStep(steps) = &batch.method_state
            && steps[rows.clone()].iter().any(|step| *step != steps[start])
        {
            // Some bodies are new to the method: one by one.
            rows.end = start + 1;
        }
        let zero = [[T::ZERO; 4]; N];
        let mut block = Block { x: padded(&batch.positions[rows.clone()]), bodies: zero, forces: zero };
        block.bodies[..rows.len()].copy_from_slice(&batch.bodies[rows.clone()]);
        if let Some(Applied { forces, rows: pushed, offset }) =
            batch.applied.map(|applied| applied.part(rows.clone()))
        {
            for (_, row) in pushed {
                let [x, y, z] = forces[row - offset];
                block.forces[row - offset] = [x, y, z, T::ZERO];
            }
        }
        let method_state = batch.method_state.part(rows.clone());
        if let Some(record) = &mut statistics.record {
            record.enter(&rows);
        }
        let mut residues =
            batch.residues.as_ref().map(|both| both.each_ref().map(|all| padded(&all[rows.clone()])));
        let (x, v) = kernel.tick::<M, N>(&block, residues.as_mut(), method_state, statistics);
        for k in 0..rows.len() {
            let row = start + k;
            let [a, b, c, _] = x[k];
            match terms.bounds.breach(&[a, b, c], &v[k]) {
                None => {
                    batch.positions[row] = [a, b, c];
                    batch.bodies[row] = v[k];
                    for (all, block) in batch.residues.iter_mut().flatten().zip(residues.iter().flatten()) {
                        all[row].copy_from_slice(&block[k][..3]);
                    }
                }
                Some(breach) if is_missed(&terms.bounds, &batch.positions[row], &batch.bodies[row]) => {
                    refuse(row, breach);
                }
                Some(_) => {}
            }
        }
        start = rows.end;
    }
}

/// Rows of four numbers, filled up with zeros.
fn padded<T: Real, const N: usize>(triples: &[[T; 3]]) -> [Row<T>; N] {
    let mut rows = [[T::ZERO; 4]; N];
    rows.iter_mut().zip(triples).for_each(|(row, [x, y, z])| *row = [*x, *y, *z, T::ZERO]);
    rows
}

/// A block of bodies in memory, filled up with bodies of inverse mass 0.
struct Block<T, const N: usize> {
    x: [Row<T>; N],
    bodies: [Row<T>; N],
    forces: [Row<T>; N],
}

/// What is the same for every block of a batch in a tick.
struct CallingKernel<'a, 't, T: Real> {
    terms: &'a Terms<'t, T>,
    options: &'a BodyOptions<'a, T>,
    /// Axes along which nothing accelerates the bodies.
    closed: Option<AxisLocks>,
    segments: Segments,
}

impl<T: Real> CallingKernel<'_, '_, T> {
    /// The field of a block.
    fn field<'a, const N: usize>(
        &'a self,
        block: &Block<T, N>,
        statistics: &'a mut StepStatistics,
    ) -> BlockField<'a, T, Fallback, N, CALLS, true> {
        let Self { terms, options, closed, .. } = self;
        let simd = Fallback::new();
        let rows = block.bodies.iter().filter(|body| is_movable(body)).count() as u64;
        let (limit, locks) = (options.speed_limit.map(T::of), options.locks);
        let calls =
            Calls { laws: terms.laws, own: options.laws, limit, locks, closed: *closed, statistics, rows };
        let forces = Rows::of(simd, &block.forces);
        let constants = Constants::new(simd, terms);
        BlockField::new(constants, terms, &block.bodies, Some(&forces), Some(calls))
    }

    /// Integrates a tick of a block; returns its new state. `residues` are those of the state, if sums are compensated.
    fn tick<M: Integrator, const N: usize>(
        &self,
        block: &Block<T, N>,
        residues: Option<&mut [[Row<T>; N]; 2]>,
        mut method_state: MethodStateRows<'_, T>,
        statistics: &mut StepStatistics,
    ) -> ([Row<T>; N], [Row<T>; N]) {
        let [x, v] = [&block.x, &block.bodies].map(|rows| Rows::of(Fallback::new(), rows));
        let mut field = self.field(block, statistics);
        let last_step =
            if M::STATE == MethodStateKind::LastStep { method_state.last_step() } else { T::ZERO };
        let start = self.recall::<M, N>(block, &method_state, &field, v);
        let mut step_state = StepState { last_step, start };
        // In f64 compensated kernels are not compiled.
        let (x, v) = if !T::WIDE
            && let Some(residues) = residues
        {
            drive_compensated::<M, T, N>(
                &mut field,
                self.terms,
                &self.segments,
                (x, v),
                residues,
                &mut step_state,
            )
        } else {
            drive::<M, _>(&mut field, self.terms, &self.segments, x, v, &mut step_state)
        };
        let (x, v) = (x.rows(), v.rows());
        let called = step_state.start.is_some().then(|| field.called.rows());
        self.note(&mut method_state, step_state.last_step, called, &x, &v);
        (x, v)
    }

    /// Stores what the next tick starts from: the accelerations `called`, if it can use them.
    fn note<const N: usize>(
        &self,
        method_state: &mut MethodStateRows<'_, T>,
        last_step: T,
        called: Option<[Row<T>; N]>,
        x: &[Row<T>; N],
        v: &[Row<T>; N],
    ) {
        match (method_state, called) {
            // One that was not a number stays: it tells why its row was refused.
            (MethodStateRows::LastStep(steps), _) => {
                steps.iter_mut().filter(|step| step.is_finite()).for_each(|step| *step = last_step);
            }
            (MethodStateRows::LastAcceleration(cached), Some(called)) => {
                let time = T::of(self.terms.times.end);
                let laws = (self.terms.epoch, self.options.laws_version);
                for (k, cached) in cached.iter_mut().enumerate() {
                    let at = [x[k][0], x[k][1], x[k][2], v[k][3]];
                    *cached = CachedAcceleration { at, time, laws, acceleration: called[k] };
                }
            }
            (MethodStateRows::LastAcceleration(cached), None) => cached.fill(CachedAcceleration::default()),
            (MethodStateRows::None, _) => {}
        }
    }

    /// The cached acceleration, if this tick starts where the last one ended.
    fn recall<M: Integrator, const N: usize>(
        &self,
        block: &Block<T, N>,
        method_state: &MethodStateRows<'_, T>,
        field: &BlockField<'_, T, Fallback, N, CALLS, true>,
        v: Rows<T, Fallback, N>,
    ) -> Option<Rows<T, Fallback, N>> {
        let (MethodStateKind::LastAcceleration, MethodStateRows::LastAcceleration(cached)) =
            (M::STATE, method_state)
        else {
            return None;
        };
        let fits = |(k, cached): (usize, &CachedAcceleration<T>)| {
            let [x, y, z, _] = block.x[k];
            cached.time == T::of(self.terms.times.start)
                && cached.at == [x, y, z, block.bodies[k][3]]
                && cached.laws == (self.terms.epoch, self.options.laws_version)
                // The cache only saves an evaluation: a value that is not finite is evaluated again.
                && cached.acceleration.iter().all(|part| part.is_finite())
        };
        cached.iter().enumerate().all(fits).then(|| {
            let mut called = [[T::ZERO; 4]; N];
            cached.iter().zip(&mut called).for_each(|(cached, called)| *called = cached.acceleration);
            field.laws_from(Rows::of(Fallback::new(), &called), v)
        })
    }
}

impl<T: Real, const N: usize> TickField for BlockField<'_, T, Fallback, N, CALLS, true> {
    fn enter<M: Integrator>(&mut self, segment: Segment<T>, decay: Decay<T>) {
        self.set_segment(segment, decay);
    }

    fn before_tick(&mut self, x: Self::Space, v: Self::Space) -> (Self::Space, Self::Space) {
        let v = self.before_move(v);
        self.record_change(v, v, &|record, _, v, _| record.begin(v));
        (x, v)
    }

    /// As the affine kernel after each of its steps, so that subnormal numbers are the same.
    fn after_step<M: Integrator>(
        &mut self,
        x: Self::Space,
        v: Self::Space,
        _: &mut StepState<Self>,
    ) -> (Self::Space, Self::Space) {
        (x, if M::DAMPS_INSIDE { v } else { self.snap_drag(v) })
    }

    fn after_tick(&mut self, x: Self::Space, v: Self::Space) -> (Self::Space, Self::Space) {
        self.record_change(v, v, &|record, _, v, _| record.end(v));
        let decayed = self.after_move(v);
        (x, self.limited(decayed))
    }
}
