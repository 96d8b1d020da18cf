//! Implicit Euler steps of groups: stiff springs, conjugate gradients, and what they must not break.

use glam::DVec3;
use motion::internals::Solver;
use motion::{AxisLocks, Elastic, Method};

use crate::rigs::{Dice, Environment, Lab, Net, Start, chain, elastic, net::H};

const IMPLICIT: Method = Method::ImplicitEuler;

/// 1 kg at (1, 0, 0) on a spring to the origin.
fn on_a_post(stiffness: f64, rest_length: f64) -> Net {
    let body = Start::of(1.0, DVec3::X, DVec3::ZERO);
    Net::pair(Start::held(DVec3::ZERO), body, elastic(stiffness, rest_length))
}

#[test]
fn a_stiff_spring_loses_the_root_of_one_and_z_squared_a_step() {
    for stiffness in [1e2, 1e4, 1e6, 1e8] {
        let mut rig = on_a_post(stiffness, 0.0).lab(&Environment::default(), IMPLICIT, H);
        let (w, z) = (stiffness.sqrt(), stiffness.sqrt() * H);
        let mut size = 1.0_f64;
        for step in 1..=20 {
            rig.run(1);
            size /= z.hypot(1.0);
            let now = (rig.x(1) * w).length().hypot(rig.v(1).length()) / w;
            // What is left of the position is a part in 1 + z² of it.
            let bound = f64::from(step) * 4.0 * f64::EPSILON * (1.0 + z * z);
            assert!((now / size - 1.0).abs() <= bound, "z = {z}: {now:e} for {size:e}");
        }
        // One unknown direction: one iteration a step.
        assert_eq!(rig.evaluations().cg_iterations(), 20);
        assert_eq!(rig.evaluations().unconverged_steps(), 0);
    }
}

/// Along its axis a spring with a rest length is linear as well.
#[test]
fn the_artificial_damping_is_that_of_the_table() {
    for (hertz, half_life) in [(1.0, 2.1), (5.0, 0.095), (10.0, 0.031)] {
        let w = std::f64::consts::TAU * hertz;
        let mut net = on_a_post(w * w, 2.0);
        net.bodies[1].x = DVec3::X * 2.5;
        let mut rig = net.lab(&Environment::default(), IMPLICIT, H);
        let size = |rig: &Lab| ((rig.x(1).x - 2.0) * w).hypot(rig.v(1).x);
        let start = size(&rig);
        rig.run(30);
        let rate = (start / size(&rig)).ln() / (30.0 * H);
        let z = w * H;
        let table = (1.0 + z * z).ln() / (2.0 * H);
        assert!((rate / table - 1.0).abs() <= 0.01, "{hertz} Hz: {rate} for {table}");
        let measured = std::f64::consts::LN_2 / rate;
        assert!(
            (measured / half_life - 1.0).abs() <= 0.03,
            "{hertz} Hz: {measured} s for {half_life} s"
        );
    }
}

#[test]
fn a_stiff_pendulum_never_rises_above_its_start() {
    for (stiffness, most) in [(1e4, 4.5e-3), (1e6, 3.5e-4), (1e8, 1.7e-5)] {
        let net = on_a_post(stiffness, 1.0);
        let mut rig = net.lab(&Environment::pull(DVec3::Y * -9.81), IMPLICIT, H);
        let start = rig.energy();
        let (mut highest, mut stretch) = (f64::MIN, 0.0_f64);
        for _ in 0..600 {
            rig.run(1);
            highest = highest.max(rig.energy());
            stretch = stretch.max(rig.x(1).length() - 1.0);
        }
        let iterations = rig.evaluations().cg_iterations();
        assert!(highest <= start, "k = {stiffness:e}: {highest:e} above {start:e}");
        assert!(stretch <= 1.05 * most, "k = {stiffness:e}: {stretch:e}, at most {most:e}");
        assert!(iterations <= 2 * 600, "{iterations} iterations");
        assert_eq!(rig.evaluations().unconverged_steps(), 0);
    }
}

