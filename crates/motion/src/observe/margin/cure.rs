//! The largest stable step of a linear system, and the changes that would make an unstable one stable.

use super::modes::{Oscillators, Stepping};
use super::{Cure, LimitingPart, Margin};
use crate::methods::table::Method;
use crate::state::substeps::Substeps;
use crate::units::Scalar;

/// A linear system of parts that do not act on each other. It is stable if all of them are.
#[derive(Clone, Debug)]
pub(super) struct LinearSystem {
    parts: Vec<Oscillators>,
    /// An oscillator that is nearly as fast as the fastest mode: the search for the limit starts at its limit.
    guess: Option<Oscillators>,
}

/// Smallest limits: of one oscillator or a method of order 1, and of several oscillators under any other method. Below them
/// no step counts as stable. At shorter steps the growth of Runge-Kutta 2 is below the tolerance for rounding.
const SMALLEST_LIMITS: [Scalar; 2] = [5e-3, 0.05];

/// The search for limits ends at this value and at its reciprocal.
const LARGEST_LIMIT: Scalar = 1e6;

impl LinearSystem {
    /// A system of one oscillator.
    pub fn one(modes: Oscillators) -> Self {
        Self { parts: vec![modes], guess: None }
    }

    /// A system of oscillators that do not act on each other.
    pub const fn apart(parts: Vec<Oscillators>) -> Self {
        Self { parts, guess: None }
    }

    /// A system of oscillators that act on each other; `fastest` is the fastest one alone.
    pub fn joined(modes: Oscillators, fastest: Oscillators) -> Self {
        Self { parts: vec![modes], guess: Some(fastest) }
    }

    pub fn is_stable(&self, stepping: Stepping) -> bool {
        self.parts.iter().all(|modes| modes.is_stable(stepping))
    }

    fn growth(&self, stepping: Stepping) -> Scalar {
        self.parts.iter().map(|modes| modes.growth(stepping)).fold(0.0, Scalar::max)
    }

