//! What hangs at rest stays at rest, also far from the origin.

use glam::DVec3;
use motion::internals::Solver;
use motion::{Damping, DampingModel, Method, Request};

use crate::rigs::{Environment, Lab, Net, Start, chain, elastic, net::H};

const G: f64 = 9.8;

/// L13: 20 links, 0.1 kg, 100 N/m; every link carries what hangs below it.
fn hanging_chain() -> Net {
    let (links, k, mass, length) = (20, 100.0, 0.1, 0.1);
    let mut net = chain(links, k, length, mass);
    let mut y = 0.0;
    for (i, body) in net.bodies.iter_mut().enumerate().skip(1) {
        y -= length + (links - i + 1) as f64 * mass * G / k;
        body.x = DVec3::Y * y;
    }
    net
}

/// L14: 10 by 10 points of 0.02 kg, 20 N/m, with shear springs, hung up by two corners.
fn cloth() -> Net {
    let n = 10;
    let number = |i: usize, j: usize| i * n + j;
    let place = |i: usize, j: usize| DVec3::new(j as f64 * 0.1, i as f64 * -0.1, 0.0);
    let start = |point: usize| {
        let (i, j) = (point / n, point % n);
        let held = i == 0 && (j == 0 || j == n - 1);
        if held { Start::held(place(i, j)) } else { Start::of(0.02, place(i, j), DVec3::ZERO) }
    };
    let mut springs = Vec::new();
    for i in 0..n {
        for j in 0..n {
            for (di, dj) in [(0, 1), (1, 0), (1, 1)] {
                if i + di < n && j + dj < n {
                    let length = 0.1 * ((di + dj) as f64).sqrt();
                    springs.push(([number(i, j), number(i + di, j + dj)], elastic(20.0, length)));
                }
            }
            if i + 1 < n && j > 0 {
                springs.push((
                    [number(i, j), number(i + 1, j - 1)],
                    elastic(20.0, 0.1 * 2.0_f64.sqrt()),
                ));
            }
        }
    }
    Net { bodies: (0..n * n).map(start).collect(), springs }
}

/// The net at rest: long implicit steps, each from rest.
fn settled(net: &Net) -> Net {
    let solver = Some(Solver { tolerance: 1e-14, most_iterations: 2000, newton_iterations: 0 });
    let mut rig =
        net.lab(&Environment { solver, ..Environment::falling() }, Method::ImplicitEuler, 2.0);
    for _ in 0..60 {
        rig.run(1);
        for body in rig.bodies.clone() {
            rig.ask(Request::SetVelocity(body, DVec3::ZERO));
        }
    }
    let mut net = net.clone();
    net.bodies.iter_mut().zip(rig.states()).for_each(|(body, (x, _))| body.x = x);
    net
}

/// Largest kinetic energy in each tenth of a run, J.
fn jiggle(rig: &mut Lab, ticks: u64) -> [f64; 10] {
    [0; 10].map(|_| {
        let mut most = 0.0_f64;
        for _ in 0..ticks / 1000 {
            rig.run(100);
            let now = rig.totals().kinetic_energy;
            most = if now <= most { most } else { now };
        }
        most
    })
}

fn stays(name: &str, net: &Net, mass: f64, ticks: u64) {
    for far in [DVec3::ZERO, DVec3::new(1e5, -1e5, 1e5)] {
        let net = net.clone().moved(far);
        let damped = Environment {
            damping: Some(Damping { model: DampingModel::default(), rate: 0.4 }),
            ..Environment::falling()
        };
        for (around, growth) in [(Environment::falling(), 20.0), (damped, 3.0)] {
            let tenths = jiggle(&mut net.lab(&around, Method::default(), H), ticks);
            let bound = 1e-9 * mass * G * 0.1;
            let still = tenths.iter().all(|most| *most <= bound);
            assert!(still, "{name} at {far}: {tenths:?}, at most {bound:e}");
            // Rounding stirs, step by step: without damping the energy is that of a random walk, which grows with
            // the time, tenfold here; with damping it does not grow.
            let start = tenths[0].max(tenths[1]);
            assert!(tenths[9] <= growth * start, "{name} at {far}: {tenths:?}");
        }
    }
}

#[test]
fn a_hanging_chain_stays_at_rest_for_100_000_ticks() {
    stays("chain", &hanging_chain(), 0.1, 100_000);
}

#[test]
fn a_cloth_stays_at_rest_for_20_000_ticks() {
    let net = settled(&cloth());
    // At rest no force is left.
    let forces = net.forces(&net.start());
    for (body, force) in net.bodies.iter().zip(&forces).filter(|(body, _)| body.w > 0.0) {
        let left = (*force - DVec3::Y * (G / body.w)).length();
        assert!(left <= 1e-11, "{left:e} N at {}", body.x);
    }
    stays("cloth", &net, 0.02, 20_000);
}
