//! Requests under the methods that keep something, position Verlet first: its velocity is half a step behind.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Damping, DampingModel, Gravity, Method, OwnLaws, Request};

use super::{Environment, H, Start, engine, engines};
use crate::methods::pushes::uniform_step;
use crate::rigs::Lab;

const START: Start = Start { x: DVec3::new(1.5, 0.2, -0.3), v: DVec3::new(0.3, 1.1, 0.4), w: 0.5 };

fn lab_of(scene: &Environment, method: Method, step: f64) -> Lab {
    let mut lab = scene.lab(method, step);
    lab.spawn(START);
    lab
}

/// The same with engines, after 50 ticks.
fn engined(scene: &Environment, method: Method) -> Lab {
    let mut lab = lab_of(scene, method, H);
    lab.insert(0, engines());
    lab.run(50);
    lab
}

/// The same, its velocity that of the time of its position: what a switch of the method leaves.
fn restarted(scene: &Environment, method: Method) -> Lab {
    let mut lab = engined(scene, method);
    lab.set_method(method.next());
    lab.set_method(method);
    lab
}

#[test]
fn an_impulse_is_what_it_is_at_every_step() {
    let impulse = DVec3::new(3.0, -1.0, 0.25);
    for method in Method::ALL {
        for scene in [Environment::default(), Environment::falling(), Environment::orbiting()] {
            for step in [H, H / 7.0] {
                let mut lab = lab_of(&scene, method, step);
                lab.run(30);
                let (x, v) = lab.state(0);
                lab.have(Request::Impulse(lab.bodies[0], impulse));
                assert_eq!(lab.state(0), (x, v + impulse * 0.5), "{method:?} {scene:?}");
            }
        }
        // Where nothing else acts the way that is gone for it is J w t.
        let mut struck = lab_of(&Environment::default(), method, H);
        let mut free = lab_of(&Environment::default(), method, H);
        struck.run(30);
        struck.have(Request::Impulse(struck.bodies[0], impulse));
        struck.run(60);
        free.run(90);
        let error = (struck.x(0) - free.x(0)).distance(impulse * 0.5);
        assert!(error <= 180.0 * f64::EPSILON * 4.0, "{method:?}: {error:e}");
    }
}

/// The body continues as one that starts in the state that the request leaves.
#[test]
fn a_velocity_that_is_set_is_a_start() {
    for method in Method::ALL {
        for scene in [
            Environment::falling(),
            Environment::orbiting(),
            Environment { substeps: Some(3), ..Environment::orbiting() },
        ] {
            for own in [false, true] {
                let mut lab = lab_of(&scene, method, H);
                let mut fresh = scene.lab(method, H);
                if own {
                    lab.insert(0, engines());
                }
                lab.run(50);
                lab.have(Request::SetVelocity(lab.bodies[0], DVec3::new(-0.5, 0.25, 1.0)));
                fresh.world.insert_resource(*lab.world.resource::<motion::clock::StepClock>());
                fresh.spawn(Start { x: lab.x(0), v: lab.v(0), w: START.w });
                if own {
                    fresh.insert(0, engines());
                }
                for tick in 0..50 {
                    let (bits, of_fresh) = (lab.run(1).bits(0), fresh.run(1).bits(0));
                    assert_eq!(bits, of_fresh, "{method:?} {own} tick {tick} {scene:?}");
                }
            }
        }
    }
}

/// Half of the last step's kick must not become one of the new acceleration.
#[test]
fn what_changes_the_acceleration_is_a_start_with_the_velocity_of_the_time() {
    let requests: [(&str, fn(Entity) -> Request); 2] = [
        ("position", |body| Request::SetPosition(body, DVec3::new(-3.0, 0.5, 2.0))),
        ("inverse mass", |body| Request::SetInverseMass(body, 4.0)),
    ];
    for method in Method::ALL {
        for scene in [Environment::falling(), Environment::orbiting()] {
            for (name, request) in requests {
                let (mut lab, mut twin) = (engined(&scene, method), restarted(&scene, method));
                lab.ask(request(lab.bodies[0]));
                twin.ask(request(twin.bodies[0]));
                for tick in 0..50 {
                    let (bits, of_twin) = (lab.run(1).bits(0), twin.run(1).bits(0));
                    assert_eq!(bits, of_twin, "{method:?} {name} tick {tick} {scene:?}");
                }
            }
        }
    }
}

/// Position Verlet cannot know: the old engines are gone when it is their turn, and the new ones take over half of the
/// last step's kick.
#[test]
fn new_engines_do_not_act_before_they_are_there() {
    for method in Method::ALL {
        let [lab, twin] = [engined, restarted].map(|make| {
            let mut lab = make(&Environment::falling(), method);
            lab.insert(0, OwnLaws::new(vec![Box::new(engine()), Box::new(engine())]));
            lab.run(1);
            lab
        });
        if method == Method::PositionVerlet {
            // The same engine once more: what came with it at the end of the last step.
            let t = 50.0 * H;
            let newtons = DVec3::new(4.0, -2.0, 1.0) + DVec3::new(-1.0, 3.0, 0.5) * t;
            let error = (lab.v(0) - twin.v(0)).distance(newtons * (0.5 * H / 2.0));
            assert!(error <= 1e-14, "{error:e}");
        } else {
            assert_eq!(lab.bits(0), twin.bits(0), "{method:?}");
        }
    }
}