/// Highest energy, J, and longest link, m, while a chain of twenty links falls from the horizontal, in 5 s.
fn falling_chain(stiffness: f64, newton_iterations: u32) -> (f64, f64) {
    let mut net = chain(20, stiffness, 0.1, 1.0);
    for (i, body) in net.bodies.iter_mut().enumerate() {
        body.x = DVec3::X * (0.1 * i as f64);
    }
    let solver = Solver { newton_iterations, ..Solver::default() };
    let around = Environment { solver: Some(solver), ..Environment::pull(DVec3::Y * -9.81) };
    let mut rig = net.lab(&around, IMPLICIT, H);
    let (mut highest, mut longest) = (f64::MIN, 0.0_f64);
    for _ in 0..300 {
        rig.run(1);
        highest = highest.max(rig.energy());
        longest = (1..=20).map(|i| rig.x(i).distance(rig.x(i - 1))).fold(longest, f64::max);
    }
    assert_eq!(rig.evaluations().unconverged_steps(), 0);
    (highest, longest)
}

#[test]
fn stiff_chains_fall_from_the_horizontal_and_never_rise_above_their_start() {
    // All start at an energy of 0. The stiffest takes the solution of the whole step.
    for (stiffness, newton_iterations) in [(1e4, 0), (1e6, 0), (1e8, 5)] {
        let (highest, longest) = falling_chain(stiffness, newton_iterations);
        assert!(highest < 0.0, "k = {stiffness:e}: {highest} J");
        // A link holds the twenty below it with a few times their weight.
        let most = 0.1 + 20.0 * 20.0 * 9.81 / stiffness + 1e-3;
        assert!(longest <= most, "k = {stiffness:e}: a link of {longest}, at most {most}");
    }
    // The linearised step has a limit there: when the chain cracks like a whip, it takes in energy from nowhere, and
    // stays together nevertheless.
    let (highest, longest) = falling_chain(1e8, 0);
    assert!((100.0..10_000.0).contains(&highest) && longest < 0.11, "{highest} J, {longest} m");
}

#[test]
fn a_spring_of_half_its_length_comes_to_its_length() {
    let mut net = on_a_post(1e4, 1.0);
    // Not along the axis alone: across it a compressed spring pushes outward.
    net.bodies[1] = Start::of(1.0, DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.0, 0.01, 0.0));
    let mut rig = net.lab(&Environment::default(), IMPLICIT, H);
    rig.run(120);
    let length = rig.x(1).length();
    assert!((length - 1.0).abs() <= 1e-6, "{length}");
    assert_eq!(rig.evaluations().unconverged_steps(), 0);
    // With its negative stiffness across the axis, 1 + h² k (1 - L0 / L), the matrix would not be positive.
    let start = net.bodies[1].x.length();
    assert!(1.0 + H * H * 1e4 * (1.0 - 1.0 / start) < 0.0);
}

#[test]
fn a_million_kilograms_hang_on_a_chain_of_one_kilogram_links() {
    let mut net = chain(20, 1e9, 1.0, 1.0);
    net.bodies[20].w = 1e-6;
    let mut rig = net.lab(&Environment::pull(DVec3::Y * -9.81), IMPLICIT, H);
    let (mut peak, mut most) = (0.0_f64, 0);
    for _ in 0..3600 {
        let before = rig.evaluations().cg_iterations();
        rig.run(1);
        most = most.max(rig.evaluations().cg_iterations() - before);
        peak = peak.max(rig.x(0).distance(rig.x(1)) - 1.0);
    }
    let last = rig.x(0).distance(rig.x(1)) - 1.0;
    // 1e6 g / k and the links below it.
    let still = (1e6 + 19.0) * 9.81 / 1e9;
    assert!((last / still - 1.0).abs() <= 1e-6, "{last} for {still}");
    // It overshoots by what the damping of the table leaves over half a period of one mass on 20 springs.
    let z = (1e9 / 20.0 / 1e6_f64).sqrt() * H;
    let left = (1.0 + z * z).powf(-std::f64::consts::PI / z.atan() / 2.0);
    assert!((peak / (still * (1.0 + left)) - 1.0).abs() <= 0.01, "{peak}");
    assert!((15..=24).contains(&most), "{most} iterations");
    assert_eq!(rig.evaluations().unconverged_steps(), 0);
}

