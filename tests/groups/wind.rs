//! Air: on sheets along their normals, on points from all sides, and wind with gusts.

use glam::DVec3;
use motion::internals::Solver;
use motion::{Affine, BodyState, Drag, EvaluationTime, Law, METHODS, Method, Request, Wind};

use crate::rigs::{Dice, Environment, Net, Start, State, elastic, extrapolated, net::H};

fn wind(velocity: DVec3) -> Wind {
    Wind { velocity, gust: 0.0, gust_hz: 0.0 }
}

fn airy(drag: Drag, wind: Option<Wind>) -> Environment {
    Environment { drag: Some(Drag { wind, ..drag }), ..Environment::default() }
}

/// A triangle of three equal points across `normal`, about the origin, its springs at rest.
fn kite(normal: DVec3, v: DVec3) -> Net {
    let (a, b) = normal.normalize().any_orthonormal_pair();
    let place = |i: usize| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / 3.0).sin_cos();
        a * cos + b * sin
    };
    let bodies = (0..3).map(|i| Start::of(0.5, place(i), v)).collect();
    let springs = (0..3).map(|i| ([i, (i + 1) % 3], elastic(20.0, 3.0_f64.sqrt()))).collect();
    Net { bodies, springs }
}

const ONE: [[u32; 3]; 1] = [[0, 1, 2]];

/// A sheet shares out its corners' masses, and free bodies are integrated and held ones are not.
#[test]
fn a_mass_that_is_changed_acts_as_if_it_had_been_there_from_the_start() {
    let axis = DVec3::new(0.48, 0.6, 0.64);
    let mut net = kite(axis, -axis);
    net.bodies.push(Start::held(axis * 2.0));
    net.springs.push(([0, 3], elastic(30.0, 1.0)));
    let around = airy(Drag::new(0.8, 0.3), Some(wind(DVec3::new(5.0, 1.0, -2.0))));
    for method in [Method::SemiImplicitEuler, Method::ImplicitEuler, Method::RungeKutta4] {
        for (body, w) in [(1, 0.1), (1, 0.0), (3, 0.5)] {
            let mut from_the_start = net.clone();
            from_the_start.bodies[body].w = w;
            let [mut there, mut changed] =
                [&from_the_start, &net].map(|net| net.soft(&ONE, &around, method, H));
            changed.have(Request::SetInverseMass(changed.bodies[body], w));
            assert_eq!(
                there.run(20).all_bits(&[]),
                changed.run(20).all_bits(&[]),
                "{method:?}, {body}, {w}"
            );
            // And once more between two ticks.
            there.have(Request::SetInverseMass(there.bodies[body], net.bodies[body].w));
            assert_ne!(
                there.run(20).all_bits(&[]),
                changed.run(20).all_bits(&[]),
                "{method:?}, {body}, {w}"
            );
        }
    }
}

#[test]
fn a_sheet_square_to_the_wind_moves_like_one_body() {
    let axis = DVec3::new(0.48, 0.6, 0.64);
    for method in Method::ALL {
        for drag in [Drag::new(0.8, 0.0), Drag::new(0.0, 0.3), Drag::new(0.5, 0.2)] {
            // A single body's implicit step is not linearised.
            let solver =
                Some(Solver { tolerance: 1e-13, newton_iterations: 12, ..Solver::default() });
            let around = Environment { solver, ..airy(drag, Some(wind(axis * 5.0))) };
            let mut sheet = kite(axis, -axis).soft(&ONE, &around, method, H);
            let single = Net::free([Start::of(1.5, DVec3::ZERO, -axis)]);
            let mut single = single.lab(&around, method, H);
            let bound = if method == Method::ImplicitEuler { 1e-9 } else { 1e-12 };
            for tick in 0..120 {
                sheet.run(1);
                single.run(1);
                let middle = (sheet.x(0) + sheet.x(1) + sheet.x(2)) / 3.0;
                let error = middle.distance(single.x(0)) + sheet.v(1).distance(single.v(0));
                assert!(error <= bound, "{method:?}, {drag:?}, tick {tick}: {error:e}");
            }
        }
    }
}

