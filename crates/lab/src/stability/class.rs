//! Classifies a run by its numbers.

use scene::Bounds;
use serde::{Deserialize, Serialize};

use crate::cost::larger;

/// The class of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Exact to rounding throughout.
    Exact,
    /// Within the bound throughout.
    Bounded,
    /// Beyond the bound.
    Drifts,
    /// A conserved quantity has decreased by more than the bound at the end.
    Decays,
    /// Beyond all bounds, or not finite.
    Explodes,
    /// The method cannot solve what the scene declares, or the run that it is compared with failed earlier.
    Refused,
}

impl Class {
    /// All of them, the best first.
    pub const ALL: [Self; 6] =
        [Self::Exact, Self::Bounded, Self::Drifts, Self::Decays, Self::Explodes, Self::Refused];

    /// Its name in tables and files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Bounded => "bounded",
            Self::Drifts => "drifts",
            Self::Decays => "decays",
            Self::Explodes => "explodes",
            Self::Refused => "refused",
        }
    }
}

/// A class and the number that decided it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// The class.
    pub class: Class,
    /// The number that decided: the last one of a run that decays, else the one of the largest magnitude.
    pub number: f64,
    /// The bound on its magnitude.
    pub bound: f64,
}

/// The numbers that decide the class of a run. A NaN stays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extremes {
    /// The number of the largest magnitude so far, with its sign.
    pub largest: f64,
    /// The last number.
    pub last: f64,
}

impl Extremes {
    /// Takes in the next number.
    pub fn look(&mut self, number: f64) {
        (self.largest, self.last) = (larger(self.largest, number), number);
    }

    /// The verdict on a run with these numbers. Comparisons with NaN are false, so a run with a NaN has exploded.
    pub fn verdict(&self, bounds: &Bounds) -> Verdict {
        let size = self.largest.abs();
        let finite = size <= bounds.explodes;
        let (class, number, bound) = if !finite {
            (Class::Explodes, self.largest, bounds.explodes)
        } else if size <= bounds.exact {
            (Class::Exact, self.largest, bounds.exact)
        } else if size <= bounds.bounded {
            (Class::Bounded, self.largest, bounds.bounded)
        } else if self.last < -bounds.bounded {
            (Class::Decays, self.last, bounds.bounded)
        } else {
            (Class::Drifts, self.largest, bounds.bounded)
        };
        Verdict { class, number, bound }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds { exact: 1e-9, bounded: 0.5, explodes: 1e3 };

    fn verdict(numbers: &[f64]) -> (Class, f64, f64) {
        let mut extremes = Extremes::default();
        numbers.iter().for_each(|number| extremes.look(*number));
        let Verdict { class, number, bound } = extremes.verdict(&BOUNDS);
        (class, number, bound)
    }

    #[test]
    fn a_class_follows_from_the_largest_number_and_the_last() {
        for (numbers, expected) in [
            (&[][..], (Class::Exact, 0.0, 1e-9)),
            (&[1e-12, -1e-9], (Class::Exact, -1e-9, 1e-9)),
            (&[1.1e-9, 0.0], (Class::Bounded, 1.1e-9, 0.5)),
            (&[0.1, -0.5, 0.2], (Class::Bounded, -0.5, 0.5)),
            (&[0.1, 0.6, 0.2], (Class::Drifts, 0.6, 0.5)),
            // The number was beyond the bound, but within it at the end: that is no loss.
            (&[-0.6, -0.4], (Class::Drifts, -0.6, 0.5)),
            (&[0.9, -0.7], (Class::Decays, -0.7, 0.5)),
            (&[-1.5, -1.0], (Class::Decays, -1.0, 0.5)),
            (&[1e3], (Class::Drifts, 1e3, 0.5)),
            (&[-1e3], (Class::Decays, -1e3, 0.5)),
            (&[1.0, 1001.0, 0.0], (Class::Explodes, 1001.0, 1e3)),
            (&[-1001.0], (Class::Explodes, -1001.0, 1e3)),
            (&[f64::INFINITY, 0.0], (Class::Explodes, f64::INFINITY, 1e3)),
        ] {
            assert_eq!(verdict(numbers), expected, "{numbers:?}");
        }
    }

    #[test]
    fn what_is_not_a_number_explodes_and_is_never_forgotten() {
        for numbers in [
            &[f64::NAN][..],
            &[0.0, f64::NAN, 0.0],
            &[f64::NAN, 2e3],
            &[f64::INFINITY, f64::NAN, 1.0],
        ] {
            let (class, number, _) = verdict(numbers);
            assert!(
                class == Class::Explodes && !number.is_finite(),
                "{numbers:?}: {class:?} {number}"
            );
        }
    }
}
