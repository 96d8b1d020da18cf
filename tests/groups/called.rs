//! Implicit Euler steps of groups under laws that depend on the state of a body: each step is solved until it converges.

use glam::{DMat3, DVec3};
use motion::{AxisLocks, BodyState, Jacobians, Laws, Method};

use crate::rigs::{Environment, Formula, Lab, Net, Start, elastic, net::H, ring};

const IMPLICIT: Method = Method::ImplicitEuler;

/// `a = w × v`, as on a charge in a magnetic field.
fn turning(w: DVec3) -> Formula {
    let matrix = DMat3::from_cols(w.cross(DVec3::X), w.cross(DVec3::Y), w.cross(DVec3::Z));
    Formula::new("turning", move |_, body| w.cross(body.velocity))
        .with_jacobians(move |_| Jacobians { velocity: matrix, ..Jacobians::zero() })
        .of_velocity(true)
}

/// Friction that hardly depends on the speed: `a = -most v / sqrt(v² + slow²)`.
fn sliding(most: f64, slow: f64) -> Formula {
    let length = move |v: DVec3| v.length().hypot(slow);
    Formula::new("sliding", move |_, body| body.velocity * (-most / length(body.velocity)))
        .with_jacobians(move |BodyState { velocity: v, .. }| {
            let (r, outer) = (length(v), DMat3::from_cols(v * v.x, v * v.y, v * v.z));
            let velocity = (DMat3::IDENTITY - outer * (1.0 / (r * r))) * (-most / r);
            Jacobians { velocity, ..Jacobians::zero() }
        })
        .of_velocity(true)
}

fn with_law(net: &Net, law: Formula, around: &Environment) -> Lab {
    let mut rig = net.lab(around, IMPLICIT, H);
    rig.world.insert_resource(Laws(vec![Box::new(law)]));
    rig.recompile();
    rig
}

#[test]
fn a_law_that_turns_velocities_slows_members_of_groups_as_it_slows_a_single_body() {
    let moving = Start::of(1.0, DVec3::ZERO, DVec3::X);
    let spring = elastic(1e-6, 1.0);
    for turn in [1.0, 10.0, 100.0, 1e4] {
        let law = || turning(DVec3::Z * turn);
        let net = Net::pair(moving, Start::of(1.0, DVec3::X * 3.0, DVec3::ZERO), spring);
        let [mut member, mut single] =
            [net, Net::free([moving])].map(|net| with_law(&net, law(), &Environment::default()));
        for tick in 1..=300 {
            member.run(1);
            single.run(1);
            let exact = (turn * H).hypot(1.0).powi(-tick);
            let [a, b] = [&member, &single].map(|rig| rig.v(0).length());
            // The spring gives 1e-7 m/s at most in this time.
            assert!(
                (a - exact).abs() <= 1e-5 && (b - exact).abs() <= 1e-9,
                "{turn}/s, tick {tick}: {a}, {b}, {exact}"
            );
        }
        assert_eq!(member.evaluations().unconverged_steps(), 0, "{turn}/s");
    }
}

/// Largest residual of `v1 = v0 + h a(x1, v1)` over some ticks, m/s, relative to the largest speed above 1 m/s.
fn residual(net: &Net, law: impl Fn() -> Formula, ticks: u64) -> f64 {
    let mut rig = with_law(net, law(), &Environment::default());
    let formula = law();
    let mut largest = 0.0_f64;
    for _ in 0..ticks {
        let before = rig.states();
        rig.run(1);
        let after = rig.states();
        let fastest = after.iter().map(|(_, v)| v.length()).fold(1.0, f64::max);
        for (number, force) in net.forces(&after).into_iter().enumerate() {
            let (w, (x, v)) = (net.bodies[number].w, after[number]);
            if w > 0.0 {
                let state = BodyState { position: x, velocity: v, inverse_mass: w };
                let a = force * w + formula.at(0.0, state);
                largest = largest.max((v - before[number].1 - a * H).length() / fastest);
            }
        }
    }
    assert_eq!(rig.evaluations().unconverged_steps(), 0);
    largest
}

/// Two bodies pressed together on a stiff spring, and a ring of springs beside them.
fn pressed() -> Net {
    let mut pressed = Net::pair(
        Start::of(1.0, DVec3::ZERO, DVec3::new(0.3, 0.2, 0.0)),
        Start::of(2.0, DVec3::new(0.5, 0.0, 0.0), DVec3::new(-0.2, 0.1, 0.4)),
        elastic(1e3, 1.0),
    );
    pressed.and(&ring());
    pressed
}

