//! The kernel of blocks: handles everything, with laws that are called and the options of single bodies.
//!
//! Rows are turned into structures of arrays and back, and laws are called once per block and stage.

use std::ops::Range;

use super::affine::must_refuse;
use super::block::{Block, BlockSpace, Slot, Slots};
use super::block_field::BlockField;
use super::drive::drive;
use super::method_state::MethodStateRows;
use super::{Batch, BodyOptions, Refuse, RowOptions, StepStatistics, TickParameters};
use crate::laws::BLOCK_BODIES;
use crate::laws::tick_times::Segments;
use crate::methods::{Integrator, MethodStateKind, StepState};
use crate::simd::vectorize;
use crate::state::method_state::CachedAcceleration;
use crate::state::range::Bounds;

/// Most rows that are integrated body by body: a block takes the same time for any number of rows.
const FEW: usize = 4;

/// Integrates a tick of some rows with these options; if their own laws differ, `own` has the options of each row.
pub(super) fn run<M: Integrator>(
    parameters: &TickParameters<'_>,
    options: &BodyOptions<'_>,
    own: Option<&dyn RowOptions>,
    batch: &mut Batch<'_>,
    rows: Range<usize>,
    statistics: &mut StepStatistics,
    refuse: Refuse<'_>,
) {
    let segments = parameters.segments(options.laws.iter(), std::iter::empty());
    if M::SOLVES || rows.len() <= FEW {
        let field =
            &mut BlockField::<Block<1>, 1>::new::<M>(parameters, options, own, statistics, ());
        rows.for_each(|row| integrate::<M, _, 1>(field, &segments, batch, row..row + 1, refuse));
        return field.count();
    }
    Slots::lend(|slots| {
        let field = &mut BlockField::<Slot<'_>, BLOCK_BODIES>::new::<M>(
            parameters, options, own, statistics, slots,
        );
        run_blocks::<M>(field, &segments, batch, rows, refuse);
        field.count();
    });
}

/// Integrates a tick of some rows, block by block.
fn run_blocks<M: Integrator>(
    field: &mut BlockField<'_, Slot<'_>, BLOCK_BODIES>,
    segments: &Segments,
    batch: &mut Batch<'_>,
    rows: Range<usize>,
    refuse: Refuse<'_>,
) {
    let (mut start, end) = (rows.start, rows.end);
    while start < end {
        let mut rows = start..end.min(start + BLOCK_BODIES);
        if let MethodStateRows::LastStep(steps) = &batch.method_state {
            // Rows with different last steps are split: some bodies are new to the method.
            let alike =
                steps[rows.clone()].iter().take_while(|step| **step == steps[start]).count();
            rows.end = start + alike.max(1);
        }
        start = rows.end;
        if rows.len() <= FEW {
            run::<M>(
                field.parameters,
                field.options,
                field.rows,
                batch,
                rows,
                field.statistics,
                refuse,
            );
        } else {
            integrate::<M, _, BLOCK_BODIES>(field, segments, batch, rows, refuse);
        }
    }
}

/// Integrates a tick of `rows`, at most `N`.
fn integrate<M: Integrator, X: BlockSpace<N>, const N: usize>(
    field: &mut BlockField<'_, X, N>,
    segments: &Segments,
    batch: &mut Batch<'_>,
    rows: Range<usize>,
    refuse: Refuse<'_>,
) {
    let (x, v) = load(field, batch, &rows);
    let mut method_state = batch.method_state.part(rows.clone());
    let last_step =
        if M::STATE == MethodStateKind::LastStep { method_state.last_step() } else { 0.0 };
    let start = match (M::STATE, &method_state) {
        (MethodStateKind::LastAcceleration, MethodStateRows::LastAcceleration(cached)) => {
            recall(segments, cached, field, x, v)
        }
        _ => None,
    };
    let mut step_state = StepState { last_step, start };
    let parameters = field.parameters;
    let (x, v) = drive::<M, _>(field, parameters, segments, x, v, &mut step_state);
    field.count_block();
    // A method leaves there that it has the acceleration at the end, which is the start of the next tick.
    if M::STATE != MethodStateKind::None {
        let called = step_state.start.is_some().then_some(&field.called);
        note(field, &mut method_state, step_state.last_step, called, x);
    }
    x.read_both(v, |x, v| store::<N>(&parameters.bounds, batch, rows, x, v, &field.w, refuse));
}

/// Enters the block of `rows`. Returns their positions and velocities.
#[inline(never)]
fn load<X: BlockSpace<N>, const N: usize>(
    field: &mut BlockField<'_, X, N>,
    batch: &Batch<'_>,
    rows: &Range<usize>,
) -> (X, X) {
    let (positions, bodies) = (&batch.positions[rows.clone()], &batch.bodies[rows.clone()]);
    field.enter_block(rows.start, bodies, batch.applied.map(|applied| applied.part(rows.clone())));
    if let Some(record) = &mut field.statistics.record {
        record.enter(rows);
    }
    let memory = field.memory;
    X::recycle(memory, &mut []);
    vectorize(
        #[inline(always)]
        || (X::load(memory, |x| x.load(positions)), X::load(memory, |v| v.load(bodies))),
    )
}

