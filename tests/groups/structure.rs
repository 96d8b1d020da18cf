//! What acts on what: orders of spawning, groups that join and split, and groups beside each other.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::internals::Groups;
use motion::{
    Damping, DampingModel, Drag, Elastic, Link, Method, MutualGravity, OwnSubsteps, PhysicsBody,
    Request, SoftBody, Spring, StableId, Transform,
};

use crate::rigs::{
    Bits, Dice, Environment, Lab, Net, Start, elastic, net::H, pendulum, tetrahedron,
};

/// Seven bodies and a post, ten springs, some of them damped.
fn web(seed: u64) -> Net {
    let mut dice = Dice(seed);
    let mut bodies: Vec<_> =
        (0..7).map(|i| Start::of(1.0 + i as f64, dice.vector() * 2.0, dice.vector())).collect();
    bodies.push(Start::held(DVec3::Y * 2.0));
    let ends = [[0, 1], [2, 1], [2, 3], [3, 4], [5, 4], [5, 6], [6, 7], [0, 7], [1, 5], [3, 0]];
    let spring = |ends: [usize; 2]| {
        let damping = if ends[0] > 2 { 0.3 } else { 0.0 };
        (ends, Elastic { damping, ..elastic(30.0 + 5.0 * ends[1] as f64, 0.4) })
    };
    Net { bodies, springs: ends.map(spring).into() }
}

fn surroundings() -> [Environment; 3] {
    let damping = Some(Damping { model: DampingModel::Clamped, rate: 0.2 });
    let attraction = Some(MutualGravity { constant: 0.5, softening: 0.3 });
    [
        Environment::falling(),
        Environment { drag: Some(Drag::new(0.1, 0.02)), damping, ..Environment::falling() },
        Environment { attraction, substeps: Some(3), ..Environment::default() },
    ]
}

/// The rigs continue tick by tick with the same bits.
#[track_caller]
fn agree(
    what: &str,
    ticks: u64,
    mut a: impl FnMut() -> Vec<Bits>,
    mut b: impl FnMut() -> Vec<Bits>,
) {
    for tick in 0..ticks {
        assert_eq!(a(), b(), "{what}, tick {tick}");
    }
}

/// The same net, its entities spawned in another order, its springs the other way round.
fn shuffled(net: &Net, around: &Environment, method: Method, seed: u64) -> Lab {
    let mut dice = Dice(seed);
    let mut rig = around.lab(method, H);
    let mut order: Vec<_> = (0..net.bodies.len()).collect();
    (1..order.len()).for_each(|i| order.swap(i, dice.below(i + 1)));
    let mut bodies = vec![Entity::PLACEHOLDER; order.len()];
    for body in order {
        let id = StableId(u32::try_from(body).unwrap());
        bodies[body] = rig.world.spawn((net.bodies[body].components(), id)).id();
        let gone = rig.world.spawn(PhysicsBody::with_mass(1.0)).id();
        rig.world.despawn(gone);
    }
    rig.bodies = bodies;
    let mut springs = net.springs.clone();
    springs.reverse();
    for ([a, b], elastic) in springs {
        rig.spring([b, a], elastic);
    }
    rig.recompile();
    rig
}

#[test]
fn the_order_of_spawning_changes_no_bit() {
    let net = web(1);
    for method in Method::ALL {
        for (i, around) in surroundings().iter().enumerate() {
            let mut a = net.lab(around, method, H);
            let mut b = shuffled(&net, around, method, 5);
            let step = |rig: &mut Lab| {
                rig.push(2, DVec3::new(3.0, 1.0, -2.0));
                rig.run(1).all_bits(&[])
            };
            agree(&format!("{method:?}, {i}"), 40, || step(&mut a), || step(&mut b));
        }
    }
}

/// Two soft bodies that share all their points.
#[test]
fn the_order_in_which_soft_bodies_are_spawned_changes_no_bit() {
    let net = Net::free(web(2).bodies);
    let links = |step: u32| {
        let link =
            |i: u32| Link { ends: [i, (i + step) % 7], elastic: elastic(20.0 + f64::from(i), 0.3) };
        (0..7).map(link).collect::<Vec<_>>()
    };
    let run = |order: [u32; 2]| {
        let mut rig = net.lab(&Environment::falling(), Method::default(), H);
        for step in order {
            let soft = SoftBody {
                points: rig.bodies.clone(),
                springs: links(step).into(),
                ..SoftBody::default()
            };
            rig.soft(soft);
        }
        rig.run(100).all_bits(&[])
    };
    assert_eq!(run([1, 2]), run([2, 1]));
}

#[test]
fn a_soft_body_is_its_springs() {
    let net = tetrahedron();
    for method in Method::ALL {
        let mut rig = net.soft(&[], &Environment::falling(), method, H);
        let mut plain = net.lab(&Environment::falling(), method, H);
        rig.agrees(&mut plain, 50, &[], method.name());
    }
}