#[test]
fn energy_of_linear_springs_falls_at_every_step_size() {
    let mut dice = Dice(15);
    let mut net = chain(6, 100.0, 1.0, 0.5);
    net.springs.iter_mut().for_each(|(_, elastic)| elastic.rest_length = 0.0);
    net.bodies
        .iter_mut()
        .skip(1)
        .for_each(|body| (body.x, body.v) = (dice.vector(), dice.vector()));
    for power in -6..=3 {
        let h = 10.0_f64.powi(power);
        let mut rig = net.lab(&Environment::default(), IMPLICIT, h);
        let mut before = rig.energy();
        for step in 0..50 {
            rig.run(1);
            let now = rig.energy();
            // Rounding of the sum of 13 parts.
            let bound = before * (1.0 + 16.0 * f64::EPSILON);
            assert!(now <= bound, "h = {h}, step {step}: {now:e} after {before:e}");
            before = now;
        }
    }
}

/// 30 bodies of 1 g to 10 kg at random places, 70 springs without a rest length: a graph's matrix, axis by axis.
fn rough_net() -> Net {
    let mut dice = Dice(30);
    let body =
        |_| Start::of(0.1 * 10.0_f64.powf(2.0 * dice.number()), dice.vector(), dice.vector());
    let bodies: Vec<_> = (0..30).map(body).collect();
    let mut dice = Dice(31);
    let more = (0..41).map(|_| {
        let a = dice.below(30);
        [a, (a + 1 + dice.below(29)) % 30]
    });
    let ends: Vec<_> = (0..29).map(|i| [i, i + 1]).chain(more).collect();
    let springs = ends.into_iter().map(|ends| (ends, elastic(1e6, 0.0))).collect();
    Net { bodies, springs }
}

/// Change of velocities after some conjugate gradients on `(M + h² K) d = -h K (x + h v)`, with the inverses of
/// `scale` as preconditioner.
fn gradients(net: &Net, scale: &[f64], iterations: usize) -> Vec<DVec3> {
    let n = net.bodies.len();
    let pull = |d: &[DVec3]| {
        let mut sum = vec![DVec3::ZERO; n];
        for ([a, b], elastic) in &net.springs {
            let force = (d[*a] - d[*b]) * elastic.stiffness;
            sum[*a] += force;
            sum[*b] -= force;
        }
        sum
    };
    let matrix = |d: &[DVec3]| -> Vec<DVec3> {
        let pulled = pull(d);
        (0..n).map(|i| d[i] / net.bodies[i].w + pulled[i] * (H * H)).collect()
    };
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    let ahead: Vec<_> = net.bodies.iter().map(|body| body.x + body.v * H).collect();
    let mut r: Vec<_> = pull(&ahead).iter().map(|force| *force * -H).collect();
    let scaled =
        |r: &[DVec3]| -> Vec<DVec3> { r.iter().zip(scale).map(|(r, scale)| *r / *scale).collect() };
    let (mut d, mut z) = (vec![DVec3::ZERO; n], scaled(&r));
    let mut p = z.clone();
    for _ in 0..iterations {
        let (q, old) = (matrix(&p), dot(&r, &z));
        let step = old / dot(&p, &q);
        for i in 0..n {
            d[i] += p[i] * step;
            r[i] -= q[i] * step;
        }
        z = scaled(&r);
        let keep = dot(&r, &z) / old;
        p = z.iter().zip(&p).map(|(z, p)| *z + *p * keep).collect();
    }
    d
}

