//! What decays ends at zero, not in subnormal numbers, which run many times slower.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::arrays::Bare;
use motion::real::Real;
use motion::{
    Damping, DampingModel, DampingRate, Drag, Elastic, Method, PhysicsBody, SpeedLimit, Spring, StableId,
    Stepper, TimeStep, Transform,
};

/// 2,000 s in ticks of 1/30 s.
const TICKS: u32 = 60_000;
const STEP: f64 = 1.0 / 30.0;

/// What slows bodies down.
#[derive(Clone, Copy, Debug)]
enum Brake {
    Model(DampingModel),
    /// As a law that is summed up before a tick, and as one that is called.
    Drag(f64, f64),
}

fn brakes() -> impl Iterator<Item = Brake> {
    let models = DampingModel::ALL.into_iter().map(Brake::Model);
    models.chain([Brake::Drag(0.4, 0.0), Brake::Drag(0.4, 1e-3)])
}

/// A few bodies that slow down for 2,000 s; some start below what single precision keeps.
fn slowed<T: Real>(method: Method, brake: Brake, tick: fn(&mut Bare<T>)) -> Bare<T> {
    let mut bare = Bare::<T>::new(method, T::of(STEP));
    bare = match brake {
        Brake::Model(model) => bare.with_damping(Damping { model, rate: 0.4 }),
        Brake::Drag(linear, quadratic) => bare.with_law(Drag::new(linear, quadratic)),
    };
    for i in 0..5 {
        let speed = [1.0, -20.0, 1e-3, 1e-29, 1e-33][i];
        bare.add(
            [T::ZERO; 3],
            [T::of(speed), T::of(-0.3 * speed), T::of(1e-34)],
            T::of([1.0, 10.0, 0.0][i % 3]),
        );
    }
    (0..TICKS).for_each(|_| tick(&mut bare));
    bare
}

fn has_none<T: Real>(method: Method, tick: fn(&mut Bare<T>), is_subnormal: fn(T) -> bool) {
    for brake in brakes() {
        let bare = slowed(method, brake, tick);
        let what = format!("{method:?}, {brake:?}");
        assert!(!bare.has_failed(), "{what}");
        for (row, (x, body)) in bare.positions.iter().zip(&bare.bodies).enumerate() {
            assert!(!x.iter().chain(body).any(|number| is_subnormal(*number)), "{what}: {x:?} {body:?}");
            // Nothing ever slows an immovable body but the multipliers.
            let rests = body[..3] == [T::ZERO; 3];
            assert!(rests || row == 2, "{what}: row {row} still moves at {:?}", &body[..3]);
        }
    }
}

#[test]
fn no_state_is_subnormal_after_2000_s_of_damping_in_any_method() {
    for method in Method::ALL {
        has_none(method, Bare::<f64>::tick, f64::is_subnormal);
        has_none(method, Bare::<f32>::tick, f32::is_subnormal);
    }
}

/// A chain that comes to rest on a post, with members that ask for something.
fn chain(model: DampingModel) -> World {
    let mut world = World::new();
    world.insert_resource(TimeStep(1.0 / 20.0));
    world.insert_resource(Damping { model, rate: 2.0 });
    let bodies: Vec<_> = (0..4)
        .map(|i| {
            let x = DVec3::new(1.1 * f64::from(i), 0.0, 0.0);
            let body = PhysicsBody::with_mass(if i == 0 { 0.0 } else { 1.0 });
            world.spawn((StableId(i), Transform::at(x), body)).id()
        })
        .collect();
    let elastic = Elastic { stiffness: 4.0, damping: 0.5, rest_length: 1.0 };
    for ends in bodies.windows(2) {
        world.spawn(Spring { ends: [ends[0], ends[1]], elastic });
    }
    world.entity_mut(bodies[2]).insert((DampingRate::new(3.0), SpeedLimit(5.0)));
    world
}

#[test]
fn no_state_of_a_group_is_subnormal_after_2000_s_of_damping() {
    for method in Method::ALL {
        for model in DampingModel::ALL {
            let mut world = chain(model);
            let mut single = Bare::<f32>::of_world(&mut world, method, &|_| Vec::new(), Vec::new()).unwrap();
            let mut stepper = Stepper::new(&mut world, method, TimeStep(1.0 / 20.0));
            for _ in 0..40_000 {
                stepper.tick(&mut world);
            }
            let mut bodies = world.query::<(&Transform, &PhysicsBody)>();
            for (at, body) in bodies.iter(&world) {
                let numbers = at.position.to_array().into_iter().chain(body.velocity.to_array());
                let what = format!("{method:?}, {model:?}: {at:?} {body:?}");
                assert!(!numbers.into_iter().any(f64::is_subnormal), "{what}");
                assert!(body.velocity.length() < 1e-12, "{what}");
            }
            (0..4_000).for_each(|_| single.tick());
            let numbers = single.positions.iter().flatten().chain(single.bodies.iter().flatten());
            assert!(
                !single.has_failed() && !numbers.copied().any(f32::is_subnormal),
                "{method:?}, {model:?}"
            );
        }
    }
}
