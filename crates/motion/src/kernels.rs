//! The arithmetic of a tick on contiguous rows: checked before it is committed, dispatched at run time to the
//! machine's vector instructions, with the same bits on all of them.
//!
//! A row of [`PhysicsBody`] is four lanes, (v, w), and every update is written on four lanes whose constants
//! leave the last one alone, so that one body is one 256-bit register. Four rows are computed before one is
//! stored; a row that would turn non-finite is left as it was and refused. There is no fused multiply-add:
//! it would change the bits.

mod accelerate;
mod advance;
mod one_pass;

use std::sync::LazyLock;

use fearless_simd::{Level, Simd, f64x4, mask64x4, prelude::*, u8x32};

use crate::components::Force;
use crate::units::Scalar;

pub(crate) use accelerate::Accelerate;
pub(crate) use advance::Move;
pub(crate) use one_pass::OnePass;

/// Velocity components below this snap to zero where they decay, m/s. Damping would otherwise end in subnormal
/// numbers and stay there for good, and those run many times slower.
pub(crate) const SNAP: Scalar = 1e-290;

/// Rows that are computed before the first of them is stored.
const BLOCK: usize = 4;

/// What the machine offers; asking costs more than stepping one body.
static LEVEL: LazyLock<Level> = LazyLock::new(Level::new);

type Row = [Scalar; 4];

type Rows<S> = [f64x4<S>; BLOCK];

/// The first of four rows of three numbers that lie behind each other, and one number beyond: each row is
/// loaded as four lanes, and nobody looks at the last.
type Triples = [Scalar; 3 * BLOCK + 1];

const NO_TRIPLES: Triples = [0.0; 3 * BLOCK + 1];

/// The forces of a table and the rows that have one; all other rows are zero and are not looked at.
#[derive(Clone, Copy)]
pub(crate) struct Applied<'a> {
    /// The column of the table.
    pub forces: &'a [Force],
    /// Table and row of the bodies of this table that were pushed, rows ascending.
    pub rows: &'a [(usize, usize)],
}

/// Finds the blocks that were pushed while the rows go by.
struct Pushed<'a> {
    numbers: &'a [Scalar],
    rows: &'a [(usize, usize)],
    next: usize,
}

impl<'a> Pushed<'a> {
    fn new(applied: Option<Applied<'a>>, rows: usize) -> Self {
        let Applied { forces, rows: pushed } = applied.unwrap_or(Applied { forces: &[], rows: &[] });
        assert!(pushed.is_empty() || forces.len() == rows, "a force for every body");
        Self { numbers: bytemuck::cast_slice(forces), rows: pushed, next: first_row(pushed) }
    }

    /// Whether a row of the block at `start` was pushed. Blocks are asked for in order.
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
        let beyond = self.rows.iter().position(|(_, row)| *row >= end).unwrap_or(self.rows.len());
        self.rows = &self.rows[beyond..];
        self.next = first_row(self.rows);
    }

    /// The forces of a whole block and one number beyond.
    #[inline(always)]
    fn block(&self, start: usize) -> &'a Triples {
        self.numbers[3 * start..].first_chunk().expect("a row lies beyond the block")
    }

    /// The forces of the rows from `start` to the end of the table, at most a block.
    fn last(&self, start: usize) -> Triples {
        let mut force = NO_TRIPLES;
        let rest = &self.numbers[3 * start..];
        force[..rest.len()].copy_from_slice(rest);
        force
    }
}

fn first_row(rows: &[(usize, usize)]) -> usize {
    rows.first().map_or(usize::MAX, |(_, row)| *row)
}

/// What to tell about a row that was not updated.
pub(crate) type Refuse<'a> = &'a mut dyn FnMut(usize);

