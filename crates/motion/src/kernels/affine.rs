//! The kernel of gravity, linear drag, damping and applied forces: everything in registers.

use std::ops::Range;

use fearless_simd::{Simd, f64x4, prelude::*};

use super::field::{Constants, RowField, parts};
use super::lanes::{Rows, each_row};
use super::method_state::MethodStateRows;
use super::{AppliedForces, BLOCK, Batch, Refuse, Row, TickParameters};
use crate::methods::{Integrator, MethodStateKind, StepState};
use crate::simd::{LEVEL, Lanes as _};
use crate::state::range::{Bounds, Breach};

/// The positions of a block and one number beyond: each row is loaded as four lanes, of which the last is not used.
type Triples = [f64; 3 * BLOCK + 1];

/// Rows that take all substeps before the next rows: they stay in the first-level cache.
const STAY: usize = 32 * BLOCK;

/// Integrates a tick of some rows and returns the number of evaluations. Does nothing and returns `None` if the machine has no
/// registers that hold a row.
#[must_use]
pub(super) fn run<M: Integrator>(
    parameters: &TickParameters<'_>,
    batch: &mut Batch<'_>,
    rows: Range<usize>,
    refuse: Refuse<'_>,
) -> Option<u64> {
    let substeps = parameters.times.substeps;
    if substeps == 1 {
        return step_all::<M>(parameters, batch, rows, refuse);
    }
    let mut evaluations = 0;
    // Nothing here depends on time, so every substep is the same step. A row that one substep refuses keeps its
    // state, so the next ones refuse it as well; it is restored to its state before the tick. The range is checked
    // only at the end of the tick.
    let inner = parameters.within(Bounds::FINITE);
    let mut refused: Vec<(usize, Breach)> = Vec::new();
    let mut before = ([[0.0; 3]; STAY], [[0.0; 4]; STAY]);
    for start in rows.clone().step_by(STAY) {
        let rows = start..rows.end.min(start + STAY);
        before.0[..rows.len()].copy_from_slice(&batch.positions[rows.clone()]);
        before.1[..rows.len()].copy_from_slice(&batch.bodies[rows.clone()]);
        let first = refused.len();
        for _ in 0..substeps {
            let refuse = &mut |row, breach| refused.push((row, breach));
            evaluations += step_all::<M>(&inner, batch, rows.clone(), refuse)?;
        }
        if parameters.bounds != Bounds::FINITE {
            for row in rows {
                let breach = parameters.bounds.breach(&batch.positions[row], &batch.bodies[row]);
                let (x, body) = (&before.0[row - start], &before.1[row - start]);
                refused.extend(
                    breach
                        .filter(|_| must_refuse(&parameters.bounds, x, body))
                        .map(|breach| (row, breach)),
                );
            }
        }
        for (row, _) in &refused[first..] {
            batch.positions[*row] = before.0[row - start];
            batch.bodies[*row] = before.1[row - start];
        }
    }
    if !refused.is_empty() {
        refuse_once(refused, refuse);
    }
    Some(evaluations)
}

/// Refuses each row for its first reason. Separate from [`run`], so that the sort is compiled once and not for every
/// method.
#[cold]
fn refuse_once(mut refused: Vec<(usize, Breach)>, refuse: Refuse<'_>) {
    // A stable sort keeps the first reason first.
    refused.sort_by_key(|(row, _)| *row);
    refused.dedup_by_key(|(row, _)| *row);
    refused.into_iter().for_each(|(row, breach)| refuse(row, breach));
}