    /// The value at which the system becomes unstable, where `value` is that of the current tick; 0 if no tick is
    /// stable, infinite if every tick is.
    pub fn limit(&self, stepping: Stepping, value: Scalar) -> Scalar {
        if value <= 0.0 {
            return Scalar::INFINITY;
        }
        if !value.is_finite() {
            return 0.0;
        }
        let longer = |value_then: Scalar| Stepping {
            tick: stepping.tick * (value_then / value),
            ..stepping
        };
        let is_first_order = stepping.method.claims().velocity_order == 1
            && stepping.method.claims().position_order == 1;
        let least = SMALLEST_LIMITS[usize::from(self.guess.is_some() && !is_first_order)];
        let stable = |value| self.is_stable(longer(value));
        let found = match &self.guess {
            None => bracket(&stable, 1.25, value.max(least)),
            Some(guess) => {
                let alone = |value| guess.is_stable(longer(value));
                let near = bracket(&alone, 1.25, value.max(least));
                let near = near
                    .and_then(|[low, high]| (low > least).then(|| halved(&alone, low, high, 8)));
                bracket(&stable, 1.1, near.unwrap_or(value).clamp(least, LARGEST_LIMIT))
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

    /// The margin of the system. The fastest mode has at least `value` and at most `at_most`. `is_linear` says whether the growth
    /// is that of the motion.
    pub fn margin(
        &self,
        part: LimitingPart,
        bodies: usize,
        value: Scalar,
        at_most: Scalar,
        stepping: Stepping,
        is_linear: bool,
    ) -> Margin {
        let is_stable = self.is_stable(stepping);
        let growth_per_tick = if is_stable { 1.0 } else { self.growth(stepping) };
        let growth_per_s = libm::pow(growth_per_tick, 1.0 / stepping.tick);
        let limit = self.limit(stepping, value);
        // A mode faster by this factor is stable at the current steps if this one is stable at steps longer by it.
        let longer = Stepping { tick: stepping.tick * at_most.max(value) / value, ..stepping };
        let Stepping { method, substeps, .. } = stepping;
        let cure = Cure::default();
        let margin = Margin {
            part,
            bodies,
            method,
            substeps,
            value,
            at_most,
            limit,
            is_linear,
            growth_per_s,
            growth_per_tick,
            cure,
        };
        if margin.is_unstable() || margin.may_be_unstable() {
            Margin { cure: self.cure(longer, limit > 0.0), ..margin }
        } else {
            margin
        }
    }

    fn cure(&self, stepping: Stepping, has_limit: bool) -> Cure {
        let stable = |method: &Method| {
            let is_solvable = stepping.may_be_implicit || *method != Method::ImplicitEuler;
            is_solvable && self.is_stable(Stepping { method: *method, ..stepping })
        };
        let method = as_good_as(stepping.method).find(stable);
        let substeps = if has_limit { self.substeps(stepping) } else { None };
        Cure { substeps, error: None, method }
    }

    /// The smallest stable number of substeps above the current one.
    fn substeps(&self, stepping: Stepping) -> Option<u32> {
        let stable = |substeps| self.is_stable(Stepping { substeps, ..stepping });
        let (mut low, mut high) = (stepping.substeps, stepping.substeps);
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

/// The methods whose order is not lower than that of `method`, in the order of the table, and then implicit Euler.
pub fn as_good_as(method: Method) -> impl Iterator<Item = Method> {
    let claims = method.claims();
    let as_good = move |method: &Method| {
        let other = method.claims();
        other.position_order >= claims.position_order
            && other.velocity_order >= claims.velocity_order
    };
    Method::ALL.into_iter().filter(as_good).chain([Method::ImplicitEuler])
}

/// Finds a stable value and an unstable one, a factor of `by` apart, starting from `start`. The second is infinite if
/// no value is unstable; `None` if no value is stable.
fn bracket(stable: &dyn Fn(Scalar) -> bool, by: Scalar, start: Scalar) -> Option<[Scalar; 2]> {
    let mut here = start;
    if stable(here) {
        loop {
            let next = here * by;
            if !stable(next) {
                return Some([here, next]);
            }
            if next >= LARGEST_LIMIT.max(start * LARGEST_LIMIT) {
                return Some([here, Scalar::INFINITY]);
            }
            here = next;
        }
    }
    while here > 1.0 / LARGEST_LIMIT {
        let next = here / by;
        if stable(next) {
            return Some([next, here]);
        }
        here = next;
    }
    None
}

/// The stable end of an interval after bisecting it `times` times.
fn halved(
    stable: &dyn Fn(Scalar) -> bool,
    mut low: Scalar,
    mut high: Scalar,
    times: u32,
) -> Scalar {
    if high.is_infinite() {
        return low;
    }
    for _ in 0..times {
        let middle = low.midpoint(high);
        if stable(middle) { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use bevy_ecs::prelude::*;

    use super::*;

    /// The margin of an oscillator of which `w h` is known to be between two numbers, at 60 Hz.
    fn margin([value, at_most]: [Scalar; 2]) -> Margin {
        let stepping = Stepping {
            method: Method::SemiImplicitEuler,
            tick: 1.0 / 60.0,
            substeps: 1,
            may_be_implicit: true,
        };
        let w = value * 60.0;
        let part = LimitingPart::Damping(Entity::PLACEHOLDER);
        let system = LinearSystem::one(Oscillators::one(w * w, 0.0, None));
        system.margin(part, 1, value, at_most, stepping, true)
    }

    #[test]
    fn a_cure_is_that_of_the_largest_value_that_is_possible() {
        // `w h` is below 2 from 8 substeps on where it is 15, and from 6 on where it is 11.
        let [known, least, most] =
            [[11.0, 15.0], [11.0; 2], [15.0; 2]].map(|known| margin(known).cure);
        assert_eq!(known, most);
        assert_eq!([least, most].map(|cure| cure.substeps), [Some(6), Some(8)]);
    }

    #[test]
    fn an_interval_with_the_limit_in_it_is_neither_stable_nor_unstable() {
        let undecided = margin([1.99, 2.01]);
        assert!(!undecided.is_unstable() && undecided.may_be_unstable(), "{undecided:?}");
        assert_eq!(undecided.cure.substeps, Some(2));
        for (known, is_unstable) in [([1.98, 1.99], false), ([2.01, 2.02], true)] {
            let margin = margin(known);
            assert!(margin.is_unstable() == is_unstable && !margin.may_be_unstable(), "{margin:?}");
            assert_eq!(margin.cure != Cure::default(), is_unstable);
        }
    }
}
