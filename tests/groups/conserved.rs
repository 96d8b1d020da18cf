//! What springs and mutual gravity keep: momentum, angular momentum, a nearby energy, and the way back.

use glam::DVec3;
use motion::{Method, Request};

use super::orders::figure_eight;
use crate::methods::fingerprint::{determinant, exact, matrix, terms, trace};
use crate::rigs::{Environment, Lab, Net, Start, elastic, pendulum, ring, tetrahedron};

/// Most that momentum (kg m/s) and angular momentum differ from those at the start, and the sums of magnitudes.
fn drifts(rig: &mut Lab, ticks: u64) -> [[f64; 2]; 2] {
    let start = rig.totals();
    let (mut drift, mut size) = ([0.0_f64; 2], [0.0_f64; 2]);
    for _ in 0..ticks / 16 {
        rig.run(16);
        let now = rig.totals();
        let worse = |old: f64, new: f64| if new <= old { old } else { new };
        drift[0] = worse(drift[0], now.momentum.distance(start.momentum));
        drift[1] = worse(drift[1], now.angular_momentum.distance(start.angular_momentum));
        let (mut p, mut l) = (0.0, 0.0);
        for body in &rig.bodies {
            let m = rig.world.get::<motion::PhysicsBody>(*body).unwrap().mass();
            p += m * rig.v(*body).length();
            l += m * rig.v(*body).length() * rig.x(*body).length();
        }
        size = [size[0].max(p), size[1].max(l)];
    }
    [drift, size]
}

