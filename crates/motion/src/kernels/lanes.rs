//! Blocks of rows in registers, as a space for methods.
//!
//! Loops instead of closures: a closure that is not inlined is compiled without the vector instructions of its
//! caller, and passes registers through memory.

use std::ops::{Add, Mul, Sub};

use fearless_simd::{Simd, f64x4, prelude::*};

/// Repeats code for each row of a block of at most four. Not a loop: a loop is unrolled only after the compiler has
/// decided to keep the rows in memory.
macro_rules! each_row {
    ($k:ident in $n:tt $(- $less:literal)? $body:block) => {
        $crate::kernels::lanes::each_row!(@at 0, $k in $n $(- $less)?, $body);
        $crate::kernels::lanes::each_row!(@at 1, $k in $n $(- $less)?, $body);
        $crate::kernels::lanes::each_row!(@at 2, $k in $n $(- $less)?, $body);
        $crate::kernels::lanes::each_row!(@at 3, $k in $n $(- $less)?, $body);
    };
    (@at $at:literal, $k:ident in $n:expr, $body:block) => {
        if $at < $n {
            let $k = $at;
            $body
        }
    };
}
pub(crate) use each_row;

/// The rows of `N` bodies, four lanes each: (x, y, z, anything) or (velocity, inverse mass).
pub(crate) struct Rows<S: Simd, const N: usize>(pub [f64x4<S>; N]);

impl<S: Simd, const N: usize> Clone for Rows<S, N> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd, const N: usize> Copy for Rows<S, N> {}

impl<S: Simd, const N: usize> Rows<S, N> {
    /// Loads `N` rows.
    #[inline(always)]
    pub fn of(simd: S, rows: &[[f64; 4]; N]) -> Self {
        let mut lanes = [f64x4::splat(simd, 0.0); N];
        each_row!(k in N {
            lanes[k] = f64x4::simd_from(simd, rows[k]);
        });
        Self(lanes)
    }

    /// `lanes` in every row.
    #[inline(always)]
    pub fn splat(lanes: f64x4<S>) -> Self {
        Self([lanes; N])
    }

    /// The rows in memory.
    #[inline(always)]
    pub fn rows(self) -> [[f64; 4]; N] {
        let mut rows = [[0.0; 4]; N];
        each_row!(k in N {
            rows[k] = self.0[k].into();
        });
        rows
    }
}

impl<S: Simd, const N: usize> Add for Rows<S, N> {
    type Output = Self;

    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        each_row!(k in N {
            self.0[k] += other.0[k];
        });
        self
    }
}

impl<S: Simd, const N: usize> Sub for Rows<S, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        each_row!(k in N {
            self.0[k] -= other.0[k];
        });
        self
    }
}

impl<S: Simd, const N: usize> Mul<f64> for Rows<S, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, factor: f64) -> Self {
        each_row!(k in N {
            self.0[k] *= factor;
        });
        self
    }
}
