//! A largest stable step, how it was judged, and how it is found.

/// How a run is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// It exceeds a thousand times its start within a number of ticks.
    Amplitude,
    /// The spectral radius of one tick is above 1: of oscillators whose runs grow too slowly for a bound.
    SpectralRadius,
    /// Energy grows in one tick: of nets that grow too slowly for a bound.
    Energy,
}

/// One largest stable step.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// The system that was stepped.
    pub system: String,
    /// Name of the method.
    pub method: &'static str,
    /// The criterion of stability.
    pub criterion: Criterion,
    /// The largest stable w h that was found, w being the largest frequency without damping: 0 if no step is stable,
    /// infinite if every step up to 1e6 is.
    pub measured: f64,
    /// The largest stable w h by the closed form.
    pub theory: f64,
}

impl Limit {
    /// Difference of `measured` from `theory`, relative to it; 0 if both are infinite.
    pub fn relative_difference(&self) -> f64 {
        if self.measured == self.theory { 0.0 } else { self.measured / self.theory - 1.0 }
    }
}

/// The largest stable value: from `start` up in steps of `by`, and of 10 beyond 10, then by halving to 1 in 5,000.
/// Infinite if all up to 1e6 are stable, 0 if `start` is not.
pub(super) fn largest_stable(start: f64, by: f64, mut stable: impl FnMut(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, start);
    while stable(high) {
        (low, high) = (high, high * if high > 10.0 { 10.0 } else { by });
        if high > 1e6 {
            return f64::INFINITY;
        }
    }
    if low == 0.0 {
        return 0.0;
    }
    bisect([low, high], 2e-4, stable)
}

/// The largest stable value between a stable and an unstable one, to a relative `precision`.
pub(super) fn bisect(
    [mut low, mut high]: [f64; 2],
    precision: f64,
    mut stable: impl FnMut(f64) -> bool,
) -> f64 {
    while high - low > precision * high {
        let middle = f64::midpoint(low, high);
        if stable(middle) { low = middle } else { high = middle }
    }
    f64::midpoint(low, high)
}