/// Nets that nothing outside acts on, and what acts in them.
fn free_nets() -> [(&'static str, Net, Environment); 3] {
    let (eight, attracted) = figure_eight();
    [
        ("tetrahedron", tetrahedron(), Environment::default()),
        ("ring", ring(), Environment::default()),
        ("figure eight", eight, attracted),
    ]
}

#[test]
fn springs_and_mutual_gravity_keep_momentum_to_rounding_under_every_method() {
    let ticks = 2048;
    for (name, net, around) in free_nets() {
        for method in Method::ALL {
            let [[drift, _], [size, _]] = drifts(&mut net.lab(&around, method, 1.0 / 512.0), ticks);
            let bound = 2.0 * (ticks as f64).sqrt() * f64::EPSILON * size;
            assert!(drift <= bound, "{name}, {method:?}: {drift:e}, at most {bound:e}");
        }
    }
}

/// Forces along the line between two bodies at one place and time: methods made of kicks and drifts conserve angular
/// momentum, the others do not.
#[test]
fn methods_of_kicks_and_drifts_keep_angular_momentum_to_rounding() {
    let ticks = 4096;
    for (name, net, around) in free_nets() {
        for method in Method::ALL {
            let mut rig = net.lab(&around, method, 1.0 / 512.0);
            // Position Verlet's velocity is that of half a step before, which its start is not.
            rig.run(1);
            let [[_, drift], [_, size]] = drifts(&mut rig, ticks);
            let bound = 2.0 * (ticks as f64).sqrt() * f64::EPSILON * size;
            if method.claims().symplectic {
                assert!(drift <= bound, "{name}, {method:?}: {drift:e}, at most {bound:e}");
            } else if name != "figure eight" {
                assert!(drift > 10.0 * bound, "{name}, {method:?}: {drift:e}, more than {bound:e}");
            }
        }
    }
}

/// 2 kg on a spring of no rest length to a post, w = 2: linear in three dimensions.
fn oscillator(x: DVec3, v: DVec3) -> Net {
    Net {
        springs: vec![([1, 0], elastic(8.0, 0.0))],
        ..Net::free([Start::held(POST), Start { x, v, w: 0.5 }])
    }
}

const POST: DVec3 = DVec3::new(1.0, -2.0, 0.5);

/// The quadratic form of (w x, v) that the matrix of a step keeps.
fn kept(method: Method, z: f64, x: f64, v: f64) -> f64 {
    match method {
        // Position Verlet after its start: kicks and drifts in turn.
        Method::SemiImplicitEuler | Method::PositionVerlet => v * v + x * x - z * x * v,
        _ => {
            let m = exact(method, z);
            v * v * (m[0][1] / z) - x * x * (m[1][0] / z)
        }
    }
}

#[test]
fn a_nearby_energy_is_kept_for_a_hundred_thousand_steps() {
    for method in Method::ALL.into_iter().filter(|method| method.claims().symplectic) {
        let limit = method.claims().stability_limit;
        // Near the limit of a method the form that it keeps is a thin ellipse, and no measure of rounding.
        for z in [0.1, 1.0, 1.5].into_iter().filter(|z| *z < 0.8 * limit) {
            let mut rig =
                oscillator(POST + DVec3::X, DVec3::Y).lab(&Environment::default(), method, z / 2.0);
            rig.run(1);
            let energy = |rig: &Lab| -> f64 {
                let (x, v) = ((rig.x(1) - POST) * 2.0, rig.v(1));
                (0..3).map(|axis| kept(method, z, x[axis], v[axis])).sum()
            };
            let start = energy(&rig);
            let mut drift = 0.0_f64;
            for _ in 0..if z == 0.1 { 100 } else { 20 } {
                rig.run(1009);
                let now = (energy(&rig) - start).abs() / start.abs();
                drift = if now <= drift { drift } else { now };
            }
            // The place of the post costs some bits of the distance to it.
            assert!(drift <= 1e-11, "{method:?} at z = {z}: {drift:e}");
        }
    }
}

#[test]
fn a_step_of_a_spring_to_a_post_has_the_fingerprint_of_the_method() {
    for method in Method::ALL {
        for z in [0.1, 0.5, 1.0] {
            let got = matrix(method, z, |[x, v], ticks| {
                let body = Start { x: DVec3::Y * x, v: DVec3::Y * v, w: 0.5 };
                let net = Net::pair(Start::held(DVec3::ZERO), body, elastic(8.0, 0.0));
                let mut rig = net.lab(&Environment::default(), method, z / 2.0);
                rig.run(ticks.into());
                [rig.x(1).y, rig.v(1).y]
            });
            let exact = exact(method, z);
            let bound = 8.0 * f64::EPSILON * terms(method, z);
            for (got, exact) in got.as_flattened().iter().zip(exact.as_flattened()) {
                assert!((got - exact).abs() <= bound, "{method:?} at z = {z}: {got} for {exact}");
            }
            let (trace, area) = (trace(got) - trace(exact), determinant(got) - determinant(exact));
            assert!(trace.abs() <= bound && area.abs() <= 2.0 * bound, "{method:?} at {z}");
        }
    }
}

#[test]
fn velocities_turned_round_lead_back_along_the_string() {
    // At 240 Hz, 10 s and back: the errors of the catalogue, and those of the methods that have none.
    for (method, known) in [
        (Method::ExplicitEuler, 1.2),
        (Method::SemiImplicitEuler, 3.7e-3),
        (Method::RungeKutta2Midpoint, 1.7e-4),
        (Method::RungeKutta4, 1.6e-8),
        (Method::PositionVerlet, 0.0),
        (Method::VelocityVerlet, 0.0),
        (Method::Yoshida4, 0.0),
    ] {
        let net = pendulum(100.0);
        let mut rig = net.lab(&Environment::pull(DVec3::Y * -9.81), method, 1.0 / 240.0);
        rig.run(2400).ask(Request::ReverseVelocities).run(2400);
        let error = rig.x(1).distance(net.bodies[1].x);
        if known == 0.0 {
            assert!(error <= 1e-12, "{method:?}: {error:e}");
        } else {
            assert!(
                (0.5..2.0).contains(&(error / known)),
                "{method:?}: {error:e}, known {known:e}"
            );
        }
    }
}

/// 20 rounds of 6.3259 s at 500 steps each.
#[test]
fn three_bodies_on_an_eight_keep_their_energy_in_bounds() {
    let (net, around) = figure_eight();
    for (method, bound) in [
        (Method::SemiImplicitEuler, 2.8e-3),
        (Method::VelocityVerlet, 9.5e-5),
        (Method::RungeKutta4, 8.5e-6),
        (Method::Yoshida4, 1e-6),
    ] {
        let mut rig = net.lab(&around, method, 6.325_897_9 / 500.0);
        let start = rig.energy();
        // Of three unit masses: m v^2 / 2 and -1 / r.
        let pairs = [(0, 1), (1, 2), (0, 2)].map(|(a, b)| 1.0 / rig.x(a).distance(rig.x(b)));
        let plain = (0..3).map(|body| rig.v(body).length_squared() / 2.0).sum::<f64>()
            - pairs.iter().sum::<f64>();
        assert!((start - plain).abs() <= 4.0 * f64::EPSILON * 4.0, "{start} is not {plain}");
        let mut worst = 0.0_f64;
        for _ in 0..1000 {
            rig.run(10);
            worst = worst.max(((rig.energy() - start) / start).abs());
        }
        assert!(worst <= bound, "{method:?}: {worst:e}, at most {bound:e}");
        assert!(
            rig.totals().momentum.length() <= 1e-13
                && rig.totals().angular_momentum.length() <= 1e-6
        );
    }
}
