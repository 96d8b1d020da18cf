//! Closed forms of the largest stable steps.

use motion::{DampingModel, Method};

use crate::rigs::{Matrix, by_columns, step_matrix};

/// How an oscillator is damped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damped {
    /// Damping ratio zeta, at least 0: a rate of `2 zeta` for a frequency of 1.
    pub ratio: f64,
    /// Model of damping; `None` for a law of linear drag.
    pub model: Option<DampingModel>,
}

impl Damped {
    /// An oscillator damped by a law of linear drag.
    pub const fn by_drag(ratio: f64) -> Self {
        Self { ratio, model: None }
    }
}

/// Eigenvalues of two rows: both real, or real and imaginary part of a pair.
pub(super) enum Eigenvalues {
    Real(f64, f64),
    Pair(f64, f64),
}

pub(super) fn eigenvalues([[a, b], [c, d]]: Matrix) -> Eigenvalues {
    let (middle, apart) = ((a + d) / 2.0, (a - d) / 2.0);
    let discriminant = apart * apart + b * c;
    if discriminant < 0.0 {
        Eigenvalues::Pair(middle, (-discriminant).sqrt())
    } else {
        Eigenvalues::Real(middle - discriminant.sqrt(), middle + discriminant.sqrt())
    }
}

/// Largest magnitude of an eigenvalue.
pub(super) fn radius(tick: Matrix) -> f64 {
    match eigenvalues(tick) {
        Eigenvalues::Real(a, b) => a.abs().max(b.abs()),
        Eigenvalues::Pair(re, im) => re.hypot(im),
    }
}

/// The two Eulers with damping inside: `keep` and `gain` of the kick, factors before and after the move.
fn euler(method: Method, h: f64, [keep, gain, before, after]: [f64; 4]) -> Matrix {
    let image = |x: f64, v: f64| {
        let a = -x;
        if method == Method::ExplicitEuler {
            let moved = before * v;
            [x + h * moved, keep * after * moved + gain * a]
        } else {
            let moved = before * (keep * v + gain * a);
            [x + h * moved, after * moved]
        }
    };
    by_columns([image(1.0, 0.0), image(0.0, 1.0)])
}

/// One step with a model of damping inside it, of the two Eulers that have one inside.
fn damped_step(method: Method, model: DampingModel, h: f64, c: f64) -> Matrix {
    let q = c * h;
    let factors = match model {
        DampingModel::Tutorial => [1.0, h, 1.0, 1.0 - q],
        DampingModel::Clamped => [1.0, h, (1.0 - q).max(0.0), 1.0],
        DampingModel::Implicit => [1.0, h, (1.0 + q).recip(), 1.0],
        DampingModel::Exact => [(-q).exp(), -(-q).exp_m1() / c, 1.0, 1.0],
    };
    euler(method, h, factors)
}

/// The largest stable w h of one oscillator, where the characteristic polynomial of its step first leaves the unit
/// circle; 0 if no step is stable, infinite if every step is. Known for the two explicit Eulers with a model of
/// damping, and for every method with drag.
pub fn oscillator_limit(method: Method, damped: Damped) -> f64 {
    let c = 2.0 * damped.ratio;
    let z = damped.ratio;
    match (method, damped.model) {
        (Method::ImplicitEuler, _) => f64::INFINITY,
        (Method::ExplicitEuler, None | Some(DampingModel::Tutorial)) if z <= 1.0 => 2.0 * z,
        (Method::ExplicitEuler, None | Some(DampingModel::Tutorial)) => {
            2.0 / (z + (z * z - 1.0).sqrt())
        }
        (Method::ExplicitEuler, Some(DampingModel::Exact)) => 2.0 * z,
        (Method::ExplicitEuler, Some(DampingModel::Clamped)) if z >= 0.25 => f64::INFINITY,
        (Method::ExplicitEuler, Some(DampingModel::Clamped)) => {
            (1.0 - (1.0 - 16.0 * z * z).sqrt()) / (4.0 * z)
        }
        (Method::SemiImplicitEuler, None | Some(DampingModel::Tutorial))
        | (Method::PositionVerlet, None) => 2.0 * ((1.0 + z * z).sqrt() - z),
        (method, Some(model)) => first_unstable(|h| damped_step(method, model, h, c)),
        (method, None) if c == 0.0 => method.claims().stability_limit,
        (method, None) => first_unstable(|h| step_matrix(method, h, [1.0, c])),
    }
}

/// Where the spectral radius of a formula first exceeds 1.
fn first_unstable(step: impl Fn(f64) -> Matrix) -> f64 {
    let stable = |h: f64| radius(step(h)) <= 1.0 + 1e-12;
    let (mut low, mut high) = (0.0, 0.01);
    while stable(high) {
        (low, high) = (high, high * 1.002);
        if high > 1e3 {
            return f64::INFINITY;
        }
    }
    for _ in 0..50 {
        let middle = f64::midpoint(low, high);
        if stable(middle) { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Damped limits as they were measured elsewhere, to 5 digits.
    #[test]
    fn closed_forms_have_the_known_values() {
        let ratios = [0.05, 0.2, 0.5, 1.0, 2.0];
        let known = [
            (Method::RungeKutta2Heun, [0.8000, 1.3939, 2.0, 2.0, 0.5359]),
            (Method::RungeKutta4, [2.9098, 2.9401, 2.6225, 2.7853, 0.7463]),
            (Method::ExplicitEuler, [0.1, 0.4, 1.0, 2.0, 0.5359]),
        ];
        for (method, limits) in known {
            for (ratio, limit) in ratios.into_iter().zip(limits) {
                let found = oscillator_limit(method, Damped::by_drag(ratio));
                assert!((found - limit).abs() <= 6e-5, "{method:?} {ratio}: {found} for {limit}");
            }
        }
    }

    #[test]
    fn the_formulas_agree_with_the_polynomials() {
        for ratio in [0.0, 0.05, 0.2, 0.5, 1.0, 2.0] {
            let damped = Damped::by_drag(ratio);
            let found =
                first_unstable(|h| step_matrix(Method::SemiImplicitEuler, h, [1.0, 2.0 * ratio]));
            let closed = oscillator_limit(Method::SemiImplicitEuler, damped);
            assert!((found / closed - 1.0).abs() <= 1e-6, "{ratio}: {found} {closed}");
        }
        for ratio in [0.05, 0.2] {
            for model in DampingModel::ALL {
                let damped = Damped { ratio, model: Some(model) };
                for method in [Method::ExplicitEuler, Method::SemiImplicitEuler] {
                    let found = first_unstable(|h| damped_step(method, model, h, 2.0 * ratio));
                    let closed = oscillator_limit(method, damped);
                    let equal = found == closed || (found / closed - 1.0).abs() <= 1e-6;
                    assert!(equal, "{method:?} {damped:?}: {found} {closed}");
                }
            }
        }
        // z tanh(zeta z) = 4 zeta.
        let exact = oscillator_limit(
            Method::SemiImplicitEuler,
            Damped { ratio: 0.5, model: Some(DampingModel::Exact) },
        );
        assert!((exact * (0.5 * exact).tanh() - 2.0).abs() <= 1e-6);
    }
}
