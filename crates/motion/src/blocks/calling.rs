//! The kernel of everything: laws that are called, and what single bodies ask for.
//!
//! Bodies are copied into a block and back, and the instructions are the least that every machine has: what a
//! called law costs is more than either.

use fearless_simd::Fallback;

use super::affine::is_movable;
use super::field::{BlockField, Calls, Constants, parts::CALLS};
use super::lanes::Rows;
use super::memory::{Known, MemoryRows};
use super::{Account, Applied, Asks, BLOCK, Refuse, Row, Table, Terms};
use crate::course::{Piece, Pieces};
use crate::effects::Decay;
use crate::methods::{Carry, Integrator, Memory};
use crate::real::Real;

/// Integrates a tick.
pub(super) fn run<T: Real, M: Integrator>(
    terms: &Terms<'_, T>,
    asks: &Asks<'_, T>,
    table: &mut Table<'_, T>,
    applied: Option<Applied<'_, T>>,
    account: &mut Account,
    refuse: Refuse<'_>,
) {
    if M::SOLVES {
        run_by::<T, M, 1>(terms, asks, table, applied, account, refuse);
    } else {
        run_by::<T, M, BLOCK>(terms, asks, table, applied, account, refuse);
    }
}

/// Integrates a tick, `N` bodies at a time.
fn run_by<T: Real, M: Integrator, const N: usize>(
    terms: &Terms<'_, T>,
    asks: &Asks<'_, T>,
    table: &mut Table<'_, T>,
    applied: Option<Applied<'_, T>>,
    account: &mut Account,
    refuse: Refuse<'_>,
) {
    account.calls.resize(terms.laws.len(), 0);
    let breaks = terms.laws.iter().flat_map(|law| law.breaks());
    let pieces = terms.course.pieces(breaks.chain(asks.laws.iter().flat_map(|law| law.breaks())));
    let kernel = Kernel { terms, asks, pieces };
    let mut start = 0;
    while start < table.bodies.len() {
        let mut rows = start..table.bodies.len().min(start + N);
        if let MemoryRows::LastStep(steps) = &table.memory
            && steps[rows.clone()].iter().any(|step| *step != steps[start])
        {
            // Some are new to the method: one by one.
            rows.end = start + 1;
        }
        let mut block = Block::<T, N>::default();
        block.x[..rows.len()]
            .iter_mut()
            .zip(&table.positions[rows.clone()])
            .for_each(|(row, [x, y, z])| *row = [*x, *y, *z, T::ZERO]);
        block.bodies[..rows.len()].copy_from_slice(&table.bodies[rows.clone()]);
        if let Some(Applied { forces, rows: pushed, offset }) =
            applied.map(|applied| applied.part(rows.clone()))
        {
            for (_, row) in pushed {
                let [x, y, z] = forces[row - offset];
                block.forces[row - offset] = [x, y, z, T::ZERO];
            }
        }
        let (x, v) = kernel.tick::<M, N>(&block, table.memory.part(rows.clone()), account);
        for k in 0..rows.len() {
            let row = start + k;
            let [a, b, c, _] = x[k];
            if [a, b, c].into_iter().chain(v[k]).all(T::is_finite) {
                table.positions[row] = [a, b, c];
                table.bodies[row] = v[k];
            } else if is_movable(&table.bodies[row]) {
                refuse(row);
            }
        }
        start = rows.end;
    }
}

/// A block of bodies in memory; those of inverse mass 0 fill it up.
struct Block<T, const N: usize> {
    x: [Row<T>; N],
    bodies: [Row<T>; N],
    forces: [Row<T>; N],
}

impl<T: Real, const N: usize> Default for Block<T, N> {
    fn default() -> Self {
        let zero = [[T::ZERO; 4]; N];
        Self { x: zero, bodies: zero, forces: zero }
    }
}

struct Kernel<'a, 't, T: Real> {
    terms: &'a Terms<'t, T>,
    asks: &'a Asks<'a, T>,
    pieces: Pieces<T>,
}

