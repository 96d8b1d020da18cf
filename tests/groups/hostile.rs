//! Springs and members that break: who was first is quarantined, and no other notices.

use glam::DVec3;
use motion::internals::Solver;
use motion::{
    Cause, Curve, Damping, DampingModel, Drag, Elastic, EvaluationTime, Fault, Method,
    MutualGravity, OwnLaws, Request, SoftBody, Thrust, Wind,
};

use crate::rigs::{
    Dice, Environment, Formula, Lab, Net, Start, elastic, net::H, pendulum, tetrahedron,
};

/// Two triangles joined by a bridge, hung on a post, and two bodies beside them.
fn bridge() -> Net {
    let mut dice = Dice(21);
    let mut bodies: Vec<_> =
        (0..7).map(|i| Start::of(1.0 + i as f64, dice.vector() * 2.0, dice.vector())).collect();
    bodies.push(Start::held(DVec3::Y * 2.0));
    bodies.extend([40.0, 50.0].map(|x| Start::of(1.0, DVec3::X * x, DVec3::Y)));
    let ends = [[0, 1], [1, 2], [2, 0], [2, 3], [3, 4], [4, 5], [5, 6], [6, 4], [7, 0], [7, 5]];
    Net { bodies, springs: ends.map(|ends| (ends, elastic(30.0 + ends[1] as f64, 0.6))).into() }
}

fn engine() -> OwnLaws {
    OwnLaws::new(vec![Box::new(Thrust::new(Curve::Polynomial(vec![DVec3::ONE]), 2.3 * H, 60.0))])
}

/// A law that gives no number from a time on.
fn broken_from(time: f64) -> OwnLaws {
    let number =
        move |at: EvaluationTime, _| if at.within_step < time { DVec3::ZERO } else { DVec3::NAN };
    OwnLaws::new(vec![Box::new(Formula::new("broken", number).jumping_at(time))])
}

