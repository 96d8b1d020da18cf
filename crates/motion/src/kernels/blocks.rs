//! The kernel of blocks: handles everything, with laws that are called and the options of single bodies.
//!
//! Rows are turned into structures of arrays and back, and laws are called once per block and stage.

use std::ops::Range;

use super::affine::{is_missed, is_movable};
use super::block::Block;
use super::block_field::BlockField;
use super::compensated::drive_compensated;
use super::drive::drive;
use super::method_state::MethodStateRows;
use super::{Applied, Batch, BodyOptions, Refuse, StepStatistics, Terms};
use crate::laws::BLOCK_BODIES;
use crate::laws::tick_times::Segments;
use crate::methods::{Integrator, MethodStateKind, StepState};
use crate::real::{Real, vectorize};
use crate::state::method_state::CachedAcceleration;
use crate::state::range::Bounds;

/// Rows up to which a rest is integrated body by body: a block takes as long however many there are.
const FEW: usize = 4;

/// Integrates a tick of some rows.
pub(super) fn run<T: Real, M: Integrator>(
    terms: &Terms<'_, T>,
    options: &BodyOptions<'_, T>,
    batch: &mut Batch<'_, T>,
    rows: Range<usize>,
    statistics: &mut StepStatistics,
    refuse: Refuse<'_>,
) {
    statistics.calls.resize(terms.laws.len(), 0);
    let segments = terms.segments(options.laws);
    let mut tick = BlockTick { terms, options, segments, statistics };
    let (mut start, end) = (rows.start, rows.end);
    while start < end {
        let mut rows = start..end.min(start + BLOCK_BODIES);
        if let MethodStateRows::LastStep(steps) = &batch.method_state {
            // Some bodies are new to the method.
            let alike = steps[rows.clone()].iter().take_while(|step| **step == steps[start]).count();
            rows.end = start + alike.max(1);
        }
        start = rows.end;
        if M::SOLVES || rows.len() <= FEW {
            rows.for_each(|row| tick.integrate_one::<M>(batch, row, refuse));
        } else {
            vectorize(
                #[inline(always)]
                || tick.integrate::<M, BLOCK_BODIES>(batch, rows, refuse),
            );
        }
    }
}

/// What is the same for every block of a batch in a tick.
struct BlockTick<'a, 't, T: Real> {
    terms: &'a Terms<'t, T>,
    options: &'a BodyOptions<'a, T>,
    segments: Segments,
    statistics: &'a mut StepStatistics,
}

impl<T: Real> BlockTick<'_, '_, T> {
    fn integrate_one<M: Integrator>(&mut self, batch: &mut Batch<'_, T>, row: usize, refuse: Refuse<'_>) {
        self.integrate::<M, 1>(batch, row..row + 1, refuse);
    }

    /// Integrates a tick of `rows`, at most `N`.
    #[inline(always)]
    fn integrate<M: Integrator, const N: usize>(
        &mut self,
        batch: &mut Batch<'_, T>,
        rows: Range<usize>,
        refuse: Refuse<'_>,
    ) {
        let Self { terms, options, segments, statistics } = self;
        let bodies = &batch.bodies[rows.clone()];
        let (x, v) = (Block::of(&batch.positions[rows.clone()]), Block::of(bodies));
        let mut w = [bodies[0][3]; N];
        w.iter_mut().zip(bodies).for_each(|(w, body)| *w = body[3]);
        let movable = bodies.iter().filter(|body| is_movable(body)).count() as u64;
        let mut forces = Block::ZERO;
        if let Some(Applied { forces: all, rows: pushed, offset }) =
            batch.applied.map(|applied| applied.part(rows.clone()))
        {
            for row in pushed.iter().map(|(_, row)| row - offset) {
                (0..3).for_each(|axis| forces.0[axis][row] = all[row][axis]);
            }
        }
        let mut method_state = batch.method_state.part(rows.clone());
        if let Some(record) = &mut statistics.record {
            record.enter(&rows);
        }
        let closed = options.closed_axes(M::LIMITS_AFTER_KICK);
        let mut field = BlockField::<T, N>::new(terms, options, closed, statistics, (w, forces), movable);
        let last_step =
            if M::STATE == MethodStateKind::LastStep { method_state.last_step() } else { T::ZERO };
        let start = match (M::STATE, &method_state) {
            (MethodStateKind::LastAcceleration, MethodStateRows::LastAcceleration(cached)) => {
                recall(terms, options, segments, cached, &mut field, (&x, &v))
            }
            _ => None,
        };
        let mut step_state = StepState { last_step, start };
        // In f64 compensated kernels are not compiled.
        let (x, v) = if !T::WIDE
            && let Some(residues) = &mut batch.residues
        {
            let residues = residues.each_mut().map(|all| &mut all[rows.clone()]);
            drive_compensated::<M, T, N>(&mut field, terms, segments, (x, v), residues, &mut step_state)
        } else {
            drive::<M, _>(&mut field, terms, segments, x, v, &mut step_state)
        };
        let called = step_state.start.is_some().then_some(field.called);
        let last_step = step_state.last_step;
        note(terms, options, &mut method_state, last_step, called.as_ref(), (&x, &w));
        store::<T, N>(&terms.bounds, batch, rows, (&x, &v, &w), refuse);
    }
}

