//! Axis locks and speed limits, whatever the method.

use glam::DVec3;
use motion::{
    AxisLocks, Damping, DampingModel, Drag, Gravity, Method, PhysicsBody, SpeedLimit, StableId,
    Transform,
};

use super::{Environment, H, crowd_with_engines, pushes, starts, wells};
use crate::rigs::{Lab, elastic};

const TICKS: usize = 100;

fn scenes() -> Vec<Environment> {
    let gravity = Some(Gravity::EARTH);
    let damping = |model| Some(Damping { model, rate: 0.4 });
    let drag = Some(Drag::new(0.1, 0.1));
    let mut scenes = vec![
        Environment::falling(),
        Environment { gravity, wells: Some(wells()), ..Environment::default() },
        Environment { drag, substeps: Some(3), ..Environment::orbiting() },
    ];
    scenes.extend(
        DampingModel::ALL
            .map(|model| Environment { damping: damping(model), ..Environment::falling() }),
    );
    scenes
}

#[test]
fn nothing_moves_along_a_locked_axis() {
    for method in Method::ALL {
        for scene in scenes() {
            for lock in 1..8_u8 {
                let locks = AxisLocks { x: lock & 1 != 0, y: lock & 2 != 0, z: lock & 4 != 0 };
                let locked = [locks.x, locks.y, locks.z];
                let mut lab = crowd_with_engines(&scene, method);
                for body in 0..lab.bodies.len() {
                    lab.insert(body, locks);
                    if body % 2 == 1 {
                        lab.insert(body, SpeedLimit(1.5));
                    }
                }
                let pushes = pushes(u64::from(lock), TICKS, lab.bodies.len());
                for (tick, pushes) in pushes.into_iter().enumerate() {
                    for (body, newtons) in pushes {
                        lab.push(body, newtons);
                    }
                    lab.run(1);
                    for ((x, v), start) in lab.states().into_iter().zip(starts()) {
                        for axis in (0..3).filter(|axis| locked[*axis]) {
                            let held =
                                x[axis].to_bits() == start.x[axis].to_bits() && v[axis] == 0.0;
                            assert!(held, "{method:?} {locks:?} axis {axis} tick {tick} {scene:?}");
                        }
                    }
                }
                if lock < 7 {
                    let moved = lab.x(0).distance(starts()[0].x);
                    assert!(moved > 0.01, "{method:?} {locks:?} {scene:?}");
                }
            }
        }
    }
}

#[test]
fn a_speed_limit_holds_at_the_end_of_every_tick() {
    const LIMIT: f64 = 1.25;
    for method in Method::ALL {
        for scene in scenes() {
            let mut lab = crowd_with_engines(&scene, method);
            for body in 0..lab.bodies.len() {
                lab.insert(body, SpeedLimit(LIMIT));
            }
            let pushes = pushes(1, TICKS, lab.bodies.len());
            let mut fastest = 0.0_f64;
            for (tick, pushes) in pushes.into_iter().enumerate() {
                for (body, newtons) in pushes {
                    lab.push(body, newtons * 100.0);
                }
                let before = lab.states();
                for ((x, v), (before, _)) in lab.run(1).states().into_iter().zip(before) {
                    // Explicit Euler accelerates after the move that was limited.
                    let speed = match method {
                        Method::ExplicitEuler => x.distance(before) / H,
                        _ => v.length(),
                    };
                    fastest = fastest.max(speed);
                    assert!(
                        speed <= LIMIT * (1.0 + 1e-12),
                        "{method:?} tick {tick}: {speed} {scene:?}"
                    );
                }
            }
            assert!(fastest >= LIMIT * 0.99, "{method:?}: {fastest} {scene:?}");
        }
    }
}

/// PhysX's order: what gravity adds along a locked axis counts towards the speed, and is dropped after the limit.
#[test]
fn semi_implicit_euler_limits_the_speed_before_it_locks_an_axis() {
    const TICK: f64 = 0.1;
    const RATE: f64 = 0.4;
    let method = Method::SemiImplicitEuler;
    // Two systems, one pass, a group.
    for others in ["none", "many", "a spring"] {
        for model in [
            None,
            Some(DampingModel::Tutorial),
            Some(DampingModel::Clamped),
            Some(DampingModel::Exact),
        ] {
            let mut lab = Lab::new(method, TICK).with_gravity();
            let start =
                (Transform::default(), PhysicsBody { velocity: DVec3::X, inverse_mass: 0.5 });
            let locks = AxisLocks { y: true, ..AxisLocks::default() };
            let body = lab.world.spawn((StableId(0), start, SpeedLimit(1.0), locks)).id();
            let more = if others == "many" { 300 } else { 1 };
            for id in 0..more {
                lab.world.spawn((
                    StableId(id + 1),
                    Transform::default(),
                    PhysicsBody::with_mass(1.0),
                ));
            }
            if others == "a spring" {
                let other = lab.body(1.0, DVec3::ZERO);
                lab.spring([body, other], elastic(0.0, 0.0));
            }
            if let Some(model) = model {
                lab.world.insert_resource(Damping { model, rate: RATE });
            }
            lab.recompile();
            lab.run(1);
            let q = RATE * TICK;
            let (along, fallen) = match model {
                Some(DampingModel::Exact) => ((-q).exp(), 0.98 * -(-q).exp_m1() / q),
                Some(DampingModel::Clamped) => (1.0 - q, 0.98 * (1.0 - q)),
                _ => (1.0, 0.98),
            };
            let moved = TICK * along / f64::hypot(along, fallen);
            let at = lab.x(body);
            assert!((at - DVec3::X * moved).length() < 1e-15, "{others} {model:?}: {at:?}");
        }
    }
}