fn surroundings() -> [(&'static str, Environment); 5] {
    let damping = Some(Damping { model: DampingModel::Tutorial, rate: 0.4 });
    let drag = Some(Drag::new(0.1, 0.05));
    // Steady and linear: a law that is summed up before the tick.
    let wind =
        Drag { wind: Some(Wind { velocity: DVec3::X, ..Wind::default() }), ..Drag::new(0.3, 0.0) };
    let attraction = Some(MutualGravity { constant: 0.5, softening: 0.3 });
    [
        ("gravity", Environment::falling()),
        ("drag, damping", Environment { drag, damping, ..Environment::falling() }),
        ("wind", Environment { drag: Some(wind), ..Environment::falling() }),
        ("mutual gravity", Environment { attraction, ..Environment::default() }),
        ("substeps", Environment { substeps: Some(3), ..Environment::falling() }),
    ]
}

/// Two runs of one net: in the tick 11 the culprits break in the one, and are removed in the other.
#[track_caller]
fn no_other_notices(what: &str, make: impl Fn() -> Lab, culprits: &[usize], push: DVec3) {
    let (mut rig, mut without) = (make(), make());
    rig.run(10);
    without.run(10);
    let before: Vec<_> = culprits.iter().map(|culprit| rig.bits(*culprit)).collect();
    for culprit in culprits {
        rig.push(*culprit, push);
        without.ask(Request::Remove(without.bodies[*culprit]));
    }
    for tick in 0..20 {
        rig.run(1);
        without.run(1);
        let mut quarantined = rig.quarantined();
        quarantined.sort_unstable();
        assert_eq!(quarantined, culprits, "{what}, tick {tick}");
        assert_eq!(rig.all_bits(culprits), without.all_bits(culprits), "{what}, tick {tick}");
    }
    let after: Vec<_> = culprits.iter().map(|culprit| rig.bits(*culprit)).collect();
    assert_eq!(before, after, "{what}: a culprit stays where it was");
    for record in rig.records() {
        assert_eq!((record.tick, record.cause.system), (11, "integrate_groups"), "{what}");
    }
}

#[test]
fn a_member_that_breaks_is_quarantined_and_the_others_go_on_as_without_it() {
    for method in Method::ALL {
        for (name, around) in surroundings() {
            let make = || {
                let mut rig = bridge().lab(&around, method, H);
                rig.insert(6, engine());
                rig
            };
            for culprit in [0, 2, 3, 6] {
                let what = format!("{method:?}, {name}, {culprit}");
                for push in [DVec3::X * f64::NAN, DVec3::Y * f64::NEG_INFINITY] {
                    no_other_notices(&what, make, &[culprit], push);
                }
            }
        }
    }
}

#[test]
fn two_members_that_break_in_one_tick_are_quarantined_both() {
    for method in Method::ALL {
        for (name, around) in surroundings() {
            for culprits in [[2, 3], [0, 6], [1, 5]] {
                let what = format!("{method:?}, {name}, {culprits:?}");
                let make = || bridge().lab(&around, method, H);
                no_other_notices(&what, make, &culprits, DVec3::NAN);
            }
        }
    }
}

#[test]
fn a_member_that_is_left_alone_goes_on_as_a_single_body() {
    for method in Method::ALL {
        for (name, around) in surroundings() {
            let bodies = tetrahedron().bodies;
            let net = Net::pair(bodies[0], bodies[1], elastic(50.0, 1.0));
            let what = format!("{method:?}, {name}");
            let make = || {
                let mut rig = net.lab(&around, method, H);
                rig.insert(1, engine());
                rig
            };
            no_other_notices(&what, make, &[0], DVec3::NAN);
        }
    }
}

/// The law breaks within tick 11, after the first segment of a split step.
#[test]
fn a_member_whose_own_law_breaks_is_quarantined() {
    for method in Method::ALL {
        let mut rig = bridge().lab(&Environment::falling(), method, H);
        rig.insert(3, broken_from(10.5 * H));
        rig.run(40);
        assert_eq!(rig.quarantined(), [3], "{method:?}");
        let record = rig.records()[0];
        let cause =
            Cause { system: "integrate_groups", component: "OwnLaws", fault: Fault::Law("broken") };
        assert_eq!((record.tick, record.cause), (11, cause), "{method:?}");
        assert!(rig.states().iter().all(|(x, v)| x.is_finite() && v.is_finite()), "{method:?}");
    }
}

/// A point of a sheet takes its triangles with it, and its neighbors' masses are shared again.
#[test]
fn a_point_of_a_sheet_that_breaks_is_quarantined_and_the_others_go_on_as_without_it() {
    let blow = Wind { velocity: DVec3::new(1.0, 3.0, 0.0), gust: 1.0, gust_hz: 1.0 };
    let around = Environment {
        drag: Some(Drag { wind: Some(blow), ..Drag::new(0.5, 0.2) }),
        ..Environment::falling()
    };
    for method in Method::ALL {
        let make = || {
            let mut rig = bridge().lab(&around, method, H);
            let points = rig.bodies.clone();
            let triangles = vec![[0, 1, 2], [4, 5, 6], [2, 4, 3], [0, 7, 5]];
            rig.soft(SoftBody { points, triangles, sheet: true, ..SoftBody::default() });
            rig
        };
        for culprit in [1, 2, 6] {
            let what = format!("{method:?}, {culprit}");
            no_other_notices(&what, make, &[culprit], DVec3::NAN);
        }
    }
}

#[test]
fn springs_that_are_no_numbers_quarantine_an_end_and_nothing_else() {
    for stiffness in [f64::INFINITY, f64::NAN, f64::MAX] {
        for method in Method::ALL {
            let mut rig = bridge().lab(&Environment::falling(), method, H);
            let mut twin = bridge().lab(&Environment::falling(), method, H);
            rig.run(10);
            twin.run(10);
            rig.spring([3, 6], elastic(stiffness, 0.1));
            rig.run(100);
            twin.run(100);
            let quarantined = rig.quarantined();
            let what = format!("{method:?}, k = {stiffness}: {quarantined:?}");
            assert!(matches!(quarantined[..], [3 | 6]), "{what}");
            // Not those beside the group, and no other lost its numbers.
            for body in [8, 9] {
                assert_eq!(rig.bits(body), twin.bits(body), "{what}");
            }
            assert!(rig.states().iter().all(|(x, v)| x.is_finite() && v.is_finite()), "{what}");
        }
    }
}

#[test]
fn a_stiffness_of_1e30_breaks_no_other_group() {
    let mut net = pendulum(100.0);
    let (a, b) =
        (Start::of(1.0, DVec3::X * 9.0, DVec3::Y), Start::of(2.0, DVec3::X * 10.5, DVec3::ZERO));
    let first = net.and(&Net::pair(a, b, elastic(1e30, 1.0)));
    for method in Method::ALL {
        let mut rig = net.lab(&Environment::falling(), method, H);
        let mut alone = pendulum(100.0).lab(&Environment::falling(), method, H);
        rig.run(200);
        alone.run(200);
        assert_eq!(rig.bits(1), alone.bits(1), "{method:?}");
        assert!(rig.states().iter().all(|(x, v)| x.is_finite() && v.is_finite()), "{method:?}");
        if method == Method::ImplicitEuler {
            assert!(rig.quarantined().is_empty());
            let length = rig.x(first).distance(rig.x(first + 1));
            assert!((length - 1.0).abs() <= 1e-6, "{length}");
        }
    }
}

#[test]
fn ends_at_one_place_and_springs_to_oneself_pull_nothing() {
    for method in Method::ALL {
        let bodies =
            vec![Start::of(1.0, DVec3::ONE, DVec3::X), Start::of(2.0, DVec3::ONE, DVec3::X)];
        let spring = Elastic { damping: 5.0, ..elastic(1e3, 0.5) };
        let net = Net { bodies, springs: vec![([0, 1], spring), ([0, 0], spring)] };
        let mut rig = net.lab(&Environment::default(), method, 1.0 / 64.0);
        rig.run(64);
        for body in [0, 1] {
            assert_eq!(rig.state(body), (DVec3::new(2.0, 1.0, 1.0), DVec3::X), "{method:?}");
        }
        // At one place only at the start, they part or not, and stay finite and symmetric.
        let [a, b] = [DVec3::X, -DVec3::X].map(|v| Start::of(1.0, DVec3::ZERO, v));
        let mut rig = Net::pair(a, b, spring).lab(&Environment::default(), method, 1.0 / 256.0);
        for _ in 0..256 {
            rig.run(1);
            assert_eq!(rig.x(0), -rig.x(1), "{method:?}");
        }
        assert!(rig.quarantined().is_empty(), "{method:?}");
        let apart = rig.x(0).distance(rig.x(1));
        assert!(
            method.claims().stability_limit == 0.0 || (apart - 0.5).abs() <= 0.05,
            "{method:?}: {apart}"
        );
    }
}

#[test]
fn two_springs_are_as_stiff_as_one_of_both() {
    for method in Method::ALL {
        let net = |springs: &[f64]| {
            let bodies = tetrahedron().bodies[..2].to_vec();
            Net { bodies, springs: springs.iter().map(|k| ([0, 1], elastic(*k, 1.0))).collect() }
        };
        let mut double = net(&[32.0, 32.0]).lab(&Environment::default(), method, H);
        let mut single = net(&[64.0]).lab(&Environment::default(), method, H);
        for _ in 0..60 {
            double.run(1);
            single.run(1);
            let error = double.x(0).distance(single.x(0)) + double.v(1).distance(single.v(1));
            // The solver of implicit steps adds up in another order.
            let bound = if method == Method::ImplicitEuler { 1e-13 } else { 0.0 };
            assert!(error <= bound, "{method:?}: {error:e}");
        }
    }
}

#[test]
fn a_million_springs_hang_on_one_node() {
    let mut dice = Dice(11);
    let count = 1_000_000;
    let node = Start::of(1e6, DVec3::ZERO, DVec3::ZERO);
    let bodies =
        std::iter::once(node).chain((0..count).map(|_| Start::of(1.0, dice.vector(), DVec3::ZERO)));
    let net = Net {
        bodies: bodies.collect(),
        springs: (1..=count).map(|i| ([0, i], elastic(100.0, 0.5))).collect(),
    };
    let solver = Some(Solver { most_iterations: 20, ..Solver::default() });
    let mut rig =
        net.lab(&Environment { solver, ..Environment::default() }, Method::SemiImplicitEuler, H);
    for method in [Method::SemiImplicitEuler, Method::RungeKutta4, Method::ImplicitEuler] {
        rig.set_method(method);
        rig.run(2);
        let sum = rig.totals();
        assert!(rig.quarantined().is_empty() && sum.kinetic_energy > 0.0);
        assert!(sum.momentum.length() <= 1e-14 * 1e6 * 10.0, "{method:?}: {}", sum.momentum);
    }
}

/// No spring of this cloth pulls with a finite force: quarantining one member after the other would take a tick for each.
#[test]
fn a_cloth_that_breaks_as_a_whole_is_quarantined_in_a_few_ticks() {
    let side = 60;
    let at = |i: usize, j: usize| i * side + j;
    let place = |i: usize, j: usize| DVec3::new(i as f64, j as f64, 0.0) * 1e306;
    let inside = |i: &usize| *i + 1 < side;
    let pairs = (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
    let springs = pairs.clone().flat_map(|(i, j)| {
        let right = inside(&j).then(|| [at(i, j), at(i, j + 1)]);
        let down = inside(&i).then(|| [at(i, j), at(i + 1, j)]);
        let across = (inside(&i) && inside(&j)).then(|| [at(i, j), at(i + 1, j + 1)]);
        right.into_iter().chain(down).chain(across)
    });
    let net = Net {
        bodies: pairs.map(|(i, j)| Start::of(1.0, place(i, j), DVec3::ZERO)).collect(),
        springs: springs.map(|ends| (ends, elastic(1e5, 0.1))).collect(),
    };
    for method in Method::ALL {
        let mut rig = net.lab(&Environment::default(), method, H);
        rig.run(1);
        let quarantined = rig.quarantined().len();
        // A third of a net of triangles is left at most: no two that a spring joins.
        assert!(
            quarantined >= side * side / 2 && quarantined < side * side,
            "{method:?}: {quarantined}"
        );
        rig.run(2);
        assert_eq!(rig.quarantined().len(), quarantined, "{method:?}");
    }
}

#[test]
fn a_spring_waits_for_no_one() {
    for method in Method::ALL {
        let mut rig = pendulum(100.0).lab(&Environment::falling(), method, H);
        let (gone, first) = (rig.world.spawn_empty().id(), rig.bodies[1]);
        rig.world.despawn(gone);
        rig.spring([gone, first], elastic(1e5, 0.0));
        let added = rig.body(1.0, DVec3::X);
        rig.run(3);
        rig.spring([added, first], elastic(10.0, 1.0));
        rig.run(3);
        assert_eq!(rig.world.resource::<motion::internals::Groups>().bodies(), 2, "{method:?}");
        rig.ask(Request::Remove(added)).run(3);
        assert_eq!(rig.world.resource::<motion::internals::Groups>().bodies(), 1, "{method:?}");
        assert!(rig.x(1).is_finite() && rig.x(1).length() < 3.0, "{method:?}");
    }
}

#[test]
fn mutual_gravity_that_is_replaced_acts_from_then_on() {
    for method in Method::ALL.into_iter().filter(|method| *method != Method::PositionVerlet) {
        let of = |constant| MutualGravity { constant, softening: 0.1 };
        let net = Net::free(tetrahedron().bodies);
        let mut rig = net.lab(
            &Environment { attraction: Some(of(1.0)), ..Environment::default() },
            method,
            H,
        );
        rig.run(20);
        let mut now = net.clone();
        now.bodies
            .iter_mut()
            .zip(rig.states())
            .for_each(|(body, (x, v))| (body.x, body.v) = (x, v));
        let mut twin = now.lab(
            &Environment { attraction: Some(of(3.0)), ..Environment::default() },
            method,
            H,
        );
        rig.world.insert_resource(of(3.0));
        rig.agrees(&mut twin, 10, &[], method.name());
        rig.world.remove_resource::<MutualGravity>();
        rig.recompile();
        let before = rig.states();
        rig.run(10);
        for ((_, v), (_, old)) in rig.states().iter().zip(&before) {
            assert_eq!(v, old, "{method:?}");
        }
    }
}

#[test]
fn mutual_gravity_that_comes_to_springs_acts() {
    let mut net = tetrahedron();
    net.bodies.push(Start::of(5.0, DVec3::new(3.0, 1.0, 2.0), DVec3::ZERO));
    let attraction = MutualGravity { constant: 1.0, softening: 0.1 };
    for method in Method::ALL {
        let mut rig = net.lab(&Environment::default(), method, H);
        rig.world.insert_resource(attraction);
        rig.recompile();
        let mut twin = net.lab(
            &Environment { attraction: Some(attraction), ..Environment::default() },
            method,
            H,
        );
        rig.agrees(&mut twin, 10, &[], method.name());
    }
}
