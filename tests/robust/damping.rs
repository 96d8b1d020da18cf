//! The default damping gives every step rate the same speed; the tutorial's gives each its own, by its formula.

use crate::rigs::Bare;
use glam::DVec3;
use motion::{Damping, DampingModel, Method};

use crate::rigs::pull;

const RATES_HZ: [u32; 4] = [30, 60, 120, 240];

/// Speed after 2 s of coasting from 10 m/s, or of falling from rest, by semi-implicit Euler.
fn speed(damping: Damping, hz: u32, falls: bool) -> f64 {
    let mut bare = Bare::new(Method::SemiImplicitEuler, 1.0 / f64::from(hz)).with_damping(damping);
    if falls {
        bare = bare.with_law(pull(DVec3::X * 9.8));
    }
    let start = if falls { 0.0 } else { 10.0 };
    bare.add([0.0; 3], [start, 0.0, 0.0], 1.0);
    (0..2 * hz).for_each(|_| bare.tick());
    bare.bodies[0][0]
}

/// Largest relative distance of two of them.
fn spread(speeds: [f64; 4]) -> f64 {
    let most = speeds.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let least = speeds.into_iter().fold(f64::INFINITY, f64::min);
    (most - least) / most.abs()
}

#[test]
fn exact_damping_is_the_same_at_every_rate() {
    for rate in [0.4, 30.0] {
        for falls in [false, true] {
            let damping = Damping { model: DampingModel::Exact, rate };
            let exact = if falls {
                9.8 / rate * -(-2.0 * rate).exp_m1()
            } else {
                10.0 * (-2.0 * rate).exp()
            };
            let speeds = RATES_HZ.map(|hz| speed(damping, hz, falls));
            assert!(spread(speeds) <= 1e-12, "{rate} {falls}: {speeds:?}");
            assert!(
                (speeds[3] / exact - 1.0).abs() <= 1e-12,
                "{rate} {falls}: {speeds:?}, not {exact}"
            );
        }
    }
}

#[test]
fn the_damping_of_the_tutorial_is_its_formula_at_every_rate() {
    for rate in [0.4, 30.0] {
        for falls in [false, true] {
            for hz in RATES_HZ {
                let damping = Damping { model: DampingModel::Tutorial, rate };
                let (n, h) = (2 * hz, 1.0 / f64::from(hz));
                let d = 1.0 - rate * h;
                let power = d.powi(n.cast_signed());
                // v' = (v + a h) d from rest, or v' = v d; nothing is left where the factor is 0.
                let exact =
                    if falls { 9.8 * h * d * (1.0 - power) / (rate * h) } else { 10.0 * power };
                let found = speed(damping, hz, falls);
                assert!(
                    (found - exact).abs() <= 1e-12 * exact.abs(),
                    "{rate} {falls} {hz}: {found} {exact}"
                );
            }
        }
    }
}