/// Updates positions and rows block by block: computed, checked, then stored.
#[inline(always)]
fn each_block<S: Simd>(
    simd: S,
    positions: &mut [Scalar],
    rows: &mut [Row],
    mut pushed: Pushed<'_>,
    check_v: bool,
    refuse: Refuse<'_>,
    update: impl Fn(&Triples, &[Row; BLOCK], Option<&Triples>) -> (Rows<S>, Rows<S>),
) {
    let mut start = 0;
    // A block is loaded one number beyond its last row, so the last block is a copied one.
    while start + BLOCK < rows.len() {
        let block = rows[start..].first_chunk_mut().expect("a whole block");
        let x = positions[3 * start..].first_chunk_mut().expect("a whole block and a number");
        let force = pushed.touches(start).then(|| pushed.block(start));
        let (new_x, new_v) = update(x, block, force);
        commit(simd, &new_x, &new_v, x, block, check_v, &mut |k| refuse(start + k));
        start += BLOCK;
    }
    let (mut x, mut block) = (NO_TRIPLES, [[0.0; 4]; BLOCK]);
    let rest = rows.len() - start;
    x[..3 * rest].copy_from_slice(&positions[3 * start..]);
    block[..rest].copy_from_slice(&rows[start..]);
    let force = pushed.touches(start).then(|| pushed.last(start));
    let (new_x, new_v) = update(&x, &block, force.as_ref());
    commit(simd, &new_x, &new_v, &mut x, &mut block, check_v, &mut |k| refuse(start + k));
    positions[3 * start..].copy_from_slice(&x[..3 * rest]);
    rows[start..].copy_from_slice(&block[..rest]);
}

/// Stores the positions and rows that stayed finite and refuses the others.
#[inline(always)]
fn commit<S: Simd>(
    simd: S,
    new_x: &Rows<S>,
    new_v: &Rows<S>,
    x: &mut Triples,
    rows: &mut [Row; BLOCK],
    check_v: bool,
    refuse: Refuse<'_>,
) {
    if all_finite(simd, new_x) && (!check_v || all_finite(simd, new_v)) {
        // In this order: the last lane of a row is the first number of the next, which is stored after it.
        for k in 0..BLOCK - 1 {
            new_x[k].store_slice(&mut x[3 * k..3 * k + 4]);
        }
        let [a, b, c, _] = <Row>::from(new_x[BLOCK - 1]);
        x[3 * BLOCK - 3..3 * BLOCK].copy_from_slice(&[a, b, c]);
        for k in 0..BLOCK {
            new_v[k].store_slice(&mut rows[k]);
        }
        return;
    }
    for k in 0..BLOCK {
        let [a, b, c, _] = <Row>::from(new_x[k]);
        let v = <Row>::from(new_v[k]);
        if [a, b, c].into_iter().chain(v).all(Scalar::is_finite) {
            x[3 * k..3 * k + 3].copy_from_slice(&[a, b, c]);
            rows[k] = v;
        } else if is_movable(&rows[k]) {
            refuse(k);
        }
    }
}

/// An immovable row that an update would spoil (damping that is not a number) is left alone, not refused; so
/// are the rows of inverse mass 0 that fill the last block up and belong to nobody.
fn is_movable(row: &Row) -> bool {
    row[3] > 0.0
}

/// Stores the rows that stayed finite and refuses the others.
#[inline(always)]
fn commit_rows<S: Simd>(simd: S, new: &Rows<S>, rows: &mut [Row; BLOCK], refuse: Refuse<'_>) {
    if all_finite(simd, new) {
        for k in 0..BLOCK {
            new[k].store_slice(&mut rows[k]);
        }
        return;
    }
    for k in 0..BLOCK {
        let new = <Row>::from(new[k]);
        if new.into_iter().all(Scalar::is_finite) {
            rows[k] = new;
        } else if is_movable(&rows[k]) {
            refuse(k);
        }
    }
}

#[inline(always)]
fn lanes<S: Simd>(simd: S, row: Row) -> f64x4<S> {
    row.simd_into(simd)
}

#[inline(always)]
fn load_rows<S: Simd>(simd: S, rows: &[Row; BLOCK]) -> Rows<S> {
    [lanes(simd, rows[0]), lanes(simd, rows[1]), lanes(simd, rows[2]), lanes(simd, rows[3])]
}

