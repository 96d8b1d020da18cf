//! Both updates in one pass over memory.

use fearless_simd::{Simd, dispatch};

use super::{
    Accelerate, Applied, BLOCK, LEVEL, Move, Pushed, Refuse, Row, Triples, each_block, load_rows,
    load_triples,
};
use crate::components::{PhysicsBody, Transform};
use crate::units::Scalar;

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
        dispatch!(level, simd => self.run_with(simd, x, rows, pushed, refuse));
    }

    /// [`OnePass::run`] with the instructions of `simd`.
    #[inline(always)]
    pub(super) fn run_with<S: Simd>(
        &self,
        simd: S,
        x: &mut [Scalar],
        rows: &mut [Row],
        pushed: Pushed<'_>,
        refuse: Refuse<'_>,
    ) {
        match (self.accelerate.keep, self.advance.before, self.advance.after) {
            (Some(_), ..) => self.rows::<_, true, false, false>(simd, x, rows, pushed, refuse),
            (None, Some(_), _) => self.rows::<_, false, true, false>(simd, x, rows, pushed, refuse),
            (None, None, Some(_)) => self.rows::<_, false, false, true>(simd, x, rows, pushed, refuse),
            (None, None, None) => self.rows::<_, false, false, false>(simd, x, rows, pushed, refuse),
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
