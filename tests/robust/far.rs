//! Far from the origin: the same relative motion, to what positions are rounded to there.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{
    Damping, DampingModel, Elastic, Gravity, Method, PhysicsBody, Spring, StableId, Stepper, TimeStep,
    Transform,
};

const H: f64 = 1.0 / 128.0;

/// A net that swings on a post, and two bodies that fly by, all moved by `shift`.
fn net(method: Method, shift: DVec3) -> (World, Stepper, Vec<Entity>) {
    let mut world = World::new();
    world.insert_resource(Gravity::EARTH);
    world.insert_resource(Damping { model: DampingModel::Exact, rate: 0.5 });
    let bodies: Vec<_> = (0..6_u32)
        .map(|i| {
            let x = shift + DVec3::new(f64::from(i), 0.25 * f64::from(i % 2), -0.5);
            let body = PhysicsBody::with_mass(if i == 0 { 0.0 } else { 1.0 });
            let body = if i > 3 { body.moving_at(DVec3::new(3.0, 7.5, -1.25)) } else { body };
            world.spawn((StableId(i), Transform::at(x), body)).id()
        })
        .collect();
    let elastic = Elastic { stiffness: 20.0, damping: 2.0, rest_length: 1.0 };
    for ends in bodies[..4].windows(2) {
        world.spawn(Spring { ends: [ends[0], ends[1]], elastic });
    }
    let stepper = Stepper::new(&mut world, method, TimeStep(H));
    (world, stepper, bodies)
}

#[test]
fn ten_thousand_kilometers_from_the_origin_the_motion_is_the_same() {
    // Numbers of f64 whose sums with the start are exact, and the distance between two positions there.
    let (shift, ulp) = (DVec3::new(1e7, -1e7, 1e7), 1.9e-9);
    let ticks = 1280;
    for method in Method::ALL {
        let (mut near, mut near_stepper, bodies) = net(method, DVec3::ZERO);
        let (mut far, mut far_stepper, others) = net(method, shift);
        for _ in 0..ticks {
            near_stepper.tick(&mut near);
            far_stepper.tick(&mut far);
        }
        for (body, other) in bodies.iter().zip(&others) {
            let x = near.get::<Transform>(*body).unwrap().position;
            let y = far.get::<Transform>(*other).unwrap().position - shift;
            // Each tick rounds each coordinate by half of that at most; damped motion does not enlarge it, and adds up
            // what ten seconds of it leave.
            let bound = 2.0 * f64::from(ticks) * ulp;
            assert!(x.distance(y) <= bound, "{method:?}: {x} {y} {:e}", x.distance(y));
            let [v, u] = [(&near, body), (&far, other)]
                .map(|(world, body)| world.get::<PhysicsBody>(*body).unwrap().velocity);
            assert!(v.distance(u) <= 10.0 * bound, "{method:?}: {v} {u}");
        }
        // What nothing pulls at has the very same velocity.
        for free in [4, 5] {
            let [v, u] = [(&near, bodies[free]), (&far, others[free])]
                .map(|(world, body)| world.get::<PhysicsBody>(body).unwrap().velocity);
            assert_eq!(v, u, "{method:?}");
        }
    }
}