#[test]
fn steps_under_called_laws_solve_the_implicit_equation() {
    let net = pressed();
    for turn in [5.0, 50.0, 500.0] {
        let left = residual(&net, || turning(DVec3::new(0.6, 0.0, 0.8) * turn), 60);
        assert!(left <= 1e-10, "turning at {turn}/s: {left:e}");
    }
    for most in [1.0, 100.0] {
        let left = residual(&net, || sliding(most, 1e-2), 60);
        assert!(left <= 1e-10, "sliding by {most} m/s²: {left:e}");
    }
    let repelled = || {
        Formula::new("repelled", |_, body| body.position * 900.0).with_jacobians(|_| Jacobians {
            position: DMat3::from_diagonal(DVec3::splat(900.0)),
            ..Jacobians::zero()
        })
    };
    let left = residual(&net, repelled, 20);
    assert!(left <= 1e-10, "repelled: {left:e}");
}

#[test]
fn locked_axes_stay_out_of_steps_under_called_laws() {
    let mut net = pressed();
    let locks = |number: usize| [0, 1, 2].map(|axis| (number + axis).is_multiple_of(3));
    for (number, body) in net.bodies.iter_mut().enumerate() {
        body.v = DVec3::from_array(
            [0, 1, 2].map(|axis| if locks(number)[axis] { 0.0 } else { body.v[axis] }),
        );
    }
    for law in [|| turning(DVec3::new(0.6, 0.5, 0.6) * 50.0), || sliding(10.0, 1e-2)] {
        let mut rig = with_law(&net, law(), &Environment::default());
        for number in 0..net.bodies.len() {
            let [x, y, z] = locks(number);
            rig.insert(number, AxisLocks { x, y, z });
        }
        let formula = law();
        for tick in 0..60 {
            let before = rig.states();
            rig.run(1);
            let after = rig.states();
            for (number, force) in net.forces(&after).into_iter().enumerate() {
                let (Start { x: start, w, .. }, (x, v)) = (net.bodies[number], after[number]);
                let a = force * w
                    + formula.at(0.0, BodyState { position: x, velocity: v, inverse_mass: w });
                let left = v - before[number].1 - a * H;
                for axis in 0..3 {
                    if locks(number)[axis] {
                        assert_eq!(
                            (v[axis], x[axis]),
                            (0.0, start[axis]),
                            "tick {tick}, body {number}"
                        );
                    } else {
                        assert!(left[axis].abs() <= 1e-10, "tick {tick}, body {number}: {left}");
                    }
                }
            }
        }
        assert_eq!(rig.evaluations().unconverged_steps(), 0);
    }
}

/// `v1 = v + h k v1²` has no solution from `4 h k v = 1` on.
#[test]
fn steps_without_a_solution_are_counted() {
    let blowing =
        Formula::new("blowing", |_, body| DVec3::X * (100.0 * body.velocity.length_squared()))
            .with_jacobians(|BodyState { velocity: v, .. }| Jacobians {
                velocity: DMat3::from_cols(DVec3::X * v.x, DVec3::X * v.y, DVec3::X * v.z) * 200.0,
                ..Jacobians::zero()
            })
            .of_velocity(true);
    let moving = Start::of(1.0, DVec3::ZERO, DVec3::X);
    let net = Net::pair(moving, Start::of(1.0, DVec3::X * 3.0, DVec3::X), elastic(1e-6, 3.0));
    let mut rig = with_law(&net, blowing, &Environment::default());
    rig.run(10);
    assert_eq!(rig.evaluations().unconverged_steps(), 10);
    assert!(rig.quarantined().is_empty());
}

/// An engine depends on time alone: its steps stay linearized, with one evaluation each.
#[test]
fn laws_of_time_alone_take_no_newton_iterations() {
    let mut rig = pressed().lab(&Environment::default(), IMPLICIT, H);
    let thrust = Formula::new("thrust", |at, _| DVec3::Y * at.time);
    rig.world.insert_resource(Laws(vec![Box::new(thrust)]));
    rig.recompile();
    rig.run(10);
    assert_eq!(rig.evaluations().newton_iterations(), 0);
    assert_eq!(rig.evaluations().accelerations(), 10 * rig.bodies.len() as u64);
}