/// A step of some rows; returns the number of evaluations.
#[must_use]
fn step_all<M: Integrator>(
    parameters: &TickParameters<'_>,
    batch: &mut Batch<'_>,
    rows: Range<usize>,
    refuse: Refuse<'_>,
) -> Option<u64> {
    if rows.is_empty() {
        return Some(0);
    }
    let mut whole = batch.part(rows.clone());
    let evaluations =
        step::<M>(parameters, &mut whole, &mut |row, breach| refuse(rows.start + row, breach))?;
    // A block is loaded one number beyond its last row, so the last block is copied, with a row beyond it.
    let rest = (rows.len() - 1) % BLOCK + 1;
    let last = rows.end - rest..rows.end;
    let zero = [0.0; 3];
    let (mut positions, mut bodies) = ([zero; BLOCK + 1], [[0.0; 4]; BLOCK + 1]);
    let (mut forces, mut steps) = ([zero; BLOCK + 1], [0.0; BLOCK + 1]);
    positions[..rest].copy_from_slice(&batch.positions[last.clone()]);
    bodies[..rest].copy_from_slice(&batch.bodies[last.clone()]);
    let (mut pushed, mut count) = ([(0, 0); BLOCK], 0);
    if let Some(applied) = batch.applied {
        let AppliedForces { forces: all, rows, offset } = applied.part(last.clone());
        forces[..rest].copy_from_slice(all);
        count = rows.len();
        pushed.iter_mut().zip(rows).for_each(|(copy, (table, row))| *copy = (*table, row - offset));
    }
    let mut method_state = MethodStateRows::None;
    if let MethodStateRows::LastStep(all) = &batch.method_state {
        // Rows that fill up the block are like its first row, so that its steps stay equal.
        steps = [all[last.start]; BLOCK + 1];
        steps[..rest].copy_from_slice(&all[last.clone()]);
        method_state = MethodStateRows::LastStep(&mut steps);
    }
    let applied =
        (count > 0).then_some(AppliedForces { forces: &forces, rows: &pushed[..count], offset: 0 });
    let mut copy = Batch { positions: &mut positions, bodies: &mut bodies, applied, method_state };
    let of_last =
        step::<M>(parameters, &mut copy, &mut |row, breach| refuse(last.start + row, breach))?;
    batch.positions[last.clone()].copy_from_slice(&positions[..rest]);
    batch.bodies[last.clone()].copy_from_slice(&bodies[..rest]);
    if let MethodStateRows::LastStep(all) = &mut batch.method_state {
        all[last].copy_from_slice(&steps[..rest]);
    }
    Some(evaluations + of_last)
}

/// A step of every whole block that has a row beyond it, with the parts of damping that it needs.
#[must_use]
fn step<M: Integrator>(
    parameters: &TickParameters<'_>,
    batch: &mut Batch<'_>,
    refuse: Refuse<'_>,
) -> Option<u64> {
    use parts::{AFTER, BEFORE, DRAG, KEEP};
    let decay = &parameters.decay;
    if !M::DAMPS_INSIDE {
        // Methods that save an evaluation under constant accelerations have a kernel for that.
        let constant = M::STATE == MethodStateKind::LastAcceleration && parameters.rate == 0.0;
        match constant {
            true => step_with::<M, 0>(parameters, batch, refuse),
            false => step_with::<M, DRAG>(parameters, batch, refuse),
        }
    } else if M::KICKS && decay.keep.is_some() {
        step_with::<M, KEEP>(parameters, batch, refuse)
    } else if M::KICKS && parameters.rate != 0.0 {
        step_with::<M, DRAG>(parameters, batch, refuse)
    } else if M::MOVES && decay.before_move.is_some() {
        step_with::<M, BEFORE>(parameters, batch, refuse)
    } else if M::MOVES && decay.after_move.is_some() {
        step_with::<M, AFTER>(parameters, batch, refuse)
    } else {
        step_with::<M, 0>(parameters, batch, refuse)
    }
}

/// [`step`] with these parts of damping; on x86 with AVX2 alone, because every instruction set is a copy of every method.
#[must_use]
fn step_with<M: Integrator, const PARTS: u8>(
    parameters: &TickParameters<'_>,
    batch: &mut Batch<'_>,
    refuse: Refuse<'_>,
) -> Option<u64> {
    #[cfg(target_arch = "x86_64")]
    {
        let simd = LEVEL.as_avx2()?;
        Some(simd.vectorize(
            #[inline(always)]
            || AffineKernel { simd, parameters, batch, refuse }.run::<M, PARTS>(),
        ))
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let level = *LEVEL;
        Some(fearless_simd::dispatch!(
            level,
            simd => AffineKernel { simd, parameters, batch, refuse }.run::<M, PARTS>()
        ))
    }
}

