//! `v keep + (F w + g) gain`: what forces, gravity and exact damping do to a velocity.

use fearless_simd::{Simd, dispatch, f64x4, prelude::*};

use super::{
    Applied, BLOCK, LEVEL, Pushed, Refuse, Row, Rows, Snap, Triples, commit_rows, lanes, load_rows,
    load_triple, where_true,
};
use crate::components::PhysicsBody;
use crate::effects::Decay;
use crate::units::{Scalar, Vector};

/// `v keep + (F w + g) gain` for movable rows; what acts on an inverse mass of 0 is deselected, not multiplied.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accelerate {
    gravity: Vector,
    pub(super) keep: Option<Scalar>,
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
    pub(super) fn lanes<S: Simd>(&self, simd: S) -> AccelerateLanes<S> {
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
pub(super) struct AccelerateLanes<S: Simd> {
    gravity: f64x4<S>,
    keep: f64x4<S>,
    gain: f64x4<S>,
    immovable: f64x4<S>,
    snap: Snap<S>,
}

impl<S: Simd> AccelerateLanes<S> {
    /// The new rows of a block; nothing is stored or checked.
    #[inline(always)]
    pub(super) fn update<const KEEP: bool>(
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