/// Momentum that changes of velocities add, relative to the magnitudes that it is the sum of.
fn momentum(net: &Net, change: &[DVec3]) -> f64 {
    let parts = || net.bodies.iter().zip(change).map(|(body, change)| *change / body.w);
    parts().sum::<DVec3>().length() / parts().map(DVec3::length).sum::<f64>()
}

#[test]
fn an_iteration_that_is_stopped_early_keeps_momentum() {
    let net = rough_net();
    let solver = Solver { tolerance: 0.0, most_iterations: 3, newton_iterations: 0 };
    let mut rig = net.lab(&Environment::solved(solver), IMPLICIT, H);
    rig.run(1);
    let change: Vec<_> =
        rig.states().iter().zip(&net.bodies).map(|((_, v), body)| *v - body.v).collect();
    let lost = momentum(&net, &change);
    assert!(lost <= 1e-14, "{lost:e}");
    assert_eq!(rig.evaluations().cg_iterations(), 3);
    assert_eq!(rig.evaluations().unconverged_steps(), 1);
    // The masses as preconditioner, and what the diagonal of the matrix would do.
    let masses: Vec<_> = net.bodies.iter().map(|body| 1.0 / body.w).collect();
    let mut diagonal = masses.clone();
    for (ends, elastic) in &net.springs {
        ends.iter().for_each(|end| diagonal[*end] += H * H * elastic.stiffness);
    }
    let same = gradients(&net, &masses, 3);
    let size = same.iter().map(|change| change.length()).fold(0.0, f64::max);
    for (got, expected) in change.iter().zip(&same) {
        assert!(got.distance(*expected) <= 1e-9 * size, "{got} for {expected}");
    }
    assert!(momentum(&net, &same) <= 1e-14);
    let broken = momentum(&net, &gradients(&net, &diagonal, 3));
    assert!(broken > 1e-6, "the diagonal keeps momentum as well: {broken:e}");
    // Many steps of it.
    let start = rig.totals().momentum;
    let size: f64 =
        rig.states().iter().zip(&net.bodies).map(|((_, v), body)| v.length() / body.w).sum();
    rig.run(999);
    let drift = rig.totals().momentum.distance(start) / size;
    assert!(drift <= 1e-13, "{drift:e}");
    assert_eq!(rig.evaluations().cg_iterations(), 3000);
}

#[test]
fn steps_that_do_not_converge_are_counted_and_the_others_are_not() {
    let net = rough_net();
    let run = |most_iterations| {
        let solver = Solver { most_iterations, ..Solver::default() };
        let mut rig = net.lab(&Environment::solved(solver), IMPLICIT, H);
        rig.run(10);
        (rig.evaluations().unconverged_steps(), rig.evaluations().cg_iterations())
    };
    assert_eq!(run(5), (10, 50));
    let (unconverged, iterations) = run(500);
    assert_eq!(unconverged, 0);
    assert!(iterations > 50 && iterations < 5000);
    // Each step of a tick is one.
    let around = Environment {
        substeps: Some(4),
        ..Environment::solved(Solver { most_iterations: 1, ..Solver::default() })
    };
    let mut rig = net.lab(&around, IMPLICIT, H);
    rig.run(10);
    assert_eq!(rig.evaluations().unconverged_steps(), 40);
}

#[test]
fn two_light_bodies_on_a_strong_damper_come_to_the_same_velocity() {
    let (a, b, c) = (1e-3, 2e-3, 1e6);
    let spring = Elastic::new(0.0, 0.0).damped(c);
    let bodies =
        (Start::of(a, DVec3::ZERO, DVec3::X), Start::of(b, DVec3::X * 3.0, DVec3::Y * 0.5));
    let mut rig = Net::pair(bodies.0, bodies.1, spring).lab(&Environment::default(), IMPLICIT, H);
    rig.run(1);
    let approach = (rig.v(1) - rig.v(0)).x;
    let exact = -1.0 / (1.0 + H * c * (1.0 / a + 1.0 / b));
    assert!((approach / exact - 1.0).abs() <= 1e-6, "{approach:e} for {exact:e}");
    // Across the axis it does nothing.
    assert_eq!([rig.v(0).y, rig.v(1).y], [0.0, 0.5]);
    let momentum = rig.totals().momentum;
    assert!(momentum.distance(DVec3::new(a, 0.5 * b, 0.0)) <= 1e-18, "{momentum}");
}

