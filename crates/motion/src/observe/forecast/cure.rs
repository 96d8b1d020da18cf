//! Limits and cures of linear systems.

use super::modes::{Modes, Pace};
use super::{Cure, LimitingPart, Margin};
use crate::methods::table::Method;
use crate::state::substeps::Substeps;
use crate::units::Scalar;

/// What is stepped: stable if all of its parts are.
#[derive(Clone, Debug)]
pub(super) struct LinearSystem {
    parts: Vec<Modes>,
    /// One oscillator that is nearly as fast: where to look for the limit first.
    guess: Option<Modes>,
}

/// A limit below this is none: at shorter steps Runge-Kutta 2 grows by less than what passes for rounding. Of one
/// oscillator, and of several together.
const LEAST: [Scalar; 2] = [5e-3, 0.05];

/// Limits that are looked for are between this value and one over it.
const FARTHEST: Scalar = 1e6;

impl LinearSystem {
    /// One oscillator.
    pub fn one(modes: Modes) -> Self {
        Self { parts: vec![modes], guess: None }
    }

    /// Oscillators that do not act on each other.
    pub const fn apart(parts: Vec<Modes>) -> Self {
        Self { parts, guess: None }
    }

    /// Oscillators that act on each other, and the fastest without the others.
    pub fn joined(modes: Modes, fastest: Modes) -> Self {
        Self { parts: vec![modes], guess: Some(fastest) }
    }

    pub fn is_stable(&self, pace: Pace) -> bool {
        self.parts.iter().all(|modes| modes.is_stable(pace))
    }

    fn growth(&self, pace: Pace) -> Scalar {
        self.parts.iter().map(|modes| modes.growth(pace)).fold(0.0, Scalar::max)
    }

    /// The value of the longest stable tick, of which `value` is the present one; 0 for none, infinite where every tick is.
    pub fn limit(&self, pace: Pace, value: Scalar) -> Scalar {
        if value <= 0.0 {
            return Scalar::INFINITY;
        }
        if !value.is_finite() {
            return 0.0;
        }
        let longer = |value_then: Scalar| Pace { tick: pace.tick * (value_then / value), ..pace };
        let least = LEAST[usize::from(self.guess.is_some())];
        let stable = |value| self.is_stable(longer(value));
        let found = match &self.guess {
            None => bracket(&stable, 1.25, value.max(least)),
            Some(guess) => {
                let alone = |value| guess.is_stable(longer(value));
                let near = bracket(&alone, 1.25, value.max(least));
                let near = near.and_then(|[low, high]| (low > least).then(|| halved(&alone, low, high, 8)));
                bracket(&stable, 1.1, near.unwrap_or(value).clamp(least, FARTHEST))
            }
        };
        match found {
            Some([_, high]) if high.is_infinite() => Scalar::INFINITY,
            Some([low, high]) => {
                let halvings = if self.guess.is_some() { 8 } else { 24 };
                let limit = halved(&stable, low, high, halvings);
                if limit < least { 0.0 } else { limit }
            }
            None => 0.0,
        }
    }

    /// What there is to say of it.
    pub fn margin(
        &self,
        part: LimitingPart,
        bodies: usize,
        [value, at_most]: [Scalar; 2],
        pace: Pace,
        solvable: &dyn Fn(Method) -> bool,
    ) -> Margin {
        let is_unstable = !self.is_stable(pace);
        let growth_per_s = if is_unstable { libm::pow(self.growth(pace), 1.0 / pace.tick) } else { 1.0 };
        let limit = self.limit(pace, value);
        // What is that much faster is stable at these steps if this is at so much longer ones.
        let longer = Pace { tick: pace.tick * at_most.max(value) / value, ..pace };
        let cure = if is_unstable { self.cure(longer, limit > 0.0, solvable) } else { Cure::default() };
        let Pace { method, substeps, .. } = pace;
        Margin { part, bodies, method, substeps, value, at_most, limit, is_unstable, growth_per_s, cure }
    }

    fn cure(&self, pace: Pace, has_limit: bool, solvable: &dyn Fn(Method) -> bool) -> Cure {
        let claims = pace.method.claims();
        let as_good = |method: &Method| {
            let other = method.claims();
            other.position_order >= claims.position_order && other.velocity_order >= claims.velocity_order
        };
        let last = Some(Method::ImplicitEuler).into_iter();
        let method = Method::ALL
            .into_iter()
            .filter(as_good)
            .chain(last)
            .find(|method| solvable(*method) && self.is_stable(Pace { method: *method, ..pace }));
        Cure { substeps: if has_limit { self.substeps(pace) } else { None }, method }
    }

    /// The least stable number of substeps above the present one.
    fn substeps(&self, pace: Pace) -> Option<u32> {
        let stable = |substeps| self.is_stable(Pace { substeps, ..pace });
        let (mut low, mut high) = (pace.substeps, pace.substeps);
        loop {
            if high >= Substeps::MOST {
                return None;
            }
            (low, high) = (high.max(low), high.saturating_mul(2).min(Substeps::MOST));
            if stable(high) {
                break;
            }
        }
        while high - low > 1 {
            let middle = low.midpoint(high);
            if stable(middle) { high = middle } else { low = middle }
        }
        Some(high)
    }
}

/// A stable value and the next unstable one, `by` apart, looked for from `start` on: infinite where nothing is too long,
/// `None` where nothing is short enough.
fn bracket(stable: &dyn Fn(Scalar) -> bool, by: Scalar, start: Scalar) -> Option<[Scalar; 2]> {
    let mut here = start;
    if stable(here) {
        loop {
            let next = here * by;
            if !stable(next) {
                return Some([here, next]);
            }
            if next >= FARTHEST.max(start * FARTHEST) {
                return Some([here, Scalar::INFINITY]);
            }
            here = next;
        }
    }
    while here > 1.0 / FARTHEST {
        let next = here / by;
        if stable(next) {
            return Some([next, here]);
        }
        here = next;
    }
    None
}

/// The stable end of an interval that was halved so often.
fn halved(stable: &dyn Fn(Scalar) -> bool, mut low: Scalar, mut high: Scalar, times: u32) -> Scalar {
    if high.is_infinite() {
        return low;
    }
    for _ in 0..times {
        let middle = low.midpoint(high);
        if stable(middle) { low = middle } else { high = middle }
    }
    low
}