/// Stores new states, or refuses them.
#[inline(never)]
fn store<const N: usize>(
    bounds: &Bounds,
    batch: &mut Batch<'_>,
    rows: Range<usize>,
    x: &Block<N>,
    v: &Block<N>,
    w: &[f64; N],
    refuse: Refuse<'_>,
) {
    let stored = *bounds == Bounds::FINITE
        && vectorize(
            #[inline(always)]
            || {
                let is_finite = is_finite(x, v, w);
                if is_finite {
                    x.store(&mut batch.positions[rows.clone()], |[x, y, z], _| [x, y, z]);
                    v.store(&mut batch.bodies[rows.clone()], |[x, y, z], k| [x, y, z, w[k]]);
                }
                is_finite
            },
        );
    if stored {
        return;
    }
    for (k, row) in rows.enumerate() {
        let body = &mut batch.bodies[row];
        let ([a, b, c], [d, e, f]) = (x.body(k), v.body(k));
        let new = [d, e, f, body[3]];
        if let Some(breach) = bounds.breach(&[a, b, c], &new) {
            if must_refuse(bounds, &batch.positions[row], body) {
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
fn is_finite<const N: usize>(x: &Block<N>, v: &Block<N>, w: &[f64; N]) -> bool {
    let mut sums = *w;
    for axis in x.0.iter().chain(&v.0) {
        sums.iter_mut().zip(axis).for_each(|(sum, number)| *sum += *number);
    }
    // Without branches: one comparison of vectors.
    sums.iter().fold(true, |all, sum| all & (*sum - *sum == 0.0))
}

/// Stores the method state for the next tick: the length of the last step, or the accelerations `called`.
#[inline(never)]
fn note<X: BlockSpace<N>, const N: usize>(
    field: &BlockField<'_, X, N>,
    method_state: &mut MethodStateRows<'_>,
    last_step: f64,
    called: Option<&Block<N>>,
    x: X,
) {
    match (method_state, called) {
        // A last step that is not finite stays: it shows why its row was refused.
        (MethodStateRows::LastStep(steps), _) => {
            steps.iter_mut().filter(|step| step.is_finite()).for_each(|step| *step = last_step);
        }
        (MethodStateRows::LastAcceleration(cached), Some(called)) => {
            let BlockField { parameters: TickParameters { times, epoch, .. }, w, own_laws, .. } =
                field;
            x.read(|x| {
                for (k, cached) in cached.iter_mut().enumerate() {
                    let ([x, y, z], acceleration) = (x.body(k), called.body(k));
                    let (time, laws) = (times.end, (*epoch, own_laws[k].1));
                    *cached = CachedAcceleration { at: [x, y, z, w[k]], time, laws, acceleration };
                }
            });
        }
        (MethodStateRows::LastAcceleration(cached), None) => {
            cached.fill(CachedAcceleration::default());
        }
        (MethodStateRows::None, _) => {}
    }
}

/// The accelerations at the start of the tick: cached for bodies in the state in which their last tick ended, evaluated for
/// the others. `None` if no cached acceleration fits.
#[inline(never)]
fn recall<X: BlockSpace<N>, const N: usize>(
    segments: &Segments,
    cached: &[CachedAcceleration],
    field: &mut BlockField<'_, X, N>,
    x: X,
    v: X,
) -> Option<X> {
    // Accelerations from before a jump are invalid after it.
    let first = segments.iter().next().filter(|first| !first.jump)?;
    let (time, epoch) = (field.parameters.times.start, field.parameters.epoch);
    let BlockField { w, own_laws, called, .. } = field;
    let mut fits = [true; N];
    x.read(|x| {
        for (k, cached) in cached.iter().enumerate().take(N) {
            let ([x, y, z], [a, b, c]) = (x.body(k), cached.acceleration);
            let is_here = (cached.at[0] == x)
                & (cached.at[1] == y)
                & (cached.at[2] == z)
                & (cached.at[3] == w[k]);
            let is_now =
                (cached.time == time) & (cached.laws.0 == epoch) & (cached.laws.1 == own_laws[k].1);
            // The cache only saves an evaluation: a value that is not finite is evaluated again.
            fits[k] = is_here & is_now & (a + b + c).is_finite();
            (called.0[0][k], called.0[1][k], called.0[2][k]) = (a, b, c);
        }
    });
    let some_fit = fits[..cached.len()].contains(&true);
    some_fit.then(|| field.laws_known(first.evaluation_time(0.0), x, v, &fits))
}