struct AffineKernel<'a, 't, 'r, S> {
    simd: S,
    parameters: &'a TickParameters<'t>,
    batch: &'a mut Batch<'r>,
    refuse: Refuse<'a>,
}

impl<S: Simd> AffineKernel<'_, '_, '_, S> {
    /// Returns the number of evaluations.
    #[inline(always)]
    fn run<M: Integrator, const PARTS: u8>(self) -> u64 {
        let Self {
            simd,
            parameters,
            batch: Batch { positions, bodies, applied, method_state, .. },
            refuse,
        } = self;
        let step = StepOf { constants: Constants::new(simd, parameters), parameters };
        let limit = Limit::of::<M>(parameters);
        let mut pushed = PushedBlocks::new(*applied, bodies.len());
        let count = bodies.len().saturating_sub(1) / BLOCK;
        let (blocks, _) = bodies.as_chunks_mut::<BLOCK>();
        let mut positions: &mut [f64] = positions.as_flattened_mut();
        let mut last = match method_state {
            MethodStateRows::LastStep(steps) => Some(steps.as_chunks_mut::<BLOCK>().0.iter_mut()),
            MethodStateRows::None | MethodStateRows::LastAcceleration(_) => None,
        };
        // The number of evaluations per movable body is the same for every block.
        let (mut movable, mut per_body) = (0, 0);
        for (number, block) in blocks[..count].iter_mut().enumerate() {
            let start = number * BLOCK;
            if M::KICKS {
                movable += step.constants.count_movable(block);
            }
            let x: &mut Triples = positions.first_chunk_mut().expect("a whole block and a number");
            let steps = last.as_mut().and_then(Iterator::next);
            // A kernel without forces is worth its code: adding zeros would lengthen every stage.
            let (new, evaluations) = if pushed.touches(start) {
                step.block::<M, PARTS, true>(simd, x, block, Some(&pushed.block(start)), steps)
            } else {
                step.block::<M, PARTS, false>(simd, x, block, None, steps)
            };
            per_body = evaluations;
            if !M::CHECKED || limit.is_of_numbers && is_finite::<M, S>(&new) {
                store::<M, S>(&new, x, block);
            } else {
                let (x, [new_x, new_v]) = (&mut x[..3 * BLOCK], [new.0.rows(), new.1.rows()]);
                commit_each(&limit.bounds, &new_x, &new_v, x, block, start, refuse);
            }
            positions = &mut positions[3 * BLOCK..];
        }
        movable * per_body
    }
}

/// A step of a block.
#[derive(Clone, Copy)]
struct StepOf<'a, 't, S: Simd> {
    constants: Constants<S>,
    parameters: &'a TickParameters<'t>,
}

type NewRows<S> = (Rows<S, BLOCK>, Rows<S, BLOCK>);

impl<S: Simd> StepOf<'_, '_, S> {
    /// The new positions and rows, neither checked nor stored, and the number of evaluations per movable body.
    #[inline(always)]
    fn block<M: Integrator, const PARTS: u8, const PUSHED: bool>(
        &self,
        simd: S,
        x: &Triples,
        bodies: &[Row; BLOCK],
        forces: Option<&Triples>,
        mut last: Option<&mut [f64; BLOCK]>,
    ) -> (NewRows<S>, u64) {
        // In a `const`, so that it is compiled for position Verlet alone.
        if const { matches!(M::STATE, MethodStateKind::LastStep) }
            && let Some(last) = &mut last
            && !(last[1] == last[0] && last[2] == last[0] && last[3] == last[0])
        {
            return self.one_by_one::<M, PARTS>(simd, x, bodies, forces, last);
        }
        let mut applied = Rows::splat(f64x4::splat(simd, 0.0));
        if PUSHED && let Some(forces) = forces {
            applied = load_triples(simd, forces);
        }
        let field =
            RowField::<_, BLOCK, PARTS, PUSHED>::new(self.constants, bodies, Some(&applied));
        let (x, v) = (load_triples(simd, x), Rows::of(simd, bodies));
        self.run::<M, PARTS, PUSHED, BLOCK>(field, x, v, last)
    }

