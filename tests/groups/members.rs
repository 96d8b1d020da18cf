//! What members ask for, and what is asked of them, does to them what it does to single bodies.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::internals::Solver;
use motion::{
    AxisLocks, Curve, Damping, DampingModel, DampingRate, Drag, Elastic, Gravity, GravityOff,
    METHODS, Method, OwnLaws, Request, SpeedLimit, Thrust, Well, Wells, Wind,
};

use crate::rigs::{
    Environment, Lab, Net, Start, State, elastic, extrapolated, net::H, tetrahedron,
};

/// Two bodies on a spring that does not pull, or on none, and a post that moves on, on such a spring as well or on
/// none.
fn pair(joined: bool, post: bool) -> Net {
    let bodies = vec![
        Start { x: DVec3::new(1.5, 0.2, -0.3), v: DVec3::new(0.3, 1.1, 0.4), w: 0.5 },
        Start { x: DVec3::new(-2.0, 1.0, 0.7), v: DVec3::new(-0.6, 0.2, 0.9), w: 2.0 },
        Start { x: DVec3::Z * 5.0, v: DVec3::new(1.0, 2.0, -3.0), w: 0.0 },
    ];
    let ends = if post { vec![[0, 1], [2, 1]] } else { vec![[0, 1]] };
    let springs = ends.into_iter().filter(|_| joined).map(|ends| (ends, elastic(0.0, 1.0)));
    Net { bodies, springs: springs.collect() }
}

fn engine() -> OwnLaws {
    let curve = Curve::Polynomial(vec![DVec3::new(4.0, -2.0, 1.0), DVec3::new(-1.0, 3.0, 0.5)]);
    OwnLaws::new(vec![Box::new(Thrust::new(curve, 2.3 * H, 20.4 * H))])
}

type Ask = for<'a, 'w> fn(&'a mut EntityWorldMut<'w>) -> &'a mut EntityWorldMut<'w>;

const WISHES: [(&str, Ask); 7] = [
    ("nothing", |body| body),
    ("a speed limit", |body| body.insert(SpeedLimit(1.3))),
    ("locks", |body| body.insert(AxisLocks { x: true, y: false, z: true })),
    ("its own damping", |body| body.insert(DampingRate::new(2.5))),
    ("no gravity", |body| body.insert(GravityOff)),
    ("an engine", |body| body.insert(engine())),
    ("everything", |body| {
        let locks = AxisLocks { x: false, y: true, z: false };
        body.insert((SpeedLimit(2.0), locks, DampingRate::new(1.0), GravityOff, engine()))
    }),
];

fn surroundings() -> Vec<(&'static str, Environment)> {
    let fall = Environment::falling;
    let damped = |model| Environment { damping: Some(Damping { model, rate: 0.7 }), ..fall() };
    let well = Well { position: DVec3::new(0.0, -1.0, 0.5), strength: 3.0, softening: 0.7 };
    let wind = Wind { velocity: DVec3::new(3.0, 0.5, -1.0), gust: 1.0, gust_hz: 2.0 };
    vec![
        ("gravity", fall()),
        ("drag", Environment { drag: Some(Drag::new(0.4, 0.0)), ..fall() }),
        ("quadratic drag", Environment { drag: Some(Drag::new(0.1, 0.05)), ..fall() }),
        (
            "wind",
            Environment { drag: Some(Drag { wind: Some(wind), ..Drag::new(0.3, 0.1) }), ..fall() },
        ),
        ("wells", Environment { wells: Some(Wells(vec![well])), ..Environment::default() }),
        ("exact damping", damped(DampingModel::Exact)),
        ("clamped damping", damped(DampingModel::Clamped)),
        ("tutorial damping", damped(DampingModel::Tutorial)),
        (
            "damping and drag",
            Environment { drag: Some(Drag::new(0.4, 0.0)), ..damped(DampingModel::Exact) },
        ),
    ]
}

