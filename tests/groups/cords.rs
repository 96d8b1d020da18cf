//! Cords, springs that only pull: they tighten and slacken within a step, where every method keeps its order.

use glam::DVec3;
use motion::ledger::Ledger;
use motion::{Curve, Elastic, Gravity, Method, OwnLaws, Request, Thrust};

use super::orders::Problem;
use crate::rigs::{Environment, Lab, Net, Start, State, elastic};

const AXIS: DVec3 = DVec3::new(0.48, 0.6, 0.64);
const LENGTH: f64 = 2.0;
/// Of 2 kg.
const STIFFNESS: f64 = 8.0;

/// Deviation from the length and velocity away from the post `t` seconds after a cord of that damping, N s/m, has become
/// taut at a speed of 1 m/s, and when it becomes slack.
fn taut(damping: f64) -> (f64, impl Fn(f64) -> (f64, f64)) {
    let (a, k) = (damping / 4.0, STIFFNESS / 2.0);
    let w = (k - a * a).sqrt();
    let at = move |t: f64| {
        let (sin, cos) = (w * t).sin_cos();
        let decay = (-a * t).exp();
        (decay * sin / w, decay * (cos - a * sin / w))
    };
    // There the force `k s + c v` is 0.
    let end = std::f64::consts::PI - (damping * w / (STIFFNESS - damping * a)).atan();
    (end / w, at)
}

/// Position along the axis and velocity of 2 kg on a cord from a post at 0, which it passes at 1 m/s.
fn on_a_cord(damping: f64) -> impl Fn(f64) -> Vec<State> {
    let (end, taut) = taut(damping);
    move |t| {
        let (mut t, mut x, mut v, mut time) = (t, 0.0, 1.0_f64, 0.0);
        // Beyond the cord's length it swings as ever, but slower.
        loop {
            let free = (LENGTH - x * v.signum()) / v.abs();
            if t - time < free {
                (x, t) = (x + v * (t - time), v);
                break;
            }
            time += free;
            let (side, speed) = (v.signum(), v.abs());
            if t - time < end {
                let (s, u) = taut(t - time);
                (x, t) = (side * (LENGTH + s * speed), side * u * speed);
                break;
            }
            let (s, u) = taut(end);
            (x, v, time) = (side * (LENGTH + s * speed), side * u * speed, time + end);
        }
        vec![(DVec3::ZERO, DVec3::ZERO), (AXIS * x, AXIS * t)]
    }
}

fn cord(damping: f64) -> Elastic {
    Elastic { damping, pull_only: true, ..elastic(STIFFNESS, LENGTH) }
}

fn net(damping: f64) -> Net {
    Net::pair(Start::held(DVec3::ZERO), Start::of(2.0, DVec3::ZERO, AXIS), cord(damping))
}

#[test]
fn every_method_keeps_its_order_where_the_force_of_a_damped_cord_jumps() {
    let problem = Problem::new("damped cord", 9.0, net(2.0), on_a_cord(2.0));
    Problem { velocity_laws: true, ..problem }.check_all();
}

#[test]
fn methods_keep_orders_above_1_where_a_cord_without_damping_has_a_kink() {
    // Positions of semi-implicit Euler are of order 2 on such a cord, by chance.
    Problem::new("cord", 9.0, net(0.0), on_a_cord(0.0)).check_high();
}

fn falling() -> Environment {
    Environment { gravity: Some(Gravity::EARTH), ..Environment::default() }
}

fn lab(net: &Net, method: Method) -> Lab {
    net.lab(&falling(), method, 1.0 / 60.0)
}

/// A body of 2 kg beside a post, on a cord of which the last meters pull.
fn bungee(damping: f64) -> Net {
    let jumper = Start::of(2.0, DVec3::X * 0.5, DVec3::ZERO);
    Net::pair(
        Start::held(DVec3::ZERO),
        jumper,
        Elastic { stiffness: 40.0, damping, ..cord(damping) },
    )
}

#[test]
fn a_slack_cord_does_nothing_and_a_taut_one_is_a_spring_bit_for_bit() {
    for method in Method::ALL {
        // Falls for 0.6 s, until the cord is taut.
        let free = Net::free([bungee(3.0).bodies[1]]);
        let (mut on_cord, mut free) = (lab(&bungee(3.0), method), lab(&free, method));
        for tick in 0..36 {
            let [on_cord, free] = [on_cord.run(1).states()[1], free.run(1).states()[0]];
            let near = |a: DVec3, b: DVec3| a.distance(b) < 1e-13;
            assert!(
                near(on_cord.0, free.0) && near(on_cord.1, free.1),
                "{method:?} {tick}: {on_cord:?} {free:?}"
            );
        }
        let hanging = |pull_only| {
            let spring = Elastic { pull_only, ..elastic(40.0, 1.0) };
            let weight = Start::of(1.0, DVec3::new(0.1, -1.2, 0.0), DVec3::ZERO);
            lab(&Net::pair(Start::held(DVec3::ZERO), weight, spring), method)
        };
        hanging(true).agrees(&mut hanging(false), 240, &[], &format!("{method:?}"));
    }
}

