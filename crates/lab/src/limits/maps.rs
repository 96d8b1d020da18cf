//! Maps of what a step does to an oscillator: one panel per method.

use motion::Method;

use super::oscillator::Oscillator;
use super::theory::{Damped, Eigenvalues, Matrix, eigenvalues, oscillator_limit};

/// What becomes of an oscillator in the long run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LongRun {
    /// It swings on for ever.
    Keeps,
    /// It swings less and less.
    Decays,
    /// It comes to rest without a swing.
    Creeps,
    /// It comes to rest and changes sign at every step, which no oscillator does.
    Flips,
    /// It grows.
    Grows,
}

impl LongRun {
    /// Every class.
    pub const ALL: [Self; 5] = [Self::Keeps, Self::Decays, Self::Creeps, Self::Flips, Self::Grows];

    /// The class of an oscillator from the matrix of one tick.
    pub fn of(tick: Matrix) -> Self {
        // Where real eigenvalues meet, rounding moves them by its square root.
        let (size, least, swings, rounding) = match eigenvalues(tick) {
            Eigenvalues::Pair(re, im) => (re.hypot(im), re, true, 1e-12),
            Eigenvalues::Real(low, high) => (low.abs().max(high.abs()), low, false, 1e-7),
        };
        if size.is_nan() || size > 1.0 + rounding {
            Self::Grows
        } else if size >= 1.0 - rounding && swings {
            Self::Keeps
        } else if swings {
            Self::Decays
        } else if least < -rounding {
            Self::Flips
        } else {
            Self::Creeps
        }
    }

    /// Its name in a legend.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Keeps => "swings on",
            Self::Decays => "swings less and less",
            Self::Creeps => "comes to rest without a swing",
            Self::Flips => "comes to rest, flipping at every step",
            Self::Grows => "grows",
        }
    }
}

/// A map: classes by step and by something else, for every method.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The title of the map.
    pub title: String,
    /// Labels of the axes, with units.
    pub axes: [String; 2],
    /// Middles of the cells along the first axis and along the second, in equal ratios.
    pub places: [Vec<f64>; 2],
    /// One panel per method.
    pub panels: Vec<Panel>,
}

/// The panel of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// The method.
    pub method: Method,
    /// Classes, row by row of the second axis.
    pub classes: Vec<LongRun>,
    /// Points of the line beyond which the closed form says that it grows.
    pub theory: Vec<(f64, f64)>,
}

/// `n` values in equal ratios.
fn ratios(low: f64, high: f64, n: u32) -> Vec<f64> {
    (0..n).map(|i| low * (high / low).powf((f64::from(i) + 0.5) / f64::from(n))).collect()
}

/// Step against stiffness, without damping: `side` cells per axis.
pub fn stiffness_map(side: u32) -> Map {
    let damped = Damped::by_drag(0.0);
    map(
        "Step against stiffness, no damping",
        [("step h, s", (1e-4, 1.0)), ("stiffness over mass k / m, 1/s²", (1.0, 1e8))],
        side,
        |method, h, k| Oscillator { method, damped }.tick(k, h),
        |method, k| oscillator_limit(method, damped) / k.sqrt(),
    )
}

/// Step against damping by linear drag, of an oscillator of frequency w: `side` cells per axis.
pub fn damping_map(side: u32) -> Map {
    map(
        "Step against damping by linear drag",
        [("w h", (0.02, 20.0)), ("damping ratio c / 2w", (0.01, 10.0))],
        side,
        |method, h, ratio| Oscillator { method, damped: Damped::by_drag(ratio) }.tick(1.0, h),
        |method, ratio| oscillator_limit(method, Damped::by_drag(ratio)),
    )
}

/// A map with axes of these titles and ranges, from one tick of a method at a place and the closed form of its limit.
fn map(
    title: &str,
    axes: [(&str, (f64, f64)); 2],
    side: u32,
    tick: impl Fn(Method, f64, f64) -> Matrix,
    limit: impl Fn(Method, f64) -> f64,
) -> Map {
    let [(_, (shortest, longest)), (_, (low, high))] = axes;
    let places = axes.map(|(_, (low, high))| ratios(low, high, side));
    let panel = |method: Method| {
        let classes =
            |y: &f64| places[0].iter().map(|h| LongRun::of(tick(method, *h, *y))).collect::<Vec<_>>();
        let line = ratios(low, high, 200).into_iter().map(|y| (limit(method, y), y));
        Panel {
            method,
            classes: places[1].iter().flat_map(classes).collect(),
            theory: line.filter(|(h, _)| (shortest..=longest).contains(h)).collect(),
        }
    };
    Map {
        title: title.to_owned(),
        axes: axes.map(|(title, _)| title.to_owned()),
        panels: Method::ALL.map(panel).to_vec(),
        places,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_those_of_the_eigenvalues() {
        let (sin, cos) = 0.3_f64.sin_cos();
        let turn = |by: f64| [[by * cos, by * sin], [-by * sin, by * cos]];
        for (tick, class) in [
            (turn(1.0), LongRun::Keeps),
            (turn(0.9), LongRun::Decays),
            (turn(1.1), LongRun::Grows),
            ([[0.5, 0.0], [0.0, 0.2]], LongRun::Creeps),
            ([[0.5, 0.0], [0.0, -0.2]], LongRun::Flips),
            ([[0.5, 0.0], [0.0, -1.2]], LongRun::Grows),
            ([[f64::NAN, 0.0], [0.0, 0.0]], LongRun::Grows),
        ] {
            assert_eq!(LongRun::of(tick), class, "{tick:?}");
        }
    }
}
