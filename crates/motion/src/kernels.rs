//! The arithmetic of a tick on contiguous rows: checked before it is committed, dispatched at run time to the
//! machine's vector instructions, with the same bits on all of them.
//!
//! A row of [`PhysicsBody`] is four lanes, (v, w), and every update is written on four lanes whose constants
//! leave the last one alone, so that one body is one 256-bit register. Four rows are computed before one is
//! stored; a row that would turn non-finite is left as it was and refused. There is no fused multiply-add:
//! it would change the bits.

use std::sync::LazyLock;

use fearless_simd::{Level, Simd, dispatch, f64x4, mask64x4, prelude::*, u8x32};

use crate::components::{AxisLocks, Force, PhysicsBody, Transform};
use crate::effects::Decay;
use crate::units::{Scalar, Vector};

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
    /// Rows that were pushed, ascending.
    pub rows: &'a [usize],
}

/// Finds the blocks that were pushed while the rows go by.
struct Pushed<'a> {
    numbers: &'a [Scalar],
    rows: &'a [usize],
    next: usize,
}

impl<'a> Pushed<'a> {
    fn new(applied: Option<Applied<'a>>, rows: usize) -> Self {
        let Applied { forces, rows: pushed } = applied.unwrap_or(Applied { forces: &[], rows: &[] });
        assert!(pushed.is_empty() || forces.len() == rows, "a force for every body");
        Self {
            numbers: bytemuck::cast_slice(forces),
            rows: pushed,
            next: pushed.first().copied().unwrap_or(usize::MAX),
        }
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
        let beyond = self.rows.iter().position(|row| *row >= end).unwrap_or(self.rows.len());
        self.rows = &self.rows[beyond..];
        self.next = self.rows.first().copied().unwrap_or(usize::MAX);
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

/// What to tell about a row that was not updated.
pub(crate) type Refuse<'a> = &'a mut dyn FnMut(usize);

/// `v keep + (F w + g) gain` for movable rows; what acts on an inverse mass of 0 is deselected, not multiplied.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accelerate {
    gravity: Vector,
    keep: Option<Scalar>,
    gain: Scalar,
}

impl Accelerate {
    pub fn new(gravity: Option<Vector>, decay: Decay) -> Self {
        // Adding 0 turns -0 into 0: a row comes out the same whether its block has a force or not.
        Self { gravity: gravity.unwrap_or(Vector::ZERO) + Vector::ZERO, keep: decay.keep, gain: decay.gain }
    }

    /// Applies the update to every row.
    pub fn run(&self, bodies: &mut [PhysicsBody], applied: Option<Applied<'_>>, refuse: Refuse<'_>) {
        let rows: &mut [Row] = bytemuck::cast_slice_mut(bodies);
        let pushed = Pushed::new(applied, rows.len());
        let level = *LEVEL;
        if self.keep.is_none() {
            dispatch!(level, simd => self.rows::<_, false>(simd, rows, pushed, refuse));
        } else {
            dispatch!(level, simd => self.rows::<_, true>(simd, rows, pushed, refuse));
        }
    }

    #[inline(always)]
    fn rows<S: Simd, const KEEP: bool>(
        &self,
        simd: S,
        rows: &mut [Row],
        mut pushed: Pushed<'_>,
        refuse: Refuse<'_>,
    ) {
        let update = self.lanes(simd);
        let mut start = 0;
        // A block is loaded one number beyond its last force, so the last block is a copied one.
        while start + BLOCK < rows.len() {
            let block = rows[start..].first_chunk_mut().expect("a whole block");
            let force = pushed.touches(start).then(|| pushed.block(start));
            let new = update.update::<KEEP>(simd, load_rows(simd, block), block, force);
            commit_rows(simd, &new, block, &mut |k| refuse(start + k));
            start += BLOCK;
        }
        let rest = rows.len() - start;
        let mut block = [[0.0; 4]; BLOCK];
        block[..rest].copy_from_slice(&rows[start..]);
        let force = pushed.touches(start).then(|| pushed.last(start));
        let new = update.update::<KEEP>(simd, load_rows(simd, &block), &block, force.as_ref());
        commit_rows(simd, &new, &mut block, &mut |k| refuse(start + k));
        rows[start..].copy_from_slice(&block[..rest]);
    }

    /// The constants of the update in registers, loaded once: stores of rows might change them in memory.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S) -> AccelerateLanes<S> {
        let Vector { x, y, z } = self.gravity;
        let keep = self.keep.unwrap_or(1.0);
        AccelerateLanes {
            gravity: lanes(simd, [x, y, z, 0.0]),
            keep: lanes(simd, [keep, keep, keep, 1.0]),
            gain: f64x4::splat(simd, self.gain),
            // No inverse mass is above infinity: the last lane, the inverse mass itself, is never accelerated.
            immovable: lanes(simd, [0.0, 0.0, 0.0, Scalar::INFINITY]),
            snap: Snap::new(simd),
        }
    }
}