#[test]
fn a_sheet_feels_nothing_of_air_along_it() {
    for method in Method::ALL {
        let (v, around) = (
            DVec3::new(3.0, 0.0, -2.0),
            airy(Drag::new(0.8, 0.3), Some(wind(DVec3::new(7.0, 0.0, 1.0)))),
        );
        // Also one without springs, which is no more than points that share the air.
        for springs in [vec![], kite(DVec3::Y, v).springs] {
            let held = springs.is_empty();
            let mut sheet = Net { springs, ..kite(DVec3::Y, v) }.soft(&ONE, &around, method, H);
            sheet.run(120);
            for body in 0..3 {
                assert_eq!(sheet.x(body).y, 0.0, "{method:?}");
                // Springs at rest pull by the rounding of their lengths.
                let error = sheet.v(body).distance(v);
                assert!(error <= if held { 0.0 } else { 1e-12 }, "{method:?}: {error:e}");
            }
        }
    }
}

#[test]
fn a_sheet_falls_at_the_terminal_velocity() {
    for method in Method::ALL {
        for (drag, terminal) in
            [(Drag::new(2.0, 0.0), 9.8 / 2.0), (Drag::new(0.0, 0.4), (9.8_f64 / 0.4).sqrt())]
        {
            let around = Environment { drag: Some(drag), ..Environment::falling() };
            let mut sheet = kite(DVec3::Y, DVec3::ZERO).soft(&ONE, &around, method, H);
            sheet.run(1200);
            // Gravity is a kick g h before the step, which is linearised there: v² = g / k + (g h)² at the end.
            let kicked = method == Method::ImplicitEuler && drag.quadratic > 0.0;
            let terminal = if kicked { terminal.hypot(9.8 * H) } else { terminal };
            for body in 0..3 {
                let v = sheet.v(body);
                assert!((v.y / -terminal - 1.0).abs() <= 1e-9, "{method:?}: {v} for {terminal}");
            }
        }
    }
}

/// Implicit Euler linearizes air on sheets once per step, like springs, and does not iterate.
#[test]
fn no_wind_is_too_strong_for_a_sheet_under_implicit_euler() {
    let axis = DVec3::new(0.48, 0.6, 0.64);
    for (speed, drag) in [(1.0, 1.0), (1e2, 1e2), (1e4, 1e6)] {
        let around = airy(Drag::new(0.0, drag), Some(wind(axis * speed)));
        let mut sheet = kite(axis, DVec3::ZERO).soft(&ONE, &around, Method::ImplicitEuler, H);
        for tick in 1..=600 {
            sheet.run(1);
            for body in 0..3 {
                let v = sheet.v(body).length();
                assert!(
                    v <= speed * (1.0 + 1e-9),
                    "{drag}/m, tick {tick}: {v} m/s in a wind of {speed} m/s"
                );
            }
        }
        let error = sheet.v(0).distance(axis * speed) / speed;
        assert!(error < 0.2, "{drag}/m: {error} of the wind is left after 5 s");
        assert_eq!(sheet.evaluations().unconverged_steps(), 0);
    }
}

