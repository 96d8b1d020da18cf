//! What methods keep of bodies is there where it is needed, and new bodies start as if they had come first.

use bevy_ecs::prelude::*;
use motion::snapshot::{LastAcceleration, LastStep};
use motion::{Drag, Gravity, Method, PhysicsBody, Request, Static};

use super::{Environment, H, crowd, crowd_with_engines, starts, wells};
use crate::rigs::Lab;

/// Bodies that carry what position Verlet keeps, and what velocity Verlet and Yoshida's composition do.
fn kept(lab: &mut Lab) -> (Vec<Entity>, Vec<Entity>) {
    let mut steps = lab.world.query_filtered::<Entity, With<LastStep>>();
    let mut accelerations = lab.world.query_filtered::<Entity, With<LastAcceleration>>();
    (sorted(steps.iter(&lab.world).collect()), sorted(accelerations.iter(&lab.world).collect()))
}

/// The fourth body has engines.
fn scenes() -> [(Environment, fn(usize) -> bool); 4] {
    let gravity = Some(Gravity::EARTH);
    let drag = |linear, quadratic| Some(Drag::new(linear, quadratic));
    [
        (Environment::falling(), |i| i == 3),
        (Environment { gravity, wells: Some(wells()), ..Environment::default() }, |_| true),
        // Where a law depends on the velocity nothing is kept but for engines, which are asked about apart.
        (
            Environment { drag: drag(0.3, 0.0), wells: Some(wells()), ..Environment::default() },
            |i| i == 3,
        ),
        (Environment { drag: drag(0.0, 0.3), ..Environment::default() }, |i| i == 3),
    ]
}

fn sorted(mut bodies: Vec<Entity>) -> Vec<Entity> {
    bodies.sort_unstable();
    bodies
}

fn expected(
    bodies: &[Entity],
    method: Method,
    keeps: fn(usize) -> bool,
) -> (Vec<Entity>, Vec<Entity>) {
    match method {
        Method::PositionVerlet => (sorted(bodies.to_vec()), vec![]),
        Method::VelocityVerlet | Method::Yoshida4 => {
            let keeping =
                bodies.iter().enumerate().filter(|(i, _)| keeps(*i)).map(|(_, body)| *body);
            (vec![], sorted(keeping.collect()))
        }
        _ => (vec![], vec![]),
    }
}

#[test]
fn bodies_carry_what_their_method_keeps_and_no_more() {
    for (scene, keeps) in scenes() {
        for from in Method::ALL {
            for to in Method::ALL {
                let what = format!("{from:?} to {to:?} {scene:?}");
                let mut lab = crowd_with_engines(&scene, from);
                let mut bodies = lab.run(2).bodies.clone();
                // One is immovable and at rest: no step looks at it, and nothing is kept of it.
                bodies.retain(|body| lab.world.get::<Static>(*body).is_none());
                assert_eq!(kept(&mut lab), expected(&bodies, from, keeps), "{what}");
                lab.set_method(to);
                if from != to {
                    assert_eq!(kept(&mut lab), (vec![], vec![]), "{what}");
                }
                lab.run(2);
                assert_eq!(kept(&mut lab), expected(&bodies, to, keeps), "{what}");
                // And one body alone, the one with engines: the only one that keeps something in every scene.
                lab.ask(Request::SetBodyMethod(bodies[3], Some(from))).run(1);
                let others: Vec<_> =
                    bodies.iter().copied().filter(|body| *body != bodies[3]).collect();
                let (mut steps, mut accelerations) = expected(&others, to, |_| true);
                if to != Method::PositionVerlet && !keeps(0) {
                    accelerations.clear();
                }
                let (own_steps, own_accelerations) = expected(&bodies[3..4], from, |_| true);
                steps.extend(own_steps);
                accelerations.extend(own_accelerations);
                assert_eq!(
                    kept(&mut lab),
                    (sorted(steps), sorted(accelerations)),
                    "own method, {what}"
                );
            }
        }
    }
}

/// Added one at a time among old ones, so that blocks hold both.
#[test]
fn a_body_that_comes_later_moves_as_one_that_was_first() {
    const TICKS: usize = 40;
    for (scene, _) in scenes() {
        for method in Method::ALL {
            let mut first = crowd(&scene, method);
            let mut after_ticks = vec![first.all_bits(&[])];
            for _ in 0..TICKS {
                after_ticks.push(first.run(1).all_bits(&[]));
            }
            let mut lab = scene.lab(method, H);
            let mut came = Vec::new();
            for tick in 0..TICKS {
                // Alone, in pairs, in one tick after the other, and with an old one gone.
                let coming = [(0, 2), (7, 1), (8, 2), (20, 1), (21, 1), (22, 1), (30, 3)];
                let coming =
                    coming.iter().find(|(at, _)| *at == tick).map_or(0, |(_, count)| *count);
                for _ in 0..coming {
                    lab.spawn(starts()[came.len()]);
                    came.push(tick);
                }
                if tick == 25 {
                    lab.ask(Request::Remove(lab.bodies[1]));
                }
                lab.run(1);
            }
            assert_eq!(came.len(), first.bodies.len());
            for (i, came) in came.into_iter().enumerate().filter(|(i, _)| *i != 1) {
                assert_eq!(
                    lab.bits(i),
                    after_ticks[TICKS - came][i],
                    "{method:?} body {i} {scene:?}"
                );
            }
            let mut left = lab.world.query::<&PhysicsBody>();
            assert_eq!(left.iter(&lab.world).len(), first.bodies.len() - 1);
        }
    }
}