#[inline(always)]
fn load_triples<S: Simd>(simd: S, x: &Triples) -> Rows<S> {
    [load_triple(simd, x, 0), load_triple(simd, x, 1), load_triple(simd, x, 2), load_triple(simd, x, 3)]
}

#[inline(always)]
fn load_triple<S: Simd>(simd: S, numbers: &Triples, k: usize) -> f64x4<S> {
    f64x4::from_slice(simd, &numbers[3 * k..3 * k + 4])
}

/// `true` proves that every number is finite. Sums of numbers near the largest one may deny it: the rows are
/// then looked at one by one.
#[inline(always)]
fn all_finite<S: Simd>(simd: S, rows: &Rows<S>) -> bool {
    let sum = (rows[0] + rows[1]) + (rows[2] + rows[3]);
    sum.abs().simd_le(f64x4::splat(simd, Scalar::MAX)).all_true()
}

/// `v` where the mask holds, 0 elsewhere: one instruction, where a selection between two takes two.
#[inline(always)]
fn where_true<S: Simd>(mask: mask64x4<S>, v: f64x4<S>) -> f64x4<S> {
    (mask.bitcast::<u8x32<S>>() & v.bitcast::<u8x32<S>>()).bitcast()
}

/// Snaps the velocity lanes of rows that decayed.
#[derive(Clone, Copy)]
struct Snap<S: Simd> {
    least: f64x4<S>,
}

impl<S: Simd> Snap<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        // No inverse mass is below 0: the last lane is never snapped.
        Self { least: lanes(simd, [SNAP, SNAP, SNAP, 0.0]) }
    }

    #[inline(always)]
    fn apply(self, v: f64x4<S>) -> f64x4<S> {
        // Not "where it is at least": NaN is not, and has to stay to be found.
        where_true(!v.abs().simd_lt(self.least), v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::{PhysicsBody, Transform};
    use crate::effects::{Damping, DampingModel};
    use crate::units::Vector;

    /// Positions and rows after `ticks` of one pass with the instructions of `simd`.
    fn after<S: Simd>(simd: S, damping: Damping, ticks: usize) -> (Vec<Scalar>, Vec<Row>) {
        let decay = damping.factors(1.0 / 120.0);
        let update = OnePass {
            accelerate: Accelerate::new(Some(Vector::new(0.1, -9.8, 1e-3)), decay),
            advance: Move::new(1.0 / 120.0, decay),
            position_first: false,
        };
        let numbers = |i: usize| Vector::new(0.1 * i as Scalar, 1.0 / (i + 1) as Scalar, -3.7);
        let mut transforms: Vec<_> = (0..11).map(|i| Transform::at(numbers(i))).collect();
        let mut bodies: Vec<_> = (0..11)
            .map(|i| PhysicsBody { velocity: numbers(i + 5), inverse_mass: i as Scalar / 3.0 })
            .collect();
        let forces: Vec<_> = (0..11).map(|i| Force(numbers(i + 2))).collect();
        for _ in 0..ticks {
            let applied = Applied { forces: &forces, rows: &[1, 2, 7, 10].map(|row| (0, row)) };
            let (x, rows) =
                (bytemuck::cast_slice_mut(&mut transforms), bytemuck::cast_slice_mut(&mut bodies));
            update.run_with(simd, x, rows, Pushed::new(Some(applied), 11), &mut |row| {
                panic!("row {row} refused")
            });
        }
        (bytemuck::cast_slice(&transforms).to_vec(), bytemuck::cast_slice(&bodies).to_vec())
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        for model in DampingModel::ALL {
            let damping = Damping { model, rate: 0.4 };
            let plain = after(fearless_simd::Fallback::new(), damping, 200);
            #[cfg(target_arch = "x86_64")]
            {
                let level = Level::new();
                assert_eq!(
                    level.as_sse4_2().map(|simd| after(simd, damping, 200)).unwrap_or(plain.clone()),
                    plain
                );
                assert_eq!(
                    level.as_avx2().map(|simd| after(simd, damping, 200)).unwrap_or(plain.clone()),
                    plain
                );
            }
            assert!(plain.0.iter().all(|x| x.is_finite()));
        }
    }
}