/// 3 by 3 points of different masses, one of them held, two triangles to a cell, out of plane.
fn cloth() -> (Net, Vec<[u32; 3]>) {
    let mut dice = Dice(12);
    let body = |i: usize| {
        let x = DVec3::new((i % 3) as f64, 0.0, (i / 3) as f64) * 0.5 + dice.vector() * 0.1;
        if i == 0 {
            Start::held(x)
        } else {
            Start::of(0.2 + 0.05 * i as f64, x, dice.vector() * 0.5)
        }
    };
    let bodies: Vec<_> = (0..9).map(body).collect();
    let (mut springs, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..9_usize {
        let down = i + 3 < 9;
        let right = i % 3 < 2;
        let mut join = |to: usize| springs.push(([i, to], elastic(30.0, 0.5)));
        right.then(|| join(i + 1));
        down.then(|| join(i + 3));
        if down && right {
            let [a, b, c, d] = [i, i + 1, i + 3, i + 4].map(|i| u32::try_from(i).unwrap());
            triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    (Net { bodies, springs }, triangles)
}

/// Forces of air by the formula: the point drag of the mass of each triangle, along its normal, a third to a corner.
fn air(
    net: &Net,
    triangles: &[[u32; 3]],
    drag: Drag,
    wind: Wind,
    time: f64,
    state: &[State],
) -> Vec<DVec3> {
    let mut forces = vec![DVec3::ZERO; net.bodies.len()];
    let of_point =
        |i: u32| triangles.iter().flatten().filter(|corner| **corner == i).count() as f64;
    for corners in triangles {
        let [a, b, c] = corners.map(|i| state[i as usize]);
        let shares: Vec<_> = corners
            .iter()
            .filter(|i| net.bodies[**i as usize].w > 0.0)
            .map(|i| 1.0 / net.bodies[*i as usize].w / of_point(*i))
            .collect();
        let mass = shares.iter().sum::<f64>() * 3.0 / shares.len() as f64;
        let normal = (b.0 - a.0).cross(c.0 - a.0).normalize();
        let u = (a.1 + b.1 + c.1) / 3.0 - wind.at(time, (a.0 + b.0 + c.0) / 3.0);
        let force =
            normal * (-mass * (drag.linear + drag.quadratic * u.length()) * u.dot(normal) / 3.0);
        corners.iter().for_each(|i| forces[*i as usize] += force);
    }
    forces
}

const GUSTS: Wind = Wind { velocity: DVec3::new(2.0, 1.5, -1.0), gust: 1.5, gust_hz: 0.7 };

#[test]
fn the_momentum_that_a_sheet_gains_is_the_impulse_of_the_air() {
    let (net, triangles) = cloth();
    let drag = Drag::new(0.5, 0.3);
    let mut rig = net.soft(&triangles, &airy(drag, Some(GUSTS)), Method::ExplicitEuler, H);
    let before = rig.totals().momentum;
    let mut impulse = DVec3::ZERO;
    for tick in 0..30 {
        let state = rig.states();
        let mut forces = air(&net, &triangles, drag, GUSTS, f64::from(tick) * H, &state);
        net.forces(&state).iter().zip(&mut forces).for_each(|(spring, force)| *force += *spring);
        impulse += forces[1..].iter().sum::<DVec3>() * H;
        rig.run(1);
        let gained = rig.totals().momentum - before;
        assert!(gained.distance(impulse) <= 1e-13, "tick {tick}: {gained} for {impulse}");
    }
}

#[test]
fn a_cloth_in_gusts_is_integrated_with_the_order_of_the_method() {
    let (net, triangles) = cloth();
    let drag = Drag::new(0.5, 0.3);
    let a = |t: f64, state: &[State]| -> Vec<DVec3> {
        let air = air(&net, &triangles, drag, GUSTS, t, state);
        let springs = net.forces(state);
        (0..9).map(|i| (air[i] + springs[i]) * net.bodies[i].w).collect()
    };
    let exact = extrapolated(&net.start(), 0.5, 1, 1 << 11, a).pop().unwrap();
    for claims in METHODS {
        let error = |steps: u32| {
            let mut rig = net.soft(
                &triangles,
                &airy(drag, Some(GUSTS)),
                claims.method,
                0.5 / f64::from(steps),
            );
            rig.run(u64::from(steps));
            (0..9).map(|body| rig.x(body).distance(exact[body].0)).fold(0.0, f64::max)
        };
        let claimed = claims.order_with_velocity_laws;
        let steps = if claimed > 2 { 256 } else { 2048 };
        let order = (error(steps) / error(2 * steps)).log2();
        assert!((order - f64::from(claimed)).abs() <= 0.05, "{}: {order:.3}", claims.name);
    }
}

/// Frozen turbulence: a point that drifts with the mean wind stays in the same gust.
#[test]
fn gusts_are_carried_along_by_the_wind() {
    let mut dice = Dice(2);
    for _ in 0..100 {
        let (x, t, later) = (dice.vector() * 20.0, dice.number() * 10.0, dice.number() * 5.0);
        let (here, there) = (GUSTS.at(t, x), GUSTS.at(t + later, x + GUSTS.velocity * later));
        assert!(here.distance(there) <= 1e-11, "{here} {there}");
        // Across the wind, and never more than their strength: sin p and sin 2p / 2.
        let gust = here - GUSTS.velocity;
        assert!(gust.dot(GUSTS.velocity).abs() <= 1e-11 && gust.length() <= 1.5 * 1.25_f64.sqrt());
    }
    // Half a gust on, the other way; two sheets that far apart swing against each other.
    let blow = Wind { velocity: DVec3::X * 4.0, gust: 2.0, gust_hz: 2.0 };
    let around = airy(Drag::new(1.5, 0.0), Some(blow));
    let swing = |x: DVec3| {
        let mut rig = kite(DVec3::Z, DVec3::ZERO).moved(x).soft(
            &ONE,
            &around,
            Method::RungeKutta4,
            1.0 / 256.0,
        );
        (0..256).map(|_| rig.run(1).v(0).z).collect::<Vec<_>>()
    };
    let (here, half) = (swing(DVec3::ZERO), swing(DVec3::X));
    // v' = -c (v - g sin 2 pi f (t - x / 4)), from rest, across: e is -z.
    let (c, w) = (1.5_f64, 2.0 * std::f64::consts::TAU);
    for (i, (v, other)) in here.iter().zip(&half).enumerate() {
        let t = (i + 1) as f64 / 256.0;
        let exact = -2.0 * c * (c * (w * t).sin() - w * (w * t).cos() + w * (-c * t).exp())
            / (c * c + w * w);
        assert!((v - exact).abs() <= 1e-7, "{v} for {exact} at {t}");
        assert!((v + other).abs() <= 1e-12, "{v} and {other} at {t}");
    }
}

#[test]
fn steady_linear_wind_is_an_affine_law_and_carries_points_along() {
    let (velocity, c) = (DVec3::new(3.0, -1.0, 0.5), 0.8);
    let drag = Drag { wind: Some(wind(velocity)), ..Drag::new(c, 0.0) };
    let affine = Law::affine(&drag);
    assert_eq!(affine, Some(Affine { constant: velocity * c, rate: c }));
    let gusty = Drag { wind: Some(GUSTS), ..drag };
    assert_eq!(Law::affine(&gusty), None);
    assert_eq!(Law::affine(&Drag { quadratic: 0.1, ..drag }), None);
    let state = BodyState { position: DVec3::ONE, velocity: DVec3::Y, inverse_mass: 1.0 };
    let at = EvaluationTime { time: 0.0, within_step: 0.0 };
    let a = Law::acceleration(&drag, at, state);
    assert!(a.distance((velocity - DVec3::Y) * c) <= 1e-15);
    let v0 = DVec3::new(-1.0, 2.0, 0.0);
    let around = Environment { drag: Some(drag), ..Environment::default() };
    for claims in METHODS {
        // A single point, and a member of a group.
        let bodies = vec![Start::of(2.0, DVec3::ZERO, v0), Start::of(1.0, DVec3::X, v0)];
        for springs in [vec![], vec![([0, 1], elastic(0.0, 1.0))]] {
            let net = Net { bodies: bodies.clone(), springs };
            let error = |steps: u32| {
                let mut rig = net.lab(&around, claims.method, 2.0 / f64::from(steps));
                rig.run(u64::from(steps));
                let counted = rig.evaluations().accelerations();
                let claimed = 2 * u64::from(steps * claims.evaluations_with_velocity_laws);
                assert_eq!(counted, claimed, "{}", claims.name);
                let gone = -f64::exp_m1(-c * 2.0);
                rig.x(0).distance(velocity * 2.0 + (v0 - velocity) * (gone / c))
            };
            let order = (error(64) / error(128)).log2();
            let off = (order - f64::from(claims.order_with_velocity_laws)).abs();
            assert!(off <= 0.06, "{}: {order:.3}", claims.name);
            let mut rig = net.lab(&around, claims.method, H);
            rig.run(3000);
            assert!(rig.v(1).distance(velocity) <= 1e-13, "{}: {}", claims.name, rig.v(1));
        }
    }
}
