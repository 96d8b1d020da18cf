//! The field of a block of bodies, in registers.

use fearless_simd::{Simd, f64x4, prelude::*};

use super::lanes::{Rows, each_row};
use super::{BLOCK, TickParameters};
use crate::laws::damping::{Decay, SNAP};
use crate::methods::Field;
use crate::simd::Lanes as _;
use crate::state::components::AxisLocks;

/// Parts of the arithmetic that a kernel is compiled with; parts that are left out cost nothing.
pub(crate) mod parts {
    /// Exact damping inside the kick.
    pub const KEEP: u8 = 1;
    /// A factor before the move.
    pub const BEFORE: u8 = 2;
    /// A factor after the move.
    pub const AFTER: u8 = 4;
    /// Linear drag.
    pub const DRAG: u8 = 8;
}

use parts::{AFTER, BEFORE, DRAG, KEEP};

/// Numbers that are the same for every body of a batch, in registers: loaded once, because the compiler must assume
/// that stores of rows change memory.
pub(crate) struct Constants<S: Simd> {
    simd: S,
    gravity: f64x4<S>,
    rate: f64x4<S>,
    keep: f64x4<S>,
    /// Factor before the move.
    pub before: f64x4<S>,
    /// Factor after the move.
    pub after: f64x4<S>,
    immovable: f64x4<S>,
    /// Mask of the last lane alone.
    last_lane: <f64x4<S> as SimdBase<S>>::Mask,
    least: f64x4<S>,
    gain: f64,
    h: f64,
}

impl<S: Simd> Clone for Constants<S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd> Copy for Constants<S> {}

impl<S: Simd> Constants<S> {
    #[inline(always)]
    pub fn new(simd: S, parameters: &TickParameters<'_>) -> Self {
        let three =
            |number: f64, fourth: f64| f64x4::simd_from(simd, [number, number, number, fourth]);
        let factor = |factor: Option<f64>| three(factor.unwrap_or(1.0), 1.0);
        let [x, y, z] = parameters.gravity.to_array();
        let Decay { keep, gain, before_move, after_move } = parameters.decay;
        let decays = parameters.decay.multiplies() || parameters.rate > 0.0;
        Self {
            simd,
            // Adding 0 turns -0 into 0: a row gets the same bits whether its block has a force or not.
            gravity: f64x4::simd_from(simd, [x + 0.0, y + 0.0, z + 0.0, 0.0]),
            rate: three(parameters.rate, 0.0),
            keep: factor(keep),
            before: factor(before_move),
            after: factor(after_move),
            // No inverse mass is above infinity, so the last lane, the inverse mass itself, is never accelerated.
            immovable: three(0.0, f64::INFINITY),
            last_lane: three(0.0, 1.0).simd_gt(f64x4::splat(simd, 0.0)),
            // No inverse mass is below 0, so the last lane is never snapped; neither are velocities that do not decay.
            least: three(if decays { SNAP } else { 0.0 }, 0.0),
            gain,
            h: parameters.times.substep(),
        }
    }

    /// The lanes of a row that are accelerated: those of the velocity, if the body is movable.
    #[inline(always)]
    pub fn movable(&self, body: &[f64; 4]) -> <f64x4<S> as SimdBase<S>>::Mask {
        // From memory: broadcasting a lane of a register takes shuffles.
        f64x4::splat(self.simd, body[3]).simd_gt(self.immovable)
    }

    /// The number of bodies of a block that can be accelerated. One test detects the usual case that all can.
    #[inline(always)]
    pub fn count_movable(&self, block: &[[f64; 4]; BLOCK]) -> u64 {
        let mut all = self.movable(&block[0]);
        each_row!(k in BLOCK {
            all &= self.movable(&block[k]);
        });
        // The last lane of a row is never accelerated.
        if (all | self.last_lane).all_true() { BLOCK as u64 } else { Self::count_one_by_one(block) }
    }

    #[cold]
    fn count_one_by_one(block: &[[f64; 4]; BLOCK]) -> u64 {
        block.iter().filter(|body| body[3] > 0.0).count() as u64
    }

    /// Sets velocities that decayed below [`SNAP`] to 0.
    #[inline(always)]
    pub fn snap<const N: usize>(&self, mut v: Rows<S, N>) -> Rows<S, N> {
        each_row!(k in N {
            // Selected by `<`, which is false for NaN: NaN must stay, to be found.
            v.0[k] = v.0[k].except(v.0[k].abs().simd_lt(self.least));
        });
        v
    }

    /// `v` times a factor of damping.
    #[inline(always)]
    pub fn times<const N: usize>(&self, mut v: Rows<S, N>, factor: f64x4<S>) -> Rows<S, N> {
        each_row!(k in N {
            v.0[k] *= factor;
        });
        self.snap(v)
    }
}