#[test]
fn velocities_turned_round_lead_back() {
    for method in Method::ALL.into_iter().filter(|method| method.claims().reversible) {
        for scene in [
            Environment::orbiting(),
            Environment { substeps: Some(3), ..Environment::orbiting() },
            Environment::falling(),
        ] {
            for own in [false, true] {
                let mut lab = lab_of(&scene, method, H);
                if own {
                    motion::mark_method(&mut lab.world.entity_mut(lab.bodies[0]), Some(method));
                    lab.set_method(Method::ExplicitEuler);
                }
                lab.run(500).ask(Request::ReverseVelocities).run(500);
                let error = lab.x(0).distance(START.x) / START.x.length();
                assert!(error <= 1e-12, "{method:?} {own}: {error:e} {scene:?}");
                // At the time of the position, also under position Verlet.
                lab.have(Request::SetBodyMethod(lab.bodies[0], Some(method.next())));
                let error = lab.v(0).distance(-START.v) / START.v.length();
                assert!(error <= 1e-12, "{method:?} {own}: velocity {error:e} {scene:?}");
            }
        }
    }
}

fn gravity_of(tick: usize) -> Option<DVec3> {
    match tick {
        0..37 => Some(Gravity::EARTH.acceleration),
        37..91 => None,
        91..120 => Some(Gravity::EARTH.acceleration),
        _ => Some(DVec3::new(2.0, 5.0, -1.0)),
    }
}

#[test]
fn gravity_that_is_switched_is_a_parabola_in_pieces() {
    for method in Method::ALL {
        let mut lab = lab_of(&Environment::falling(), method, H);
        let Start { mut x, mut v, .. } = START;
        for tick in 0..150 {
            match tick {
                37 => lab.ask(Request::SwitchGravity(false)),
                91 => lab.ask(Request::SwitchGravity(true)),
                120 => lab.ask(Request::SetGravity(DVec3::new(2.0, 5.0, -1.0))),
                _ => &mut lab,
            }
            .run(1);
            let a = gravity_of(tick).unwrap_or(DVec3::ZERO);
            (x, v) = uniform_step(method, x, v, a);
            // Two additions a tick on either side, and stages of up to twice the step.
            let bound = 8.0 * (tick + 1) as f64 * f64::EPSILON * (x.length() + v.length() + 10.0);
            let error = lab.x(0).distance(x);
            assert!(error <= bound, "{method:?} tick {tick}: {error:e}, at most {bound:e}");
            let behind = if method == Method::PositionVerlet { a * (H / 2.0) } else { DVec3::ZERO };
            let error = lab.v(0).distance(v - behind);
            assert!(
                error <= bound,
                "{method:?} tick {tick}: velocity {error:e}, at most {bound:e}"
            );
        }
    }
}

/// The exact solution in pieces, with the method's order.
#[test]
fn damping_that_is_set_acts_from_then_on() {
    let g = Gravity::EARTH.acceleration;
    let rates = [0.0, 2.0, 0.5];
    let (mut x, mut v) = (START.x, START.v);
    for rate in rates {
        (x, v) = if rate == 0.0 {
            (x + v * 0.5 + g * 0.125, v + g * 0.5)
        } else {
            let (terminal, gone) = (g / rate, -f64::exp_m1(-rate * 0.5));
            (x + terminal * 0.5 + (v - terminal) * (gone / rate), v - (v - terminal) * gone)
        };
    }
    for method in Method::ALL {
        let error = |steps: u32| {
            let mut lab = lab_of(&Environment::falling(), method, 1.0 / f64::from(steps));
            for rate in rates {
                lab.ask(Request::SetDamping(Damping { model: DampingModel::Exact, rate }));
                lab.run(u64::from(steps / 2));
            }
            lab.have(Request::SetDamping(Damping { model: DampingModel::Exact, rate: 0.0 }));
            [lab.x(0).distance(x), lab.v(0).distance(v)]
        };
        let claimed = f64::from(method.claims().order_with_velocity_laws);
        let steps = if claimed > 2.0 { 32 } else { 512 };
        let (coarse, fine) = (error(steps), error(2 * steps));
        // The Eulers of the tutorial have the exact decay in them.
        let order = (coarse[0] / fine[0]).log2();
        assert!(
            order >= claimed - 0.1 && fine[0] <= 0.1,
            "{method:?}: order {order:.3}, {:e}",
            fine[0]
        );
        assert!(fine[1] <= 0.1, "{method:?}: velocity {:e}", fine[1]);
    }
}