#[derive(Clone, Copy)]
struct AccelerateLanes<S: Simd> {
    gravity: f64x4<S>,
    keep: f64x4<S>,
    gain: f64x4<S>,
    immovable: f64x4<S>,
    snap: Snap<S>,
}

impl<S: Simd> AccelerateLanes<S> {
    /// The new rows of a block; nothing is stored or checked.
    #[inline(always)]
    fn update<const KEEP: bool>(
        self,
        simd: S,
        mut rows: Rows<S>,
        old: &[Row; BLOCK],
        force: Option<&Triples>,
    ) -> Rows<S> {
        let mut dv = [self.gravity * self.gain; BLOCK];
        if let Some(force) = force {
            for (k, dv) in dv.iter_mut().enumerate() {
                let w = f64x4::splat(simd, old[k][3]);
                *dv = (load_triple(simd, force, k) * w + self.gravity) * self.gain;
            }
        }
        for (k, v) in rows.iter_mut().enumerate() {
            // From memory, where it stands unchanged: broadcasting it from a register takes shuffles.
            let w = f64x4::splat(simd, old[k][3]);
            // A selection, not a factor: NaN and infinity are deselected as well.
            let dv = where_true(w.simd_gt(self.immovable), dv[k]);
            *v = if KEEP { self.snap.apply(*v * self.keep + dv) } else { *v + dv };
        }
        rows
    }
}

/// `x += v h` with the factors around it, and what a single body may ask for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Move {
    h: Scalar,
    before: Option<Scalar>,
    after: Option<Scalar>,
}

impl Move {
    pub const fn new(h: Scalar, decay: Decay) -> Self {
        Self { h, before: decay.before_move, after: decay.after_move }
    }

    /// Whether a finite position does not prove a finite velocity: a factor after the move may enlarge it.
    fn grows(&self) -> bool {
        self.after.is_some_and(|k| k.abs() > 1.0)
    }

    /// Applies the update to every row.
    pub fn run(&self, transforms: &mut [Transform], bodies: &mut [PhysicsBody], refuse: Refuse<'_>) {
        let positions: &mut [Scalar] = bytemuck::cast_slice_mut(transforms);
        let rows: &mut [Row] = bytemuck::cast_slice_mut(bodies);
        assert_eq!(positions.len(), 3 * rows.len(), "a transform for every body");
        let level = *LEVEL;
        match (self.before, self.after) {
            (None, None) => {
                dispatch!(level, simd => self.rows::<_, false, false>(simd, positions, rows, refuse));
            }
            (None, Some(_)) => {
                dispatch!(level, simd => self.rows::<_, false, true>(simd, positions, rows, refuse));
            }
            (Some(_), _) => {
                dispatch!(level, simd => self.rows::<_, true, false>(simd, positions, rows, refuse));
            }
        }
    }

    /// [`Move::run`] for one body with a speed limit or axis locks of its own, in PhysX's order: clamped
    /// damping, speed limit, locks, move. `false`: it would turn non-finite and was left as it was.
    #[must_use]
    pub fn run_asking(
        &self,
        transform: &mut Transform,
        body: &mut PhysicsBody,
        limit: Option<Scalar>,
        locks: Option<&AxisLocks>,
    ) -> bool {
        let (old_transform, old_body) = (*transform, *body);
        body.velocity *= self.before.unwrap_or(1.0);
        if let Some(limit) = limit {
            // Not by the sum of squares: it overflows for speeds that are still finite.
            let speed = body.velocity.x.hypot(body.velocity.y).hypot(body.velocity.z);
            if speed > limit {
                body.velocity *= limit / speed;
            }
        }
        if let Some(locks) = locks {
            for (axis, locked) in [locks.x, locks.y, locks.z].into_iter().enumerate() {
                if locked {
                    body.velocity[axis] = 0.0;
                }
            }
        }
        let rest = Self { before: None, ..*self };
        let mut refused = false;
        let (transforms, bodies) = (std::slice::from_mut(transform), std::slice::from_mut(body));
        rest.run(transforms, bodies, &mut |_| refused = true);
        if refused {
            (transforms[0], bodies[0]) = (old_transform, old_body);
        }
        !refused
    }

