//! Engines of a body that come on and go off inside a tick.

use glam::DVec3;
use motion::{Curve, Drag, Gravity, Method, OwnLaws, Thrust};

use super::{Environment, H, Start, starts, wells};
use crate::rigs::{Dice, bits};

const TICKS: u64 = 12;

/// The highest degree of a polynomial of time that the method integrates into a velocity exactly.
fn exact_degree(method: Method) -> usize {
    match method {
        Method::ExplicitEuler | Method::SemiImplicitEuler | Method::ImplicitEuler => 0,
        Method::PositionVerlet
        | Method::VelocityVerlet
        | Method::RungeKutta2Midpoint
        | Method::RungeKutta2Heun => 1,
        Method::RungeKutta4 | Method::Yoshida4 => 3,
    }
}

/// Newtons of 1, t/s, ...
const COEFFICIENTS: [DVec3; 4] = [
    DVec3::new(4.0, -2.0, 1.0),
    DVec3::new(-10.0, 30.0, 5.0),
    DVec3::new(200.0, 0.0, -100.0),
    DVec3::new(0.0, -700.0, 900.0),
];

/// Integral of the curve from `from` to `until`.
fn impulse(degree: usize, from: f64, until: f64) -> DVec3 {
    let term = |k: usize| {
        let k1 = i32::try_from(k).unwrap() + 1;
        COEFFICIENTS[k] * ((until.powi(k1) - from.powi(k1)) / f64::from(k1))
    };
    (0..=degree).map(term).sum()
}

#[test]
fn an_engine_gives_the_exact_impulse_of_its_burn() {
    for method in Method::ALL {
        for degree in 0..=exact_degree(method) {
            for (from, until) in [(0.3, 7.6), (2.0, 5.0), (2.3, 2.9), (0.0, 4.5), (3.0, 3.25)] {
                for substeps in [1, 3] {
                    let (from, until) = (from * H, until * H);
                    let mut lab =
                        Environment { substeps: Some(substeps), ..Environment::default() }
                            .lab(method, H);
                    let body = lab.spawn(Start { x: DVec3::ONE, v: DVec3::ZERO, w: 0.5 });
                    let curve = Curve::Polynomial(COEFFICIENTS[..=degree].to_vec());
                    lab.insert(body, OwnLaws::new(vec![Box::new(Thrust::new(curve, from, until))]));
                    lab.run(TICKS);
                    let expected = impulse(degree, from, until) * 0.5;
                    let error = lab.v(body).distance(expected);
                    assert!(
                        error <= 1e-13,
                        "{method:?} degree {degree}, {from} to {until}: {error:e}"
                    );
                }
            }
        }
    }
}

/// An engine splits the steps of its own body only.
#[test]
fn a_body_beside_an_engine_moves_as_if_it_was_not_there() {
    let gravity = Some(Gravity::EARTH);
    for method in Method::ALL {
        for scene in [
            Environment::falling(),
            Environment { gravity, wells: Some(wells()), ..Environment::default() },
        ] {
            let run = |with_engine: bool| {
                let mut lab = scene.lab(method, H);
                for (i, start) in starts().into_iter().enumerate() {
                    if i == 4 && with_engine {
                        let curve = Curve::Polynomial(COEFFICIENTS.to_vec());
                        let engine = Thrust::new(curve, 0.3 * H, 7.6 * H);
                        lab.world.spawn((start.components(), OwnLaws::new(vec![Box::new(engine)])));
                    }
                    lab.spawn(start);
                }
                lab.run(TICKS);
                let evaluations = lab.evaluations();
                (lab.all_bits(&[]), evaluations.accelerations(), evaluations.newton_iterations())
            };
            let ((with, evaluated, newton), (without, before, newton_before)) =
                (run(true), run(false));
            assert_eq!(with, without, "{method:?} {scene:?}");
            let claims = method.claims();
            // 14 pieces, since both ends of the burn lie inside a tick; what was before a jump is evaluated for
            // it, and again after it where it was kept.
            let most = 14 * claims.evaluations + 2 + 3 * claims.start_up_evaluations;
            let most = u64::from(most) + newton - newton_before;
            let own = evaluated - before;
            let least = u64::from(14 * claims.evaluations);
            assert!(
                (least..=most).contains(&own),
                "{method:?} {own} in {least}..={most} {scene:?}"
            );
        }
    }
}

/// Forty bodies, each with another engine; some come on or go off in the run, one body is immovable.
fn with_engines() -> Vec<(Start, Thrust)> {
    let mut dice = Dice(11);
    let body = |i: usize| {
        let w = if i == 9 { 0.0 } else { 1.0 / (1.0 + i as f64) };
        let v = if i == 9 { DVec3::ZERO } else { dice.vector() };
        let start = Start { x: dice.vector() * 3.0 + DVec3::X * 2.0, v, w };
        let curve =
            Curve::Polynomial(COEFFICIENTS.map(|newtons| newtons * (0.1 * i as f64)).to_vec());
        let (from, until) = match i % 8 {
            3 => (2.3, 7.6),
            4 => (f64::NEG_INFINITY, 5.0),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
        (start, Thrust::new(curve, from * H, until * H))
    };
    (0..40).map(body).collect()
}

#[test]
fn bodies_with_engines_move_together_as_they_do_alone() {
    let gravity = Some(Gravity::EARTH);
    let drag = Some(Drag::new(0.1, 0.2));
    for method in Method::ALL {
        for scene in [
            Environment::falling(),
            Environment { gravity, wells: Some(wells()), ..Environment::default() },
            Environment { drag, substeps: Some(3), ..Environment::default() },
        ] {
            let run = |bodies: &[(Start, Thrust)]| {
                let mut lab = scene.lab(method, H);
                let own = |engine: &Thrust| OwnLaws::new(vec![Box::new(engine.clone())]);
                let bodies: Vec<_> = bodies
                    .iter()
                    .map(|(start, engine)| lab.world.spawn((start.components(), own(engine))).id())
                    .collect();
                lab.run(TICKS);
                let states: Vec<_> =
                    bodies.iter().map(|body| bits(lab.x(*body), lab.v(*body))).collect();
                (states, lab.counts())
            };
            let all = with_engines();
            let (together, counted) = run(&all);
            let (mut sum, mut by_law) = (0, std::collections::BTreeMap::new());
            for (i, body) in all.iter().enumerate() {
                let (alone, (accelerations, laws)) = run(std::slice::from_ref(body));
                assert_eq!(together[i], alone[0], "{method:?}, body {i}");
                sum += accelerations;
                laws.into_iter().for_each(|(law, count)| *by_law.entry(law).or_default() += count);
            }
            assert_eq!(counted, (sum, by_law.into_iter().collect()), "{method:?}");
        }
    }
}
