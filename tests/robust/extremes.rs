//! Speeds, masses and distances near the ends of the numbers.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::arrays::Bare;
use motion::{
    Drag, Elastic, Gravity, Method, PhysicsBody, Quarantine, Quarantined, Spring, StableId, Stepper,
    TimeStep, Transform, totals,
};

use crate::harness::{H, Lab, close};

#[test]
fn a_body_at_1e20_m_s_flies_on_and_no_other_notices() {
    for method in Method::ALL {
        let make = |fast: bool| {
            let mut lab = Lab::new(method, H).with_gravity();
            let bodies: Vec<_> = (0..7).map(|i| lab.body(1.0, DVec3::X * f64::from(i))).collect();
            if fast {
                lab.world.get_mut::<PhysicsBody>(bodies[3]).unwrap().velocity = DVec3::new(1e20, -1e20, 0.0);
            }
            lab.run(120);
            (lab, bodies)
        };
        let ((fast, bodies), (slow, others)) = (make(true), make(false));
        assert!(fast.world.resource::<Quarantine>().records().is_empty(), "{method:?}");
        // 120 steps, each rounded a few times.
        let x = fast.x(bodies[3]).x;
        assert!((x / 1e20 - 1.0).abs() <= 500.0 * f64::EPSILON, "{method:?}: {x:e}");
        for i in [0, 1, 2, 4, 5, 6] {
            assert_eq!(
                (fast.x(bodies[i]), fast.v(bodies[i])),
                (slow.x(others[i]), slow.v(others[i])),
                "{method:?}"
            );
        }
    }
}

/// Quadratic drag at such a speed is beyond every explicit method, which throw the body out of the numbers: it is frozen
/// at the last that it had. Implicit Euler brakes it.
#[test]
fn drag_at_1e20_m_s_freezes_under_explicit_methods_and_slows_down_under_the_implicit_one() {
    for method in Method::ALL {
        let mut lab = Lab::new(method, H);
        lab.world.insert_resource(Drag::new(0.0, 0.05));
        lab.stepper.recompile(&mut lab.world);
        let body = lab.body(1.0, DVec3::splat(1e20));
        lab.run(240);
        assert!(lab.x(body).is_finite() && lab.v(body).is_finite(), "{method:?}");
        let frozen = lab.world.get::<Quarantined>(body).is_some();
        assert_eq!(frozen, method != Method::ImplicitEuler, "{method:?}");
        if !frozen {
            // 1 / (k t), and more for the first steps, each of which takes a root of the speed at most.
            close(lab.v(body).length(), 1.0 / (0.05 * 240.0 * H), 0.2);
        }
    }
}

/// A push moves each mass by `F w h`, whatever the mass, also where its reciprocal is subnormal.
#[test]
fn masses_over_seventy_six_powers_of_ten_are_pushed_alike() {
    for method in Method::ALL {
        for w in [1e-38, 1e38, 1e-310, f64::MIN_POSITIVE, 1e300] {
            let mut bare = Bare::<f64>::new(method, H).with_law(Gravity::EARTH);
            bare.add([0.0; 3], [0.0; 3], w);
            bare.push(0, [1e-3 / w.max(1e-300), 0.0, 0.0]);
            bare.tick();
            let force = 1e-3 / w.max(1e-300);
            let expected = force * w * H;
            let v = bare.bodies[0];
            assert!((v[0] - expected).abs() <= 1e-13 * expected, "{method:?} {w:e}: {v:?}");
            assert!(v[1] < 0.0 && !bare.has_failed(), "{method:?} {w:e}");
        }
        for w in [1e-38_f32, 1e38, 1e-42] {
            let mut bare = Bare::<f32>::new(method, 1.0 / 128.0).with_law(Gravity::EARTH);
            bare.add([0.0; 3], [0.0; 3], w);
            (0..128).for_each(|_| bare.tick());
            assert!(!bare.has_failed() && bare.bodies[0][1] < -9.0, "{method:?} {w:e}");
        }
    }
}

/// Springs over distances whose squares vanish or overflow.
#[test]
fn springs_over_any_distance_leave_numbers_and_momentum() {
    for method in Method::ALL {
        for (distance, single) in [(1e-23, true), (2e19, true), (1e-170, false), (2e160, false)] {
            let mut world = World::new();
            world.insert_resource(TimeStep(H));
            let bodies = [-0.5, 0.5].map(|side| {
                let x = DVec3::new(side * distance, 0.0, 0.0);
                let id = StableId(u32::from(side > 0.0));
                world.spawn((id, Transform::at(x), PhysicsBody::with_mass(1.0))).id()
            });
            let elastic = Elastic { stiffness: 10.0, damping: 0.0, rest_length: 1.0 };
            world.spawn(Spring { ends: bodies, elastic });
            let what = format!("{method:?}, {distance:e}");
            if single {
                let mut bare =
                    Bare::<f32>::of_world(&mut world, method, &|_| Vec::new(), Vec::new()).unwrap();
                (0..60).for_each(|_| bare.tick());
                assert!(bare.bodies.iter().flatten().all(|number| number.is_finite()), "{what}");
                let [a, b] = [bare.bodies[0][0], bare.bodies[1][0]];
                assert!((a + b).abs() <= 1e-5 * (a.abs() + b.abs()), "{what}: {a} {b}");
            }
            let mut stepper = Stepper::new(&mut world, method, TimeStep(H));
            (0..60).for_each(|_| stepper.tick(&mut world));
            assert!(world.resource::<Quarantine>().records().is_empty(), "{what}");
            let sum = totals(&mut world);
            let speed = world.get::<PhysicsBody>(bodies[0]).unwrap().velocity.length();
            assert!(sum.momentum.length() <= 1e-13 * speed, "{what}: {}", sum.momentum);
        }
    }
}
