//! Vector instructions of the machine, chosen at run time.

use std::sync::LazyLock;

use fearless_simd::{Level, Simd, f64x4, prelude::*, u8x32};

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

/// [`vectorize`] for arithmetic on `numbers` numbers: for few, choosing instructions takes longer than the arithmetic.
#[inline(always)]
pub(crate) fn vectorize_many<R>(numbers: usize, arithmetic: impl FnOnce() -> R) -> R {
    const FEW: usize = 64;
    if numbers < FEW { arithmetic() } else { vectorize(arithmetic) }
}

/// Evaluates an expression with the vector instructions of the machine: on x86 AVX2, or else none, because every
/// instruction set is a copy of the code. It gives the same bits on every machine.
macro_rules! with_simd {
    ($simd:ident => $do:expr) => {{
        #[cfg(target_arch = "x86_64")]
        {
            if let Some($simd) = $crate::simd::LEVEL.as_avx2() {
                $simd.vectorize(
                    #[inline(always)]
                    || $do,
                )
            } else {
                let $simd = fearless_simd::Fallback::new();
                $do
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            let level = *$crate::simd::LEVEL;
            fearless_simd::dispatch!(level, $simd => $do)
        }
    }};
}
pub(crate) use with_simd;

/// Four numbers in a register: the row of a body.
pub(crate) trait Lanes<S: Simd>: SimdFloat<S, Element = f64> {
    /// Keeps the lanes where the mask holds and sets the others to 0: one instruction, where a select takes two.
    #[must_use]
    fn only(self, mask: Self::Mask) -> Self;
    /// Sets the lanes to 0 where the mask holds and keeps the others.
    #[must_use]
    fn except(self, mask: Self::Mask) -> Self;
    /// Whether all lanes are +0.
    fn is_zero(self) -> bool;
}

impl<S: Simd> Lanes<S> for f64x4<S> {
    #[inline(always)]
    fn only(self, mask: Self::Mask) -> Self {
        (mask.bitcast::<u8x32<S>>() & self.bitcast::<u8x32<S>>()).bitcast()
    }

    #[inline(always)]
    fn except(self, mask: Self::Mask) -> Self {
        self.only(!mask)
    }

    #[inline(always)]
    fn is_zero(self) -> bool {
        // By bits: one instruction, where a comparison of numbers takes three.
        self.bitcast::<u8x32<S>>().simd_eq(0).all_true()
    }
}
