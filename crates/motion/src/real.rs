//! The number type as a type parameter: f64 for the simulation, f32 to show what single precision costs and saves.

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};
use std::sync::LazyLock;

use bytemuck::Pod;
use fearless_simd::{Level, Simd, f32x4, f64x4, prelude::*, u8x16, u8x32};

/// The instruction set of the machine; detecting it costs more than a step of one body.
pub(crate) static LEVEL: LazyLock<Level> = LazyLock::new(Level::new);

/// Calls `arithmetic` compiled for the vector instructions of the machine. It gives the same bits on every machine: the
/// compiler reorders no sum and fuses nothing.
#[inline(always)]
pub(crate) fn vectorize<R>(arithmetic: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = LEVEL.as_avx2() {
        return simd.vectorize(arithmetic);
    }
    arithmetic()
}

/// A real number of the simulation: `f32` or `f64`.
pub trait Real:
    Pod
    + Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Sum
{
    /// Three numbers as a vector.
    type Vector: RealVector<Self>;
    /// Nine numbers as a matrix.
    type Matrix: RealMatrix<Self>;
    /// Four numbers in a register: one row of a body.
    type Lanes<S: Simd>: Lanes<S, Self>;

    /// Whether four numbers are wider than a register of 128 bits, which every supported machine has.
    const WIDE: bool;
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Positive infinity.
    const INFINITY: Self;
    /// Largest finite number.
    const MAX: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// Magnitude below which a decaying velocity component snaps to zero, m/s. Without it damping would end in
    /// subnormal numbers and stay there, and arithmetic on those is many times slower.
    const SNAP: Self;

    /// Converts from f64, rounding to nearest.
    fn of(x: f64) -> Self;
    /// Converts to f64, exactly.
    fn to_f64(self) -> f64;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Whether `self <= bound`; false for NaN.
    #[inline(always)]
    fn is_at_most(self, bound: Self) -> bool {
        self <= bound
    }
    /// Whether the number is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// `sin` by `libm`, the same on every platform.
    fn sin(self) -> Self;
    /// `cos` by `libm`, the same on every platform.
    fn cos(self) -> Self;
    /// `exp` by `libm`, the same on every platform.
    fn exp(self) -> Self;
    /// `sqrt(self² + other²)` by `libm`, accurate even where a square would overflow or underflow.
    fn hypot(self, other: Self) -> Self;
    /// `exp(self) - 1` by `libm`, without cancellation near 0.
    fn exp_m1(self) -> Self;
}

/// A vector of three numbers: glam's `DVec3` or `Vec3`.
pub trait RealVector<T>:
    Copy
    + Debug
    + Default
    + PartialEq
    + Send
    + Sync
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<T, Output = Self>
    + Neg<Output = Self>
{
    /// The zero vector.
    const ZERO: Self;
    /// From x, y, z.
    fn from_array(parts: [T; 3]) -> Self;
    /// To x, y, z.
    fn to_array(self) -> [T; 3];
    /// Converts from `DVec3`, rounding each component to nearest.
    fn of(v: glam::DVec3) -> Self;
    /// Scalar product.
    fn dot(self, other: Self) -> T;
}

/// A matrix of three by three numbers: glam's `DMat3` or `Mat3`.
pub trait RealMatrix<T: Real>:
    Copy + Debug + Default + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<T, Output = Self>
{
    /// The zero matrix.
    const ZERO: Self;
    /// The identity matrix.
    const IDENTITY: Self;
    /// From three columns.
    fn from_columns(columns: [T::Vector; 3]) -> Self;
    /// The matrix `a b^T`.
    fn outer(a: T::Vector, b: T::Vector) -> Self;
    /// `self v`.
    fn times(self, v: T::Vector) -> T::Vector;
    /// Solves `self x = v` for x; the result is not finite if the matrix is singular.
    fn solve(self, v: T::Vector) -> T::Vector;
}

/// Four numbers in a register.
pub trait Lanes<S: Simd, T>: SimdFloat<S, Element = T> {
    /// From four numbers.
    fn of(simd: S, row: [T; 4]) -> Self;
    /// To four numbers.
    fn row(self) -> [T; 4];
    /// Keeps the lanes where the mask holds and sets the others to 0: one instruction, where a select takes two.
    #[must_use]
    fn only(self, mask: Self::Mask) -> Self;
    /// Sets the lanes to 0 where the mask holds and keeps the others.
    #[must_use]
    fn except(self, mask: Self::Mask) -> Self;
    /// Whether all lanes are +0.
    fn is_zero(self) -> bool;
}

