//! Methods share a world, and bodies go from one to another.

use glam::DVec3;
use motion::{Drag, Gravity, Method, Request, mark_method};

use super::{Bits, Environment, H, crowd_with_engines, engines, starts, wells};
use crate::rigs::Lab;

const MANY: usize = Method::ALL.len();

fn scenes() -> [Environment; 4] {
    let gravity = Some(Gravity::EARTH);
    let drag = Some(Drag::new(0.1, 0.1));
    [
        Environment::falling(),
        Environment { substeps: Some(3), ..Environment::orbiting() },
        Environment { gravity, wells: Some(wells()), ..Environment::default() },
        Environment { gravity, drag, wells: Some(wells()), ..Environment::default() },
    ]
}

/// The bodies of one world, each of the method that `method_of` names; `None`: the world's.
fn fly(
    scene: &Environment,
    world: Method,
    method_of: impl Fn(usize) -> Option<Method>,
) -> Vec<Bits> {
    let mut lab = scene.lab(world, H);
    for (i, start) in starts().into_iter().cycle().take(3 * MANY).enumerate() {
        let body = lab.spawn(start);
        mark_method(&mut lab.world.entity_mut(body), method_of(i));
        if i % 4 == 1 {
            lab.insert(body, engines());
        }
    }
    for tick in 0..60 {
        lab.push((5 * tick) % (3 * MANY), DVec3::new(3.0, tick as f64, -1.0)).run(1);
    }
    lab.all_bits(&[])
}

#[test]
fn methods_that_share_a_world_move_as_in_worlds_of_their_own() {
    for scene in scenes() {
        let alone = Method::ALL.map(|method| fly(&scene, method, |_| None));
        for world in Method::ALL {
            let shared = fly(&scene, world, |i| {
                Some(Method::ALL[i % MANY]).filter(|method| i >= MANY || *method != world)
            });
            for (i, bits) in shared.iter().enumerate() {
                let method = Method::ALL[i % MANY];
                assert_eq!(
                    *bits,
                    alone[i % MANY][i],
                    "{method:?} in a world of {world:?} {scene:?}"
                );
            }
        }
    }
}

#[test]
fn a_body_that_changes_its_method_moves_as_in_a_world_that_does() {
    for scene in scenes() {
        for from in Method::ALL {
            let mut stays = crowd_with_engines(&scene, from);
            stays.run(60);
            for to in Method::ALL.into_iter().filter(|to| *to != from) {
                let [mut lab, mut changes] = [(); 2].map(|()| crowd_with_engines(&scene, from));
                lab.run(20);
                changes.run(20);
                for body in [2, 3] {
                    lab.ask(Request::SetBodyMethod(lab.bodies[body], Some(to)));
                }
                changes.set_method(to);
                lab.run(20);
                changes.run(20);
                for body in [2, 3] {
                    lab.ask(Request::SetBodyMethod(lab.bodies[body], None));
                }
                changes.set_method(from);
                lab.run(20);
                changes.run(20);
                for i in 0..lab.bodies.len() {
                    let of_a_world = if [2, 3].contains(&i) { &changes } else { &stays };
                    assert_eq!(
                        lab.bits(i),
                        of_a_world.bits(i),
                        "body {i}, {from:?} to {to:?} {scene:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_method_that_nobody_had_when_the_schedule_was_compiled_comes_back() {
    let mut lab = crowd_with_engines(&Environment::falling(), Method::RungeKutta4);
    let first = lab.bodies[0];
    lab.ask(Request::SetBodyMethod(first, Some(Method::Yoshida4))).run(1);
    lab.ask(Request::SetBodyMethod(first, None)).run(1);
    lab.set_method(Method::RungeKutta2Heun);
    lab.run(1).ask(Request::SetBodyMethod(first, Some(Method::Yoshida4)));
    let before = lab.x(first);
    lab.run(1);
    assert_ne!(lab.x(first), before);
}

/// Two passes would apply laws of its own to different states.
#[test]
fn engines_that_nobody_had_when_the_schedule_was_compiled_come_back() {
    for method in Method::ALL {
        let run = |came_back: bool| {
            let mut lab = Environment::falling().lab(method, H);
            let body = lab.spawn(starts()[0]);
            let prepare = |lab: &mut Lab, method: Method| {
                let first = lab.world.spawn((starts()[1].components(), engines())).id();
                lab.run(1);
                lab.world.despawn(first);
                lab.set_method(method.next());
                lab.set_method(method);
            };
            if came_back {
                prepare(&mut lab, method);
            } else {
                lab.run(1);
            }
            lab.insert(body, engines());
            lab.run(20).state(body)
        };
        let (came_back, there) = (run(true), run(false));
        // Position Verlet restarts when the method is set, which rounds.
        let error = came_back.0.distance(there.0) + came_back.1.distance(there.1);
        let bound = if method == Method::PositionVerlet { 1e-13 } else { 0.0 };
        assert!(error <= bound, "{method:?}: {error:e}");
    }
}