    #[inline(always)]
    fn rows<S: Simd, const BEFORE: bool, const AFTER: bool>(
        &self,
        simd: S,
        positions: &mut [Scalar],
        rows: &mut [Row],
        refuse: Refuse<'_>,
    ) {
        let update = self.lanes(simd);
        let rows_len = rows.len();
        each_block(
            simd,
            positions,
            rows,
            Pushed::new(None, rows_len),
            self.grows(),
            refuse,
            #[inline(always)]
            move |x: &Triples, rows: &[Row; BLOCK], _: Option<&Triples>| {
                update.update::<BEFORE, AFTER>(load_triples(simd, x), load_rows(simd, rows))
            },
        );
    }

    /// The constants of the update in registers.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S) -> MoveLanes<S> {
        let factor = |factor: Option<Scalar>| {
            let k = factor.unwrap_or(1.0);
            lanes(simd, [k, k, k, 1.0])
        };
        MoveLanes {
            h: lanes(simd, [self.h, self.h, self.h, 0.0]),
            before: factor(self.before),
            after: factor(self.after),
            snap: Snap::new(simd),
        }
    }
}

#[derive(Clone, Copy)]
struct MoveLanes<S: Simd> {
    h: f64x4<S>,
    before: f64x4<S>,
    after: f64x4<S>,
    snap: Snap<S>,
}

impl<S: Simd> MoveLanes<S> {
    /// The new positions and rows of a block; nothing is stored or checked.
    #[inline(always)]
    fn update<const BEFORE: bool, const AFTER: bool>(
        self,
        mut x: Rows<S>,
        mut rows: Rows<S>,
    ) -> (Rows<S>, Rows<S>) {
        for (x, v) in x.iter_mut().zip(&mut rows) {
            if BEFORE {
                *v = self.snap.apply(*v * self.before);
            }
            *x += *v * self.h;
            if AFTER {
                *v = self.snap.apply(*v * self.after);
            }
        }
        (x, rows)
    }
}

/// Both updates in one pass over memory, the velocity's first or the position's first: the same arithmetic on
/// the same registers, so the same bits as one after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OnePass {
    pub accelerate: Accelerate,
    pub advance: Move,
    /// Explicit Euler: the position moves with the old velocity.
    pub position_first: bool,
}

impl OnePass {
    /// Applies both updates to every row.
    pub fn run(
        &self,
        transforms: &mut [Transform],
        bodies: &mut [PhysicsBody],
        applied: Option<Applied<'_>>,
        refuse: Refuse<'_>,
    ) {
        let x: &mut [Scalar] = bytemuck::cast_slice_mut(transforms);
        let rows: &mut [Row] = bytemuck::cast_slice_mut(bodies);
        assert_eq!(x.len(), 3 * rows.len(), "a transform for every body");
        let pushed = Pushed::new(applied, rows.len());
        let level = *LEVEL;
        match (self.accelerate.keep, self.advance.before, self.advance.after) {
            (Some(_), ..) => {
                dispatch!(level, simd => self.rows::<_, true, false, false>(simd, x, rows, pushed, refuse));
            }
            (None, Some(_), _) => {
                dispatch!(level, simd => self.rows::<_, false, true, false>(simd, x, rows, pushed, refuse));
            }
            (None, None, Some(_)) => {
                dispatch!(level, simd => self.rows::<_, false, false, true>(simd, x, rows, pushed, refuse));
            }
            (None, None, None) => {
                dispatch!(level, simd => self.rows::<_, false, false, false>(simd, x, rows, pushed, refuse));
            }
        }
    }

    #[inline(always)]
    fn rows<S: Simd, const KEEP: bool, const BEFORE: bool, const AFTER: bool>(
        &self,
        simd: S,
        x: &mut [Scalar],
        rows: &mut [Row],
        pushed: Pushed<'_>,
        refuse: Refuse<'_>,
    ) {
        let (accelerate, advance) = (self.accelerate.lanes(simd), self.advance.lanes(simd));
        if self.position_first {
            each_block(
                simd,
                x,
                rows,
                pushed,
                true,
                refuse,
                #[inline(always)]
                move |x: &Triples, rows: &[Row; BLOCK], force: Option<&Triples>| {
                    let (x, v) = (load_triples(simd, x), load_rows(simd, rows));
                    let (x, v) = advance.update::<BEFORE, AFTER>(x, v);
                    (x, accelerate.update::<KEEP>(simd, v, rows, force))
                },
            );
        } else {
            each_block(
                simd,
                x,
                rows,
                pushed,
                self.advance.grows(),
                refuse,
                #[inline(always)]
                move |x: &Triples, rows: &[Row; BLOCK], force: Option<&Triples>| {
                    let v = accelerate.update::<KEEP>(simd, load_rows(simd, rows), rows, force);
                    advance.update::<BEFORE, AFTER>(load_triples(simd, x), v)
                },
            );
        }
    }
}

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
        } else {
            refuse(k);
        }
    }
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
        } else {
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