impl<T: Real> Kernel<'_, '_, T> {
    /// The rows of a block at the end of the tick.
    fn tick<M: Integrator, const N: usize>(
        &self,
        block: &Block<T, N>,
        mut memory: MemoryRows<'_, T>,
        account: &mut Account,
    ) -> ([Row<T>; N], [Row<T>; N]) {
        let Self { terms, asks, pieces } = self;
        let simd = Fallback::new();
        let count = block.bodies.iter().filter(|body| is_movable(body)).count() as u64;
        let calls = Calls {
            laws: terms.laws,
            own: asks.laws,
            limit: asks.limit,
            locks: asks.locks,
            account,
            rows: count,
        };
        let forces = Rows::of(simd, &block.forces);
        let constants = Constants::new(simd, terms);
        let mut field = BlockField::<_, _, N, CALLS, true>::new(
            constants,
            terms,
            &block.bodies,
            Some(&forces),
            Some(calls),
        );
        let (mut x, mut v) = (Rows::of(simd, &block.x), Rows::of(simd, &block.bodies));
        let mut carry = Carry::new();
        self.recall::<M, N>(block, &memory, &field, v, &mut carry);
        if !M::DAMPS_INSIDE {
            v = field.restrain(field.decay_before(v));
        }
        for piece in pieces.iter() {
            field.enter(piece, self.decay::<M>(piece));
            if piece.jump {
                // It was evaluated before the jump.
                carry.start = None;
            }
            (x, v) = M::step(&mut field, x, v, &mut carry);
        }
        if !M::DAMPS_INSIDE {
            v = field.restrain(field.decay_after(v));
        }
        match &mut memory {
            MemoryRows::LastStep(steps) => steps.fill(carry.last_step),
            MemoryRows::Known(known) if carry.start.is_some() => {
                let (x, v, called) = (x.rows(), v.rows(), field.called.rows());
                let time = terms.course.end;
                let laws = (terms.epoch, asks.version);
                for (k, known) in known.iter_mut().enumerate() {
                    let at = [x[k][0], x[k][1], x[k][2], v[k][3]];
                    *known = Known { at, time, laws, called: called[k] };
                }
            }
            MemoryRows::Known(known) => known.fill(Known::default()),
            MemoryRows::None => {}
        }
        (x.rows(), v.rows())
    }

    /// What the last tick left for this one.
    fn recall<M: Integrator, const N: usize>(
        &self,
        block: &Block<T, N>,
        memory: &MemoryRows<'_, T>,
        field: &BlockField<'_, T, Fallback, N, CALLS, true>,
        v: Rows<T, Fallback, N>,
        carry: &mut Carry<BlockField<'_, T, Fallback, N, CALLS, true>>,
    ) {
        match (M::MEMORY, memory) {
            (Memory::LastStep, MemoryRows::LastStep(steps)) => {
                carry.last_step = steps.first().copied().unwrap_or(T::ZERO);
            }
            (Memory::LastAcceleration, MemoryRows::Known(known)) => {
                let fits = |(k, known): (usize, &Known<T>)| {
                    let [x, y, z, _] = block.x[k];
                    known.time == self.terms.course.start
                        && known.at == [x, y, z, block.bodies[k][3]]
                        && known.laws == (self.terms.epoch, self.asks.version)
                };
                if known.iter().enumerate().all(fits) {
                    let mut called = [[T::ZERO; 4]; N];
                    known.iter().zip(&mut called).for_each(|(known, called)| *called = known.called);
                    carry.start = Some(field.laws_from(Rows::of(Fallback::new(), &called), v));
                }
            }
            _ => {}
        }
    }

    /// What damping does in a piece; around a tick it is the same in every piece.
    fn decay<M: Integrator>(&self, piece: Piece<T>) -> Decay<T> {
        let Terms { decay, damping, course, .. } = self.terms;
        if !M::DAMPS_INSIDE || piece.length == course.substep() {
            return *decay;
        }
        damping.map_or(Decay::none(piece.length), |damping| damping.factors(piece.length))
    }
}