macro_rules! real {
    ($t:ident, $vector:ident, $matrix:ident, $lanes:ident, $bytes:ident, $snap:literal, $sin:ident, $cos:ident, $exp:ident, $expm1:ident, $hypot:ident) => {
        impl Real for $t {
            type Vector = glam::$vector;
            type Matrix = glam::$matrix;
            type Lanes<S: Simd> = $lanes<S>;

            const WIDE: bool = size_of::<$t>() > 4;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const INFINITY: Self = $t::INFINITY;
            const MAX: Self = $t::MAX;
            const EPSILON: Self = $t::EPSILON;
            const SNAP: Self = $snap;

            #[inline(always)]
            fn of(x: f64) -> Self {
                #[allow(clippy::cast_possible_truncation, reason = "what the function is for")]
                {
                    x as $t
                }
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $t::sqrt(self)
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
            fn sin(self) -> Self {
                libm::$sin(self)
            }
            fn cos(self) -> Self {
                libm::$cos(self)
            }
            fn exp(self) -> Self {
                libm::$exp(self)
            }
            fn hypot(self, other: Self) -> Self {
                libm::$hypot(self, other)
            }
            fn exp_m1(self) -> Self {
                libm::$expm1(self)
            }
        }

        impl RealVector<$t> for glam::$vector {
            const ZERO: Self = glam::$vector::ZERO;
            #[inline(always)]
            fn from_array(parts: [$t; 3]) -> Self {
                Self::from_array(parts)
            }
            #[inline(always)]
            fn to_array(self) -> [$t; 3] {
                Self::to_array(&self)
            }
            #[inline(always)]
            fn of(v: glam::DVec3) -> Self {
                Self::from_array(v.to_array().map(<$t as Real>::of))
            }
            #[inline(always)]
            fn dot(self, other: Self) -> $t {
                glam::$vector::dot(self, other)
            }
        }

        impl RealMatrix<$t> for glam::$matrix {
            const ZERO: Self = glam::$matrix::ZERO;
            const IDENTITY: Self = glam::$matrix::IDENTITY;
            #[inline(always)]
            fn from_columns([x, y, z]: [glam::$vector; 3]) -> Self {
                Self::from_cols(x, y, z)
            }
            #[inline(always)]
            fn outer(a: glam::$vector, b: glam::$vector) -> Self {
                Self::from_cols(a * b.x, a * b.y, a * b.z)
            }
            #[inline(always)]
            fn times(self, v: glam::$vector) -> glam::$vector {
                self * v
            }
            fn solve(self, v: glam::$vector) -> glam::$vector {
                // Cramer's rule: the next Newton iteration corrects what it loses in an ill-conditioned matrix.
                // Not `inverse`, which asserts.
                let (x, y, z) = (self.x_axis, self.y_axis, self.z_axis);
                let minors = glam::$vector::new(y.cross(z).dot(v), z.cross(x).dot(v), x.cross(y).dot(v));
                minors * (1.0 / x.dot(y.cross(z)))
            }
        }

        impl<S: Simd> Lanes<S, $t> for $lanes<S> {
            #[inline(always)]
            fn of(simd: S, row: [$t; 4]) -> Self {
                row.simd_into(simd)
            }
            #[inline(always)]
            fn row(self) -> [$t; 4] {
                self.into()
            }
            #[inline(always)]
            fn only(self, mask: Self::Mask) -> Self {
                (mask.bitcast::<$bytes<S>>() & self.bitcast::<$bytes<S>>()).bitcast()
            }
            #[inline(always)]
            fn except(self, mask: Self::Mask) -> Self {
                self.only(!mask)
            }
            #[inline(always)]
            fn is_zero(self) -> bool {
                // By bits: one instruction, where a comparison of numbers takes three.
                self.bitcast::<$bytes<S>>().simd_eq(0).all_true()
            }
        }
    };
}

real!(f64, DVec3, DMat3, f64x4, u8x32, 1e-290, sin, cos, exp, expm1, hypot);
real!(f32, Vec3, Mat3, f32x4, u8x16, 1e-30, sinf, cosf, expf, expm1f, hypotf);