#[test]
fn a_member_that_nothing_pulls_moves_like_a_single_body() {
    let solver = Some(Solver { tolerance: 1e-15, most_iterations: 500, newton_iterations: 10 });
    for method in Method::ALL {
        for (name, around) in surroundings() {
            for substeps in [1, 3] {
                let around = Environment { substeps: Some(substeps), solver, ..around.clone() };
                for (wish, ask) in WISHES {
                    let [mut member, mut single] = [true, false]
                        .map(|joined| pair(joined, substeps == 3).lab(&around, method, H));
                    for rig in [&mut member, &mut single] {
                        ask(&mut rig.world.entity_mut(rig.bodies[0]));
                        rig.recompile();
                    }
                    for tick in 0..24 {
                        for rig in [&mut member, &mut single] {
                            if tick == 7 {
                                rig.push(0, DVec3::new(40.0, -10.0, 25.0));
                            }
                            rig.run(1);
                        }
                        // A step that is split for an engine is split for the whole group.
                        let engines = ["an engine", "everything"].contains(&wish);
                        for body in if engines { 0..1 } else { 0..2 } {
                            let ((x, v), (sx, sv)) = (member.state(body), single.state(body));
                            let error = x.distance(sx) + v.distance(sv);
                            // A few roundings a step; Newton's method stops some 1e-12 before the root.
                            let of_a_step = if method == Method::ImplicitEuler {
                                1e-12
                            } else {
                                8.0 * f64::EPSILON
                            };
                            let size = sx.length() + sv.length() + 1.0;
                            let bound = of_a_step * size * f64::from((tick + 1) * substeps);
                            assert!(
                                error <= bound,
                                "{method:?}, {name}, {wish}, body {body}, {substeps} substeps, tick {tick}: \
                                 {error:e}, at most {bound:e}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_push_gives_force_times_time_over_mass_at_every_number_of_substeps() {
    let push = DVec3::new(100.0, -50.0, 25.0);
    for method in Method::ALL {
        for substeps in [1, 3, 8] {
            let around = Environment { substeps: Some(substeps), ..Environment::default() };
            let mut rig = pair(true, false).lab(&around, method, H);
            let before = [rig.v(0), rig.v(1)];
            rig.push(0, push);
            // It is over after its tick, and the neighbour has none of it.
            for ticks in [1, 3] {
                rig.run(ticks);
                let gained = rig.v(0) - before[0];
                let bound = 2.0 * f64::EPSILON * f64::from(substeps + 1);
                assert!(
                    gained.distance(push * (0.5 * H)) <= bound,
                    "{method:?}, {substeps}: {gained}"
                );
            }
            assert_eq!(rig.v(1), before[1], "{method:?}, {substeps}");
        }
    }
}

#[test]
fn a_push_on_a_net_is_an_impulse_on_the_whole() {
    let push = DVec3::new(100.0, -50.0, 25.0);
    for method in Method::ALL {
        for substeps in [1, 3, 8] {
            let around = Environment { substeps: Some(substeps), ..Environment::default() };
            let mut rig = tetrahedron().lab(&around, method, H);
            rig.run(5);
            let before = rig.totals().momentum;
            rig.push(0, push).push(2, push * 0.5).run(1);
            let gained = rig.totals().momentum - before;
            assert!(gained.distance(push * (1.5 * H)) <= 1e-13, "{method:?}, {substeps}: {gained}");
        }
    }
}

/// A second of the tetrahedron with something done in the middle; exactly, and by a method.
struct Halves {
    net: Net,
    exact: Vec<State>,
}

impl Halves {
    fn new(change: impl Fn(&mut Net, &mut Vec<State>)) -> Self {
        let mut net = tetrahedron();
        let half = |net: &Net, start: &[State]| {
            let springs = net.clone();
            let a = move |_: f64, state: &[State]| {
                let forces = springs.forces(state);
                forces.iter().zip(&springs.bodies).map(|(force, body)| *force * body.w).collect()
            };
            extrapolated(start, 0.5, 1, 1 << 11, a).pop().unwrap()
        };
        let mut state = half(&net, &net.start());
        change(&mut net, &mut state);
        let exact = half(&net, &state);
        Self { net: tetrahedron(), exact }
    }

    /// Distance of the positions from the exact ones.
    fn error(&self, steps: u32, method: Method, but: &[usize], change: impl Fn(&mut Lab)) -> f64 {
        let mut rig = self.net.lab(&Environment::default(), method, 1.0 / f64::from(steps));
        rig.run(u64::from(steps / 2));
        change(&mut rig);
        rig.run(u64::from(steps / 2));
        let bodies = (0..4).filter(|body| !but.contains(body));
        bodies.map(|body| rig.x(body).distance(self.exact[body].0)).fold(0.0, f64::max)
    }

    fn order(&self, lowest: u32, method: Method, but: &[usize], change: impl Fn(&mut Lab)) -> f64 {
        let steps = if lowest == 1 { 4096 } else { 512 };
        let (coarse, fine) =
            (self.error(steps, method, but, &change), self.error(2 * steps, method, but, &change));
        (coarse / fine).log2()
    }
}

#[test]
fn every_switch_of_the_method_goes_on_with_the_lower_order_of_the_two() {
    let halves = Halves::new(|_, _| {});
    for from in METHODS {
        for to in METHODS.iter().filter(|to| to.method != from.method) {
            let lowest = from.position_order.min(to.position_order);
            let order = halves.order(lowest, from.method, &[], |rig| rig.set_method(to.method));
            let off = (order - f64::from(lowest)).abs();
            assert!(off <= 0.15, "{} to {}: {order:.3}", from.name, to.name);
            // The method of a member is that of all.
            if to.position_order > 1 && from.position_order > 1 {
                let order = halves.order(lowest, from.method, &[], |rig| {
                    rig.have(Request::SetBodyMethod(rig.bodies[2], Some(to.method)));
                });
                let off = (order - f64::from(lowest)).abs();
                assert!(off <= 0.15, "{} to {} by a member: {order:.3}", from.name, to.name);
            }
        }
    }
}

type Change = (&'static str, fn(&mut Net, &mut Vec<State>), fn(&mut Lab));

const CHANGES: [Change; 6] = [
    (
        "velocity",
        |_, state| state[1].1 = DVec3::new(0.5, -1.0, 2.0),
        |rig| rig.have(Request::SetVelocity(rig.bodies[1], DVec3::new(0.5, -1.0, 2.0))),
    ),
    (
        "impulse",
        |_, state| state[1].1 += DVec3::new(0.5, -1.0, 2.0) * 0.5,
        |rig| rig.have(Request::Impulse(rig.bodies[1], DVec3::new(0.5, -1.0, 2.0))),
    ),
    (
        "position",
        |_, state| state[2].0 = DVec3::new(0.3, 0.9, 0.6),
        |rig| rig.have(Request::SetPosition(rig.bodies[2], DVec3::new(0.3, 0.9, 0.6))),
    ),
    (
        "inverse mass",
        |net, _| net.bodies[3].w = 2.0,
        |rig| rig.have(Request::SetInverseMass(rig.bodies[3], 2.0)),
    ),
    (
        "held",
        |net, state| {
            (net.bodies[3].w, state[3].1) = (0.0, DVec3::ZERO);
        },
        |rig| {
            rig.have(Request::SetVelocity(rig.bodies[3], DVec3::ZERO));
            rig.have(Request::SetInverseMass(rig.bodies[3], 0.0));
        },
    ),
    (
        "removed",
        |net, _| net.springs.retain(|(ends, _)| !ends.contains(&3)),
        |rig| rig.have(Request::Remove(rig.bodies[3])),
    ),
];

#[test]
fn requests_on_members_keep_the_order_of_the_method() {
    let mut failures = Vec::new();
    for (name, exactly, change) in CHANGES {
        let halves = Halves::new(exactly);
        let but: &[usize] = if name == "removed" { &[3] } else { &[] };
        for claims in METHODS {
            // Position Verlet cannot know what is gone: half of the last step's kick is then without it.
            let forgets = name == "removed" && claims.method == Method::PositionVerlet;
            let claimed = if forgets { 1 } else { claims.position_order };
            let order = halves.order(claimed, claims.method, but, change);
            if (order - f64::from(claimed)).abs() > 0.15 {
                failures.push(format!("{name}, {}: {order:.3}", claims.name));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// The same net without gravity drifts beside it.
#[test]
fn gravity_that_is_set_acts_from_then_on() {
    for claims in METHODS.iter().filter(|claims| claims.position_order > 1) {
        let fall = |gravity: bool| {
            let around = if gravity { Environment::falling() } else { Environment::default() };
            let mut rig = tetrahedron().lab(&around, claims.method, 1.0 / 512.0);
            rig.run(256);
            if gravity {
                rig.have(Request::SetGravity(DVec3::X * 4.0));
            }
            rig.run(256);
            rig
        };
        let (with, without) = (fall(true), fall(false));
        let g = Gravity::EARTH.acceleration;
        let by = g * 0.125 + g * 0.25 + DVec3::X * 0.5;
        for body in 0..4 {
            let error = (with.x(body) - without.x(body) - by).length();
            assert!(error <= 1e-11, "{}: {error:e}", claims.name);
        }
    }
}

/// Damping around a tick scales the velocities of members before or after it, and not that of a moving post.
#[test]
fn damping_around_a_tick_leaves_what_members_hang_on_alone() {
    let mut net = pair(false, false);
    let spring = Elastic { damping: 3.0, ..elastic(200.0, 1.0) };
    net.springs = vec![([0, 1], spring), ([2, 1], spring)];
    let eulers = [Method::ExplicitEuler, Method::SemiImplicitEuler];
    for method in Method::ALL.into_iter().filter(|method| !eulers.contains(method)) {
        for (model, before, after) in [
            (DampingModel::Clamped, 1.0 - 5.0 * H, 1.0),
            (DampingModel::Tutorial, 1.0, 1.0 - 5.0 * H),
        ] {
            let around = Environment {
                damping: Some(Damping { model, rate: 5.0 }),
                ..Environment::falling()
            };
            let mut damped = net.lab(&around, method, H);
            let mut slower = net.clone();
            slower.bodies[..2].iter_mut().for_each(|body| body.v *= before);
            let mut plain = slower.lab(&Environment::falling(), method, H);
            damped.run(1);
            plain.run(1);
            for body in [0, 1] {
                let error = damped.x(body).distance(plain.x(body))
                    + damped.v(body).distance(plain.v(body) * after);
                assert!(error <= 1e-14, "{method:?}, {model:?}, body {body}: {error:e}");
            }
        }
    }
}