/// Goes on from the states of `rig`, at its time, with what of `net` is left.
fn fresh(rig: &Lab, net: &Net, around: &Environment, gone: &[usize], method: Method) -> Lab {
    let mut net = net.clone();
    net.bodies.iter_mut().enumerate().filter(|(i, _)| !gone.contains(i)).for_each(|(i, body)| {
        (body.x, body.v) = rig.state(i);
    });
    let mut fresh = net.lab(around, method, H);
    fresh.world.insert_resource(*rig.world.resource::<motion::clock::StepClock>());
    for body in gone {
        fresh.have(Request::Remove(fresh.bodies[*body]));
    }
    fresh
}

/// Position Verlet alone remembers what acted in the last step.
fn without_memory() -> impl Iterator<Item = Method> {
    Method::ALL.into_iter().filter(|method| *method != Method::PositionVerlet)
}

#[test]
fn a_body_that_is_removed_takes_its_springs_with_it() {
    let net = web(3);
    for method in without_memory() {
        for around in surroundings() {
            let mut rig = net.lab(&around, method, H);
            rig.run(20);
            rig.have(Request::Remove(rig.bodies[2]));
            let mut twin = fresh(&rig, &net, &around, &[2], method);
            rig.agrees(&mut twin, 30, &[2], method.name());
        }
    }
}

#[test]
fn springs_come_and_go_in_the_middle_of_a_run() {
    let net = web(4);
    let less = Net { springs: net.springs[1..].to_vec(), ..net.clone() };
    for method in without_memory() {
        let around = Environment::falling();
        let mut rig = net.lab(&around, method, H);
        rig.run(20);
        rig.world.despawn(rig.springs[0]);
        let mut twin = fresh(&rig, &less, &around, &[], method);
        let what = format!("{method:?}");
        rig.agrees(&mut twin, 20, &[], &what);
        let (ends, elastic) = net.springs[0];
        rig.spring(ends, elastic);
        let mut twin = fresh(&rig, &net, &around, &[], method);
        rig.agrees(&mut twin, 20, &[], &what);
        // Another one in its place.
        let mut stiffer = net.clone();
        stiffer.springs[0].1 = crate::rigs::elastic(90.0, 0.1);
        let spring =
            Spring { ends: ends.map(|end| rig.bodies[end]), elastic: stiffer.springs[0].1 };
        let old = *rig.springs.last().unwrap();
        rig.world.entity_mut(old).insert(spring);
        let mut twin = fresh(&rig, &stiffer, &around, &[], method);
        rig.agrees(&mut twin, 20, &[], &what);
    }
}

#[test]
fn a_spring_without_two_bodies_does_nothing() {
    let net = web(5);
    for method in Method::ALL {
        let mut plain = net.lab(&Environment::falling(), method, H);
        let mut rig = net.lab(&Environment::falling(), method, H);
        // Frozen before it was joined, out of the way of all others.
        let quarantined = rig.body(1.0, DVec3::ZERO);
        rig.have(Request::SetVelocity(quarantined, DVec3::NAN));
        let scenery = rig.world.spawn(Transform::at(DVec3::ONE)).id();
        let gone = rig.world.spawn_empty().id();
        rig.world.despawn(gone);
        let first = rig.bodies[0];
        for ends in [
            [first, quarantined],
            [scenery, first],
            [first, gone],
            [first, first],
            [quarantined, gone],
        ] {
            rig.world.spawn(Spring { ends, elastic: elastic(1e3, 0.1) });
        }
        let what = format!("{method:?}");
        let added = net.bodies.len();
        rig.agrees(&mut plain, 30, &[added], &what);
        assert_eq!(rig.world.resource::<Groups>().springs(), net.springs.len());
    }
}

fn groups(rig: &Lab) -> (usize, usize) {
    let groups = rig.world.resource::<Groups>();
    (groups.len(), groups.bodies())
}

/// A row of five: 0 - 1 - 2 - 3 - 4.
fn row() -> Net {
    let mut dice = Dice(6);
    let body = |i: usize| {
        Start::of(1.0 + i as f64, DVec3::X * i as f64 + dice.vector() * 0.2, DVec3::ZERO)
    };
    let bodies = (0..5).map(body).collect();
    Net { bodies, springs: (0..4).map(|i| ([i, i + 1], elastic(40.0, 1.0))).collect() }
}

#[test]
fn groups_split_and_join_with_what_is_between_them() {
    let net = row();
    for method in without_memory() {
        let what = format!("{method:?}");
        let mut rig = net.lab(&Environment::falling(), method, H);
        rig.run(10);
        assert_eq!(groups(&rig), (1, 5), "{what}");
        rig.ask(Request::Remove(rig.bodies[2])).run(1);
        assert_eq!(groups(&rig), (2, 4), "{what}");
        // Each half is a world of its own.
        for half in [[0, 1], [3, 4]] {
            let [a, b] = half.map(|i| Start { x: rig.x(i), v: rig.v(i), w: net.bodies[i].w });
            let mut twin =
                Net::pair(a, b, elastic(40.0, 1.0)).lab(&Environment::falling(), method, H);
            let mut again = fresh(&rig, &net, &Environment::falling(), &[2], method);
            agree(
                &what,
                20,
                || twin.run(1).all_bits(&[]),
                || {
                    again.run(1);
                    half.map(|i| again.bits(i)).into()
                },
            );
        }
        rig.spring([1, 3], elastic(40.0, 1.0));
        rig.run(1);
        assert_eq!(groups(&rig), (1, 4), "{what}");
        rig.run(20);
        assert!(rig.quarantined().is_empty());
    }
}