    /// A step of a block whose bodies have different last steps, because some are new.
    #[inline(always)]
    fn one_by_one<M: Integrator, const PARTS: u8>(
        &self,
        simd: S,
        x: &Triples,
        bodies: &[Row; BLOCK],
        forces: Option<&Triples>,
        last: &mut [f64; BLOCK],
    ) -> (NewRows<S>, u64) {
        let zero = [0.0; 3 * BLOCK + 1];
        let (x, forces) = (load_triples(simd, x), load_triples(simd, forces.unwrap_or(&zero)));
        let (mut new_x, mut new_v, mut evaluations) = (x, Rows::of(simd, bodies), 0);
        each_row!(k in BLOCK {
            let body = [bodies[k]];
            let force = Rows([forces.0[k]]);
            let field =
                RowField::<_, 1, PARTS, true>::new(self.constants, &body, Some(&force));
            let (x, v) = (Rows([x.0[k]]), Rows::of(simd, &body));
            let mut step = [last[k]];
            let ((x, v), of_body) = self.run::<M, PARTS, true, 1>(field, x, v, Some(&mut step));
            (new_x.0[k], new_v.0[k], evaluations) = (x.0[0], v.0[0], of_body);
            // A last step that is not finite stays: it is the evidence of why its row was refused.
            if last[k].is_finite() {
                last[k] = step[0];
            }
        });
        ((new_x, new_v), evaluations)
    }

    #[inline(always)]
    fn run<M: Integrator, const PARTS: u8, const PUSHED: bool, const N: usize>(
        &self,
        mut field: RowField<S, N, PARTS, PUSHED>,
        mut x: Rows<S, N>,
        mut v: Rows<S, N>,
        last: Option<&mut [f64; N]>,
    ) -> ((Rows<S, N>, Rows<S, N>), u64) {
        let TickParameters { decay, rate, .. } = self.parameters;
        let mut step_state = StepState::default();
        if let (MethodStateKind::LastStep, Some(last)) = (M::STATE, &last) {
            step_state.last_step = last[0];
        }
        if !M::DAMPS_INSIDE && decay.before_move.is_some() {
            v = field.constants.times(v, field.constants.before);
        }
        (x, v) = M::step(&mut field, x, v, &mut step_state);
        if !M::DAMPS_INSIDE {
            if decay.after_move.is_some() {
                v = field.constants.times(v, field.constants.after);
            } else if *rate > 0.0 {
                v = field.constants.snap(v);
            }
        }
        if let (MethodStateKind::LastStep, Some(last)) = (M::STATE, last) {
            *last = [step_state.last_step; N];
        }
        ((x, v), field.evaluations)
    }
}

/// The blocks with pushed rows, found in one pass over the rows.
struct PushedBlocks<'a> {
    numbers: &'a [f64],
    rows: &'a [(usize, usize)],
    offset: usize,
    next: usize,
}

impl<'a> PushedBlocks<'a> {
    fn new(applied: Option<AppliedForces<'a>>, rows: usize) -> Self {
        let AppliedForces { forces, rows: pushed, offset } =
            applied.unwrap_or(AppliedForces { forces: &[], rows: &[], offset: 0 });
        assert!(pushed.is_empty() || forces.len() == rows, "a force for every body");
        Self {
            numbers: forces.as_flattened(),
            rows: pushed,
            offset,
            next: first_row(pushed, offset),
        }
    }

    /// Whether a row of the block at `start` is pushed. Called for blocks in order.
    #[inline(always)]
    fn touches(&mut self, start: usize) -> bool {
        if self.next >= start + BLOCK {
            return false;
        }
        self.skip(start + BLOCK);
        true
    }

    #[inline(never)]
    fn skip(&mut self, end: usize) {
        let end = end + self.offset;
        let beyond = self.rows.iter().position(|(_, row)| *row >= end).unwrap_or(self.rows.len());
        self.rows = &self.rows[beyond..];
        self.next = first_row(self.rows, self.offset);
    }