/// A bead on a wire, and a spring to a point beside it: the implicit equation along the wire, and no motion else.
#[test]
fn locked_axes_stay_out_of_the_solve() {
    let post = DVec3::new(0.3, 0.0, -0.4);
    let bodies = vec![
        Start::held(post),
        Start::of(2.0, DVec3::Y, DVec3::Y * 0.5),
        Start::of(1.0, DVec3::new(-1.0, 2.0, 1.0), DVec3::ZERO),
    ];
    let net =
        Net { bodies, springs: vec![([0, 1], elastic(500.0, 0.2)), ([1, 2], elastic(300.0, 0.5))] };
    let solver = Solver { tolerance: 1e-13, newton_iterations: 8, ..Solver::default() };
    let around =
        Environment { solver: Some(solver), ..Environment::pull(DVec3::new(1.0, -9.0, 2.0)) };
    let mut rig = net.lab(&around, IMPLICIT, H);
    rig.insert(1, AxisLocks { x: true, y: false, z: true });
    for _ in 0..100 {
        let before = rig.states();
        rig.run(1);
        let after = rig.states();
        assert_eq!([after[1].0.x, after[1].0.z, after[1].1.x, after[1].1.z], [0.0; 4]);
        assert_eq!(after[0], (post, DVec3::ZERO));
        let forces = net.forces(&after);
        let left = |body: usize| {
            let a = forces[body] * net.bodies[body].w + DVec3::new(1.0, -9.0, 2.0);
            after[body].1 - before[body].1 - a * H
        };
        assert!(left(1).y.abs() <= 1e-11 && left(2).length() <= 1e-11, "{} {}", left(1), left(2));
        for body in [1, 2] {
            assert!((after[body].0 - before[body].0 - after[body].1 * H).length() <= 1e-14);
        }
    }
}

#[test]
fn two_bodies_at_one_place_are_held_together_by_a_spring_without_a_rest_length_only() {
    for (rest_length, part) in [(0.0, 1.0 / (1.0 + 3.0 * 1e4 * H * H)), (0.5, 1.0)] {
        let (a, b) =
            (Start::of(1.0, DVec3::ONE, DVec3::Y), Start::of(0.5, DVec3::ONE, DVec3::ZERO));
        let net = Net::pair(a, b, elastic(1e4, rest_length));
        for method in Method::ALL {
            let mut rig = net.lab(&Environment::default(), method, H);
            rig.run(1);
            let apart = rig.v(0) - rig.v(1);
            assert!(apart.is_finite() && apart.x == 0.0 && apart.z == 0.0, "{method:?}: {apart}");
            if method == IMPLICIT {
                assert!((apart.y / part - 1.0).abs() <= 1e-12, "{apart} for {part}");
            }
            let momentum = rig.totals().momentum;
            assert!(
                momentum.distance(DVec3::Y) <= 1e-15 * (1.0 + apart.length()),
                "{method:?}: {momentum}"
            );
            rig.run(100);
            assert!(rig.quarantined().is_empty() && rig.x(0).is_finite(), "{method:?}");
        }
    }
}

/// A repelling law acts on a group as at the start of the step, and nothing breaks.
#[test]
fn wells_that_push_apart_leave_the_matrix_positive() {
    let well =
        motion::Well { position: DVec3::new(1.1, 0.0, 0.0), strength: -50.0, softening: 0.1 };
    let around = Environment { wells: Some(motion::Wells(vec![well])), ..Environment::default() };
    let mut rig = on_a_post(100.0, 1.0).lab(&around, IMPLICIT, H);
    rig.run(600);
    assert_eq!(rig.evaluations().unconverged_steps(), 0);
    assert!(rig.x(1).length() < 20.0, "{}", rig.x(1));
}