#[test]
fn what_cannot_move_joins_nothing() {
    let mut net = pendulum(100.0);
    net.bodies.push(Start::of(2.0, DVec3::new(-1.0, 0.3, 0.2), DVec3::Z));
    net.springs.push(([2, 0], elastic(70.0, 0.8)));
    for method in Method::ALL {
        let mut rig = net.lab(&Environment::falling(), method, H);
        rig.run(1);
        assert_eq!(groups(&rig), (2, 2), "{method:?}");
        let alone = |body: usize, spring: usize| {
            let pair = Net::pair(net.bodies[0], net.bodies[body], net.springs[spring].1);
            let mut pair = pair.lab(&Environment::falling(), method, H);
            pair.run(1);
            pair
        };
        let (mut first, mut second) = (alone(1, 0), alone(2, 1));
        let mut apart = || vec![first.run(1).bits(1), second.run(1).bits(1)];
        agree(&format!("{method:?}"), 50, || rig.run(1).all_bits(&[0]), &mut apart);
    }
}

#[test]
fn groups_and_single_bodies_beside_each_other_keep_their_bits() {
    let (first, second) = (web(7), tetrahedron().moved(DVec3::X * 50.0));
    let mut dice = Dice(9);
    let free = (0..11).map(|_| Start::of(2.0, dice.vector() * 9.0, dice.vector()));
    let free = Net::free(free.collect::<Vec<_>>());
    let mut all = first.clone();
    let (second_at, free_at) = (all.and(&second), all.and(&free));
    for method in Method::ALL {
        for around in surroundings().into_iter().filter(|around| around.attraction.is_none()) {
            let mut rig = all.lab(&around, method, H);
            let mut parts = [&first, &second, &free].map(|net| net.lab(&around, method, H));
            let push = DVec3::new(5.0, -3.0, 2.0);
            let mut together = || {
                rig.push(3, push)
                    .push(second_at + 1, push)
                    .push(free_at + 4, push)
                    .run(1)
                    .all_bits(&[])
            };
            let mut apart = || {
                let each = parts.iter_mut().zip([3, 1, 4]);
                each.flat_map(|(rig, body)| rig.push(body, push).run(1).all_bits(&[])).collect()
            };
            agree(&format!("{method:?}"), 30, &mut together, &mut apart);
        }
    }
}

#[test]
fn substeps_of_a_group_are_those_of_its_first_member_and_as_good_as_ticks() {
    let net = web(8);
    for method in Method::ALL {
        let mut rig = net.lab(&Environment::falling(), method, 1.0 / 64.0);
        rig.insert(0, OwnSubsteps(4));
        let mut fine = net.lab(&Environment::falling(), method, 1.0 / 256.0);
        agree(
            &format!("{method:?}"),
            20,
            || rig.run(1).all_bits(&[]),
            || fine.run(4).all_bits(&[]),
        );
    }
}

/// A mark set after the groups were made is that of the group, or of no body.
#[test]
fn a_member_that_is_marked_before_its_first_tick_leaves_no_group_behind() {
    let net = web(10);
    for method in Method::ALL {
        for member in [0, 3] {
            let mut rig = net.lab(&Environment::falling(), Method::default(), H);
            motion::mark_method(&mut rig.world.entity_mut(rig.bodies[member]), Some(method));
            let of_group = if member == 0 { method } else { Method::default() };
            let mut twin = net.lab(&Environment::falling(), of_group, H);
            let what = format!("{method:?}, {member}");
            rig.agrees(&mut twin, 20, &[], &what);
        }
    }
}

#[test]
fn a_post_that_moves_on_carries_what_hangs_on_it() {
    let (net, speed) = (web(9), DVec3::new(2.0, -1.0, 0.5));
    let mut moving = net.clone();
    moving.bodies.iter_mut().for_each(|body| body.v += speed);
    for method in Method::ALL {
        let (mut rig, mut train) = (
            net.lab(&Environment::falling(), method, H),
            moving.lab(&Environment::falling(), method, H),
        );
        for tick in 1..=60 {
            rig.run(1);
            train.run(1);
            let by = speed * (f64::from(tick) * H);
            for body in 0..net.bodies.len() {
                let error = (train.x(body) - rig.x(body) - by).length()
                    + (train.v(body) - rig.v(body) - speed).length();
                // The rounding of the sums grows with the errors of springs that swing; conjugate gradients stop at
                // 1e-8 of a right side that is the same in the train.
                let bound = if method == Method::ImplicitEuler { 1e-7 } else { 1e-11 };
                assert!(error <= bound, "{method:?}, body {body}, tick {tick}: {error:e}");
            }
        }
    }
}