/// Applies a speed limit and axis locks to a row.
pub(crate) fn restrain([x, y, z, _]: &mut [f64; 4], limit: Option<f64>, locks: Option<AxisLocks>) {
    if let Some(limit) = limit {
        // Not by the sum of squares, which overflows for speeds that are still finite.
        let speed = libm::hypot(libm::hypot(*x, *y), *z);
        // Not `speed > limit`: a limit of NaN must be found, not skipped.
        let is_allowed = speed <= limit;
        if !is_allowed {
            let factor = limit / speed;
            (*x, *y, *z) = (*x * factor, *y * factor, *z * factor);
        }
    }
    if let Some(locks) = locks {
        for (v, locked) in [(x, locks.x), (y, locks.y), (z, locks.z)] {
            if locked {
                *v = 0.0;
            }
        }
    }
}

/// The field of the `N` bodies of a block in registers.
pub(crate) struct RowField<S: Simd, const N: usize, const PARTS: u8, const PUSHED: bool> {
    pub constants: Constants<S>,
    movable: [<f64x4<S> as SimdBase<S>>::Mask; N],
    applied: Rows<S, N>,
    /// Evaluations so far.
    pub evaluations: u64,
}

impl<S: Simd, const N: usize, const PARTS: u8, const PUSHED: bool> RowField<S, N, PARTS, PUSHED> {
    /// The field of `bodies`, (velocity, inverse mass) each, with `forces` if they are pushed.
    #[inline(always)]
    pub fn new(
        constants: Constants<S>,
        bodies: &[[f64; 4]; N],
        forces: Option<&Rows<S, N>>,
    ) -> Self {
        let simd = constants.simd;
        // A selection, not a factor: NaN times 0 would be NaN.
        let mut movable = [constants.immovable.simd_gt(constants.immovable); N];
        let mut applied = Rows::splat(f64x4::splat(simd, 0.0));
        each_row!(k in N {
            movable[k] = constants.movable(&bodies[k]);
            if PUSHED && let Some(forces) = forces {
                let w = f64x4::splat(simd, bodies[k][3]);
                applied.0[k] = (forces.0[k] * w).only(movable[k]);
            }
        });
        Self { constants, movable, applied, evaluations: 0 }
    }
}

impl<S: Simd, const N: usize, const PARTS: u8, const PUSHED: bool> Field
    for RowField<S, N, PARTS, PUSHED>
{
    type Space = Rows<S, N>;

    #[inline(always)]
    fn step(&self) -> f64 {
        self.constants.h
    }

    #[inline(always)]
    fn laws(&mut self, _: f64, _: Self::Space, v: Self::Space) -> Self::Space {
        self.evaluations += 1;
        let mut a: Self::Space = Rows::splat(self.constants.gravity);
        each_row!(k in N {
            if PARTS & DRAG != 0 {
                a.0[k] -= v.0[k] * self.constants.rate;
            }
            a.0[k] = a.0[k].only(self.movable[k]);
        });
        a
    }

    #[inline(always)]
    fn applied(&self) -> Self::Space {
        self.applied
    }

    #[inline(always)]
    fn plus_applied(&self, a: Self::Space) -> Self::Space {
        if PUSHED { a + self.applied } else { a }
    }

    #[inline(always)]
    fn depends_on_velocity(&self) -> bool {
        PARTS & DRAG != 0
    }

    #[inline(always)]
    fn is_constant(&self) -> bool {
        PARTS & DRAG == 0
    }

    #[inline(always)]
    fn kick(&mut self, v: Self::Space, a: Self::Space) -> Self::Space {
        let mut kicked = v;
        let Constants { keep, gain, .. } = self.constants;
        each_row!(k in N {
            let kept = if PARTS & KEEP != 0 { v.0[k] * keep } else { v.0[k] };
            kicked.0[k] = kept + a.0[k] * gain;
        });
        if PARTS & (KEEP | DRAG) != 0 { self.constants.snap(kicked) } else { kicked }
    }

    #[inline(always)]
    fn before_move(&mut self, v: Self::Space) -> Self::Space {
        if PARTS & BEFORE != 0 { self.constants.times(v, self.constants.before) } else { v }
    }

    #[inline(always)]
    fn after_move(&mut self, v: Self::Space) -> Self::Space {
        if PARTS & AFTER != 0 { self.constants.times(v, self.constants.after) } else { v }
    }

    /// The closed form for affine laws.
    #[inline(always)]
    fn implicit_velocity(&mut self, x: Self::Space, v: Self::Space) -> Self::Space {
        let Constants { h, rate, .. } = self.constants;
        v + self.acceleration(1.0, x, v) * (h / (1.0 + <[f64; 4]>::from(rate)[0] * h))
    }
}