    /// The forces of a block and one number beyond.
    #[inline(always)]
    fn block(&self, start: usize) -> Triples {
        *self.numbers[3 * start..].first_chunk().expect("a row lies beyond the block")
    }
}

fn first_row(rows: &[(usize, usize)], offset: usize) -> usize {
    rows.first().map_or(usize::MAX, |(_, row)| *row - offset)
}

#[inline(always)]
fn load_triples<S: Simd>(simd: S, numbers: &Triples) -> Rows<S, BLOCK> {
    let mut rows = Rows::splat(f64x4::splat(simd, 0.0));
    each_row!(k in BLOCK {
        rows.0[k] = f64x4::from_slice(simd, &numbers[3 * k..3 * k + 4]);
    });
    rows
}

/// The check of new rows.
struct Limit {
    bounds: Bounds,
    /// Whether it is enough that every number is finite.
    is_of_numbers: bool,
}

impl Limit {
    fn of<M: Integrator>(parameters: &TickParameters<'_>) -> Self {
        // A factor after the move may enlarge the velocity after it entered the position.
        let grows =
            parameters.decay.after_move.is_some_and(|factor| factor.abs() > 1.0 || factor.is_nan());
        let is_of_numbers =
            parameters.bounds == Bounds::FINITE && !(M::MOVES_WITH_NEW_VELOCITY && grows);
        Self { bounds: parameters.bounds, is_of_numbers }
    }
}

/// Whether the sum of all numbers is finite, which proves that each is. `false` proves nothing: a sum of large
/// numbers may overflow.
#[expect(clippy::eq_op, reason = "x - x is 0 if x is finite and NaN otherwise")]
#[inline(always)]
fn is_finite<M: Integrator, S: Simd>((x, v): &NewRows<S>) -> bool {
    let [a, b, c, d] = x.0;
    let mut sum = (a + b) + (c + d);
    // If a step moves with its new velocity, a finite position proves a finite velocity.
    if !M::MOVES_WITH_NEW_VELOCITY {
        let [a, b, c, d] = v.0;
        sum += (a + b) + (c + d);
    }
    (sum - sum).is_zero()
}

/// Stores positions and rows.
#[inline(always)]
fn store<M: Integrator, S: Simd>(
    (new_x, new_v): &NewRows<S>,
    x: &mut Triples,
    bodies: &mut [Row; BLOCK],
) {
    if M::MOVES {
        // In this order: the last lane of a row is the first number of the next, which is stored after it.
        each_row!(k in BLOCK - 1 {
            new_x.0[k].store_slice(&mut x[3 * k..3 * k + 4]);
        });
        let [a, b, c, _] = new_x.0[BLOCK - 1].into();
        x[3 * BLOCK - 3..3 * BLOCK].copy_from_slice(&[a, b, c]);
    }
    each_row!(k in BLOCK {
        new_v.0[k].store_slice(&mut bodies[k]);
    });
}

/// Checks and stores row by row.
#[cold]
fn commit_each(
    bounds: &Bounds,
    new_x: &[Row; BLOCK],
    new_v: &[Row; BLOCK],
    x: &mut [f64],
    bodies: &mut [Row; BLOCK],
    start: usize,
    refuse: Refuse<'_>,
) {
    for k in 0..BLOCK {
        let [a, b, c, _] = new_x[k];
        let old = &mut x[3 * k..3 * k + 3];
        match bounds.breach(&[a, b, c], &new_v[k]) {
            None => {
                old.copy_from_slice(&[a, b, c]);
                bodies[k] = new_v[k];
            }
            Some(breach) if must_refuse(bounds, old, &bodies[k]) => refuse(start + k, breach),
            Some(_) => {}
        }
    }
}

/// Whether a row at `x` that was not stored is refused. A body that is immovable and at rest just stays as it is; so
/// do the rows that fill up the last block.
pub(super) fn must_refuse(bounds: &Bounds, x: &[f64], row: &Row) -> bool {
    *row != [0.0; 4] || x.iter().any(|part| !part.is_finite() || part.abs() > bounds.position)
}

#[cfg(test)]
mod tests;