/// Stores new states, or refuses them.
#[inline(always)]
fn store<T: Real, const N: usize>(
    bounds: &Bounds<T>,
    batch: &mut Batch<'_, T>,
    rows: Range<usize>,
    (x, v, w): (&Block<T, N>, &Block<T, N>, &[T; N]),
    refuse: Refuse<'_>,
) {
    if *bounds == Bounds::FINITE && is_finite(x, v, w) {
        let (positions, bodies) = (&mut batch.positions[rows.clone()], &mut batch.bodies[rows]);
        for (k, (position, body)) in positions.iter_mut().zip(bodies).enumerate().take(N) {
            *position = x.body(k);
            let [a, b, c] = v.body(k);
            (body[0], body[1], body[2]) = (a, b, c);
        }
        return;
    }
    for (k, row) in rows.enumerate() {
        let body = &mut batch.bodies[row];
        let ([a, b, c], [d, e, f]) = (x.body(k), v.body(k));
        let new = [d, e, f, body[3]];
        if let Some(breach) = bounds.breach(&[a, b, c], &new) {
            if is_missed(bounds, &batch.positions[row], body) {
                refuse(row, breach);
            }
            continue;
        }
        batch.positions[row] = [a, b, c];
        *body = new;
    }
}

/// Whether the sums of all numbers of each body are finite, which proves that each number is. `false` proves nothing.
#[expect(clippy::eq_op, reason = "x - x is 0 if x is finite and NaN otherwise")]
#[inline(always)]
fn is_finite<T: Real, const N: usize>(x: &Block<T, N>, v: &Block<T, N>, w: &[T; N]) -> bool {
    let mut sums = *w;
    for axis in x.0.iter().chain(&v.0) {
        sums.iter_mut().zip(axis).for_each(|(sum, number)| *sum += *number);
    }
    // Without branches: one comparison of vectors.
    sums.iter().fold(true, |all, sum| all & (*sum - *sum == T::ZERO))
}

/// Stores what the next tick starts from: the accelerations `called`, if it can use them.
#[inline(always)]
fn note<T: Real, const N: usize>(
    terms: &Terms<'_, T>,
    options: &BodyOptions<'_, T>,
    method_state: &mut MethodStateRows<'_, T>,
    last_step: T,
    called: Option<&Block<T, N>>,
    (x, w): (&Block<T, N>, &[T; N]),
) {
    match (method_state, called) {
        // One that was not a number stays: it tells why its row was refused.
        (MethodStateRows::LastStep(steps), _) => {
            steps.iter_mut().filter(|step| step.is_finite()).for_each(|step| *step = last_step);
        }
        (MethodStateRows::LastAcceleration(cached), Some(called)) => {
            let time = T::of(terms.times.end);
            let laws = (terms.epoch, options.laws_version);
            for (k, cached) in cached.iter_mut().enumerate() {
                let ([x, y, z], [a, b, c]) = (x.body(k), called.body(k));
                let (at, acceleration) = ([x, y, z, w[k]], [a, b, c, T::ZERO]);
                *cached = CachedAcceleration { at, time, laws, acceleration };
            }
        }
        (MethodStateRows::LastAcceleration(cached), None) => cached.fill(CachedAcceleration::default()),
        (MethodStateRows::None, _) => {}
    }
}

/// The cached accelerations of bodies whose tick starts where their last one ended. Laws are called for the others,
/// unless that is all of them.
#[inline(always)]
fn recall<T: Real, const N: usize>(
    terms: &Terms<'_, T>,
    options: &BodyOptions<'_, T>,
    segments: &Segments,
    cached: &[CachedAcceleration<T>],
    field: &mut BlockField<'_, T, N>,
    (x, v): (&Block<T, N>, &Block<T, N>),
) -> Option<Block<T, N>> {
    let fits = |(k, cached): (usize, &CachedAcceleration<T>)| {
        let [x, y, z] = x.body(k);
        cached.time == T::of(terms.times.start)
            && cached.at == [x, y, z, field.inverse_mass(k)]
            && cached.laws == (terms.epoch, options.laws_version)
            // The cache only saves an evaluation: a value that is not finite is evaluated again.
            && cached.acceleration.iter().all(|part| part.is_finite())
    };
    let (mut called, mut missing) = (Block::ZERO, [false; N]);
    for (k, cached) in cached.iter().enumerate() {
        missing[k] = !fits((k, cached));
        (0..3).for_each(|axis| called.0[axis][k] = cached.acceleration[axis]);
    }
    let all_missing = missing[..cached.len()].iter().all(|missing| *missing);
    // What was evaluated before a jump is of no use after it.
    let first = segments.iter().next().filter(|first| !first.jump && !all_missing)?;
    for k in (0..cached.len()).filter(|k| missing[*k]) {
        field.call_one(first.evaluation_time(T::ZERO), k, (x, v), &mut called);
    }
    Some(field.laws_from(&called, v))
}
