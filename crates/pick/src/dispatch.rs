//! The hot loops, compiled once for every processor and once for those with AVX2.

use bevy_ecs::entity::Entity;

use crate::columns::{self, Known, Positions, Rows, Writing};
use crate::scan::{Balls, Beam};

/// Defines `$name`, which runs `$body` as it was compiled for what the processor has. The bodies are `inline(always)`,
/// so that each copy is compiled with the features of the function around it; the results are the same to the bit.
macro_rules! dispatched {
    ($name:ident ( $($argument:ident : $type:ty),* ) -> $result:ty, $body:expr) => {
        pub(crate) fn $name($($argument: $type),*) -> $result {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn with_avx2($($argument: $type),*) -> $result {
                    $body($($argument),*)
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    #[expect(unsafe_code, reason = "the one way to call a function compiled for more than the baseline")]
                    // SAFETY: the processor has AVX2, as was asked on the line before.
                    return unsafe { with_avx2($($argument),*) };
                }
            }
            $body($($argument),*)
        }
    };
}

dispatched!(
    next_block(beam: &Beam, balls: Balls<'_>, from: usize, limit: f32) -> Option<usize>,
    Beam::next_block
);

dispatched!(
    write(to: Positions<'_>, rows: Rows<'_>, writing: Writing) -> usize,
    columns::write
);

dispatched!(
    next_moved(known: Known<'_>, rows: Rows<'_>, alpha: f64, from: usize) -> Option<usize>,
    columns::next_moved
);

dispatched!(same(known: &[Entity], now: &[Entity]) -> bool, same_in_full);

/// Whether `known` starts with what is there `now`.
///
/// No early end: comparing all of it in vectors is faster than stopping at a difference that is rare.
#[inline(always)]
fn same_in_full(known: &[Entity], now: &[Entity]) -> bool {
    known.iter().zip(now).fold(0, |off, (a, b)| off | (a.to_bits() ^ b.to_bits())) == 0
}