#[test]
fn a_slack_cord_gives_nothing_where_a_step_of_position_verlet_is_brought_to_its_time() {
    // A velocity that is set makes the last step of one body another one than that of the other.
    let mut lab = lab(&bungee(0.0), Method::PositionVerlet);
    let jumper = lab.bodies[1];
    lab.run(10).ask(Request::SetVelocity(jumper, DVec3::ZERO)).run(10);
    let (x, v) = lab.states()[1];
    let since = 10.0 / 60.0;
    assert!(v.x == 0.0 && (x.x - 0.5).abs() < 1e-15, "{x} {v}");
    // Half a step late.
    assert!((v.y + 9.8 * (since - 0.5 / 60.0)).abs() < 1e-12, "{v}");
}

#[test]
fn position_verlet_knows_what_acted_before_a_cord_changes_shortly_after_a_jump() {
    // The engine starts 0.5 ms before the cord, which has hardly a force, tightens in the same step.
    let run = |length: f64| {
        let body = Start::of(1.0, DVec3::ZERO, DVec3::X);
        let elastic = Elastic { stiffness: 1e-6, ..cord(0.0) };
        let net =
            Net::pair(Start::held(DVec3::ZERO), body, Elastic { rest_length: length, ..elastic });
        let mut lab = net.lab(&Environment::default(), Method::PositionVerlet, 0.01);
        let thrust = Thrust::new(Curve::Polynomial(vec![DVec3::X * 1000.0]), 0.505, f64::INFINITY);
        lab.insert(1, OwnLaws::new(vec![Box::new(thrust)]));
        lab.recompile();
        lab.run(60).states()[1]
    };
    // It is at 0.5056 m then.
    let ((x, v), (free_x, free_v)) = (run(0.5056), run(100.0));
    assert!(
        (x - free_x).length() < 1e-6 && (v - free_v).length() < 1e-6,
        "{x} {free_x}, {v} {free_v}"
    );
}

#[test]
fn the_ledger_follows_a_cord_through_its_jumps() {
    // What damping takes while the cord is taut, and what is left in it when it is let go.
    let residual = |method, damping, hz: u32| {
        let mut lab = bungee(damping).lab(&falling(), method, 1.0 / f64::from(hz));
        let mut ledger = Ledger::open(&lab.world);
        (0..5 * hz).for_each(|_| ledger.tick(&mut lab.stepper, &mut lab.world));
        let lost = ledger.since_opening().energy.law("spring_damping");
        assert_eq!(lost < -1.0, damping > 0.0, "{method:?} {damping}: {lost} J");
        (ledger.since_opening().energy.residual, ledger.since_opening().momentum.residual.length())
    };
    for damping in [0.0, 3.0] {
        let [(coarse, p), (fine, q)] =
            [120, 480].map(|hz| residual(Method::RungeKutta4, damping, hz));
        assert!(coarse.abs() < 1e-4 && p < 2e-6, "{damping}: {coarse:e} J, {p:e} N s");
        assert!((coarse / fine).abs() > 6.0 && p / q > 30.0, "{damping}: {fine:e} J, {q:e} N s");
    }
}

#[test]
fn many_cords_of_a_rope_tighten_one_after_the_other() {
    // Thirty points that lie in a heap and fall from the first one on.
    let mut rope = Net::free([Start::held(DVec3::ZERO)]);
    for i in 1..30 {
        let side = (i % 2) as f64 * 0.2;
        rope.bodies.push(Start::of(0.1, DVec3::new(side, -0.01 * i as f64, 0.0), DVec3::ZERO));
        let spring = Elastic { damping: 0.5, pull_only: true, ..elastic(2000.0, 0.3) };
        rope.springs.push(([i - 1, i], spring));
    }
    for method in [
        Method::SemiImplicitEuler,
        Method::ImplicitEuler,
        Method::VelocityVerlet,
        Method::RungeKutta4,
    ] {
        let mut lab = rope.lab(&falling(), method, 1.0 / 240.0);
        let lowest = (0..240 * 3).map(|_| lab.run(1).states()[29].0.y).fold(0.0, f64::min);
        assert!(lab.quarantined().is_empty(), "{method:?}");
        // Straight it is 8.7 m long.
        assert!((-12.0..-8.0).contains(&lowest), "{method:?}: {lowest}");
    }
}
