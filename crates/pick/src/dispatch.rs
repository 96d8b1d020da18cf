//! A macro that compiles hot loops once for every processor and once for processors with AVX2.

/// Defines `$name`, which runs the copy of `$body` that is compiled for the features of the processor. The bodies are
/// `inline(always)`, so that each copy is compiled with the features of the function around it; the results are the same to
/// the bit.
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

pub(crate) use dispatched;
