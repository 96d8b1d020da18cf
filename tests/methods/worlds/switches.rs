//! From one method to another in the middle of a run: the state at the switch is one that the new method takes
//! on with its own order.

use crate::rigs::Bare;
use glam::DVec3;
use motion::{Gravity, Method};

use super::super::{position, velocity};
use super::{Environment, H, Start, add};
use crate::rigs::Lab;

const START: Start = Start { x: DVec3::new(1.0, 0.2, -0.3), v: DVec3::new(0.3, 1.1, 0.4), w: 0.5 };

fn pairs() -> impl Iterator<Item = (Method, Method)> {
    let to_others =
        |from| Method::ALL.into_iter().filter(move |to| *to != from).map(move |to| (from, to));
    Method::ALL.into_iter().flat_map(to_others)
}

/// A world of `from` after some ticks, switched to `to`: with the state before and after the switch.
fn switched(
    scene: &Environment,
    [from, to]: [Method; 2],
    step: f64,
    ticks: u64,
) -> (Lab, [(DVec3, DVec3); 2]) {
    let mut lab = scene.lab(from, step);
    lab.spawn(START);
    let before = lab.run(ticks).state(0);
    lab.set_method(to);
    let after = lab.state(0);
    (lab, [before, after])
}

#[test]
fn what_position_verlet_leaves_is_the_velocity_of_the_time_of_the_position() {
    for (from, to) in pairs() {
        let (_, [before, after]) = switched(&Environment::falling(), [from, to], H, 16);
        let late = if from == Method::PositionVerlet { H * 0.5 } else { 0.0 };
        assert_eq!(
            after,
            (before.0, before.1 + Gravity::EARTH.acceleration * late),
            "{from:?} {to:?}"
        );
        let exact = START.v + Gravity::EARTH.acceleration * (16.0 * H);
        assert!(after.1.distance(exact) <= 64.0 * f64::EPSILON * 4.0, "{from:?} {to:?}");
    }
}

#[test]
fn a_parabola_goes_on_from_the_state_at_the_switch() {
    let g = Gravity::EARTH.acceleration;
    for (from, to) in pairs() {
        let (mut lab, [_, (x, v)]) = switched(&Environment::falling(), [from, to], H, 16);
        // What the Eulers add to a parabola is a h T / 2, to one side or the other.
        let beside = match to {
            Method::ExplicitEuler => g * (-H / 2.0),
            Method::SemiImplicitEuler | Method::ImplicitEuler => g * (H / 2.0),
            _ => DVec3::ZERO,
        };
        for tick in 1..=100 {
            lab.run(1);
            let t = f64::from(tick) * H;
            let exact = x + (v + beside + g * (t / 2.0)) * t;
            let error = lab.x(0).distance(exact);
            let bound = 8.0 * f64::from(tick) * f64::EPSILON * (x.length() + v.length() + 16.0 * t);
            assert!(error <= bound, "{from:?} {to:?} tick {tick}: {error:e}, at most {bound:e}");
            let behind = if to == Method::PositionVerlet { H / 2.0 } else { 0.0 };
            let error = lab.v(0).distance(v + g * (t - behind));
            assert!(
                error <= bound,
                "{from:?} {to:?} tick {tick}: velocity {error:e}, at most {bound:e}"
            );
        }
    }
}

/// Largest errors of position and velocity in the second after the switch, in steps of 1/`steps` s.
fn errors(from: Method, to: Method, steps: u32) -> [f64; 2] {
    const FINE: u32 = 512;
    let scene = Environment::orbiting();
    let (mut lab, [_, (x, v)]) =
        switched(&scene, [from, to], 1.0 / f64::from(steps), u64::from(steps / 4));
    let mut exact: Bare = scene.bare(Method::RungeKutta4, 0.125 / f64::from(FINE));
    add(&mut exact, Start { x, v, w: START.w });
    let mut largest = [0.0_f64; 2];
    for _ in 0..8 {
        lab.run(u64::from(steps / 8));
        (0..FINE).for_each(|_| exact.tick());
        let errors =
            [lab.x(0).distance(position(&exact, 0)), lab.v(0).distance(velocity(&exact, 0))];
        largest = [0, 1].map(|column| largest[column].max(errors[column]));
    }
    largest
}

#[test]
fn the_new_method_keeps_its_order_on_an_orbit() {
    for (from, to) in pairs() {
        let claims = to.claims();
        let steps = if claims.position_order == 4 { 128 } else { 512 };
        let (coarse, fine) = (errors(from, to, steps), errors(from, to, 2 * steps));
        for (column, claimed) in
            [claims.position_order, claims.velocity_order].into_iter().enumerate()
        {
            let order = (coarse[column] / fine[column]).log2();
            let off = (order - f64::from(claimed)).abs();
            assert!(
                off <= 0.1,
                "{from:?} {to:?}: order {order:.3} in column {column}, claimed {claimed}"
            );
        }
    }
}

/// An error of a h / 2 in the velocity that position Verlet leaves would leave order 1.
#[test]
fn the_whole_way_has_the_lower_order_of_the_two() {
    let run = |from, to, steps: u32| {
        let mut lab = Environment::orbiting().lab(from, 1.0 / f64::from(steps));
        lab.spawn(START);
        lab.run(u64::from(steps / 2));
        lab.set_method(to);
        lab.run(u64::from(steps / 2)).x(0)
    };
    let exact = run(Method::RungeKutta4, Method::Yoshida4, 2048);
    for (from, to) in pairs() {
        let lower = from.claims().position_order.min(to.claims().position_order);
        let steps = if lower == 4 { 64 } else { 512 };
        let error = |steps| run(from, to, steps).distance(exact);
        let order = (error(steps) / error(2 * steps)).log2();
        assert!((order - f64::from(lower)).abs() <= 0.15, "{from:?} {to:?}: {order:.3}");
    }
}
