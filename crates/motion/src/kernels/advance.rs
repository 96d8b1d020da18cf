//! `x += v h` with the factors around it, and what a single body may ask for.

use fearless_simd::{Simd, dispatch, f64x4};

use super::{
    BLOCK, LEVEL, Pushed, Refuse, Row, Rows, SNAP, Snap, Triples, each_block, lanes, load_rows, load_triples,
};
use crate::components::{AxisLocks, PhysicsBody, Transform};
use crate::effects::Decay;
use crate::units::{Scalar, Vector};

/// `x += v h` with the factors around it, and what a single body may ask for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Move {
    h: Scalar,
    pub(super) before: Option<Scalar>,
    pub(super) after: Option<Scalar>,
}

impl Move {
    pub const fn new(h: Scalar, decay: Decay) -> Self {
        Self { h, before: decay.before_move, after: decay.after_move }
    }

    /// Whether a finite position does not prove a finite velocity: a factor after the move may enlarge it.
    pub(super) fn grows(&self) -> bool {
        self.after.is_some_and(|k| k.abs() > 1.0 || k.is_nan())
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
        if let Some(factor) = self.before {
            let decayed = body.velocity * factor;
            body.velocity =
                Vector::from_array(decayed.to_array().map(|v| if v.abs() < SNAP { 0.0 } else { v }));
        }
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
    pub(super) fn lanes<S: Simd>(&self, simd: S) -> MoveLanes<S> {
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
pub(super) struct MoveLanes<S: Simd> {
    h: f64x4<S>,
    before: f64x4<S>,
    after: f64x4<S>,
    snap: Snap<S>,
}

impl<S: Simd> MoveLanes<S> {
    /// The new positions and rows of a block; nothing is stored or checked.
    #[inline(always)]
    pub(super) fn update<const BEFORE: bool, const AFTER: bool>(
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
