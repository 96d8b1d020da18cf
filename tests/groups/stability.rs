//! How long a step a net of springs takes: 2 / w, and what the other methods have in place of the 2.

use glam::DVec3;
use motion::{METHODS, Method};

use crate::rigs::{Dice, Environment, Lab, Net, Start, elastic};

const LINKS: usize = 10;

/// A chain from a post, of springs without a rest length: linear in three dimensions. Moved at random.
fn chain(masses: &[f64]) -> Net {
    let mut dice = Dice(3);
    let bodies = masses.iter().map(|mass| Start::of(*mass, dice.vector(), DVec3::ZERO));
    Net {
        bodies: std::iter::once(Start::held(DVec3::ZERO)).chain(bodies).collect(),
        springs: (0..masses.len()).map(|i| ([i, i + 1], elastic(100.0, 0.0))).collect(),
    }
}

/// Largest w of a chain from a post, 1/s: by power iteration on `M^-1 K`.
fn largest_frequency(masses: &[f64]) -> f64 {
    let n = masses.len();
    let mut d: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { 1.0 } else { -0.9 }).collect();
    let mut squared = 0.0;
    for _ in 0..20_000 {
        let pull = |i: usize| {
            let before = if i == 0 { 0.0 } else { d[i - 1] };
            let after = d.get(i + 1).map_or(0.0, |after| d[i] - after);
            100.0 * (d[i] - before + after) / masses[i]
        };
        let product: Vec<f64> = (0..n).map(pull).collect();
        squared = product.iter().map(|p| p.abs()).fold(0.0, f64::max);
        d = product.iter().map(|p| p / squared).collect();
    }
    squared.sqrt()
}

/// Whether a chain stays below a thousand times its size.
fn holds(net: &Net, method: Method, h: f64) -> bool {
    let mut rig = net.lab(&Environment::default(), method, h);
    let size = |rig: &Lab| (1..=LINKS).map(|body| rig.x(body).length()).fold(0.0, f64::max);
    let start = size(&rig);
    (0..40).all(|_| {
        rig.run(100);
        size(&rig) < 1e3 * start
    })
}

#[test]
fn the_largest_frequency_is_that_of_the_closed_form() {
    let closed = 2.0 * 10.0 * (std::f64::consts::PI / (2.0 * LINKS as f64 + 1.0)).cos();
    let found = largest_frequency(&[1.0; LINKS]);
    assert!((found / closed - 1.0).abs() <= 1e-9, "{found} for {closed}");
}

#[test]
fn a_chain_holds_up_to_the_limit_of_the_method_and_no_further() {
    for last in [1.0, 1e6, 1e-3, 1e-6] {
        let mut masses = [1.0; LINKS];
        masses[LINKS - 1] = last;
        let (net, w) = (chain(&masses), largest_frequency(&masses));
        for claims in METHODS.iter().filter(|claims| claims.stability_limit > 0.0) {
            let method = claims.method;
            if claims.stability_limit.is_infinite() {
                assert!(
                    [0.1, 10.0, 1e3, 1e6].into_iter().all(|z| holds(&net, method, z / w)),
                    "{method:?}"
                );
                continue;
            }
            let limit = claims.stability_limit / w;
            for (part, expected) in [(0.998, true), (1.002, false)] {
                let holds = holds(&net, method, limit * part);
                assert_eq!(holds, expected, "{method:?} at {part} of its limit, last mass {last}");
            }
        }
    }
}

#[test]
fn methods_without_a_limit_win_energy_at_every_step() {
    let net = chain(&[1.0; LINKS]);
    for (method, z, grows) in [
        (Method::ExplicitEuler, 0.1, 1e3),
        (Method::RungeKutta2Midpoint, 1.0, 1e3),
        (Method::RungeKutta2Heun, 1.0, 1e3),
    ] {
        let mut rig =
            net.lab(&Environment::default(), method, z / largest_frequency(&[1.0; LINKS]));
        let start = rig.energy();
        rig.run(4000);
        assert!(rig.energy() > grows * start, "{method:?}");
    }
}
