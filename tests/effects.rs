//! Effects on demand: what is off, or was never declared, is not there.

pub mod allocations;
mod births;
mod emitters;
mod reports;
mod riding;
mod statics;
mod switching;

use bevy_ecs::prelude::*;
use motion::effects::Effect;
use motion::units::Vector;
use motion::{
    AxisLocks, Curve, Damping, DampingModel, DampingRate, Dormant, Drag, Elastic, Emitter, Gravity,
    Law, Method, MutualGravity, OwnLaws, PhysicsBody, SpeedLimit, Spring, StableId, Thrust,
    Transform, Well, Wells, Wind,
};

use crate::rigs::{H, Lab};

/// Effects that act on single bodies, so that this crate can declare them without springs or pairs.
const LOCAL: [Effect; 9] = [
    Effect::Gravity,
    Effect::Damping,
    Effect::Drag,
    Effect::Wind,
    Effect::Wells,
    Effect::Thrusts,
    Effect::SpeedLimits,
    Effect::AxisLocks,
    Effect::Emitters,
];

/// Effects that act between bodies.
const COUPLED: [Effect; 2] = [Effect::Springs, Effect::MutualGravity];

#[test]
fn every_effect_is_tested() {
    let tested: std::collections::BTreeSet<_> =
        LOCAL.iter().chain(&COUPLED).map(Effect::to_string).collect();
    assert_eq!(tested, Effect::ALL.iter().map(Effect::to_string).collect());
}

fn wells() -> Wells {
    Wells(vec![Well { position: Vector::new(3.0, 0.0, 1.0), strength: 2.0, softening: 0.5 }])
}

fn thrust(until: f64) -> Thrust {
    Thrust::new(
        Curve::Polynomial(vec![Vector::new(0.3, 0.0, 0.7), Vector::new(0.1, -0.2, 0.0)]),
        0.05,
        until,
    )
}

/// Bodies under the `declared` effects. Wind needs drag.
fn world_of(declared: &[Effect]) -> World {
    let mut world = World::new();
    let has = |effect| declared.contains(&effect);
    let bodies: Vec<_> = (0..7_u32)
        .map(|id| {
            let k = f64::from(id);
            let state = PhysicsBody::with_mass(1.0 + 0.3 * k).moving_at(Vector::new(
                1.0 - 0.4 * k,
                0.2 * k,
                0.5,
            ));
            world
                .spawn((StableId(id), Transform::at(Vector::new(k, 0.1 * k * k, -0.3 * k)), state))
                .id()
        })
        .collect();
    if has(Effect::Gravity) {
        world.insert_resource(Gravity::EARTH);
    }
    if has(Effect::Springs) {
        let elastic = Elastic::new(30.0, 1.1).damped(0.2);
        for ends in [[0, 1], [1, 2], [3, 4]] {
            world.spawn(Spring { ends: ends.map(|end: usize| bodies[end]), elastic });
        }
    }
    if has(Effect::MutualGravity) {
        world.insert_resource(MutualGravity { constant: 0.5, softening: 0.1 });
    }
    if has(Effect::Damping) {
        world.insert_resource(Damping { model: DampingModel::Exact, rate: 0.3 });
        world.entity_mut(bodies[5]).insert(DampingRate::new(1.5));
    }
    if has(Effect::Drag) {
        let wind = Wind { velocity: Vector::new(2.0, 0.0, 1.0), gust: 0.5, gust_hz: 3.0 };
        world.insert_resource(Drag {
            linear: 0.1,
            quadratic: 0.02,
            wind: has(Effect::Wind).then_some(wind),
        });
    }
    if has(Effect::Wells) {
        world.insert_resource(wells());
    }
    let mut own: Vec<Box<dyn Law>> = Vec::new();
    if has(Effect::Wells) {
        own.push(Box::new(wells()));
    }
    if has(Effect::Thrusts) {
        own.push(Box::new(thrust(0.2)));
    }
    if has(Effect::Wells) {
        own.push(Box::new(Wells(vec![Well {
            position: Vector::Y,
            strength: -0.7,
            softening: 0.3,
        }])));
    }
    if !own.is_empty() {
        world.entity_mut(bodies[1]).insert(OwnLaws::new(own));
    }
    if has(Effect::Thrusts) {
        world.entity_mut(bodies[2]).insert(OwnLaws::new(vec![Box::new(thrust(f64::INFINITY))]));
    }
    if has(Effect::SpeedLimits) {
        world.entity_mut(bodies[3]).insert(SpeedLimit(1.1));
    }
    if has(Effect::AxisLocks) {
        world.entity_mut(bodies[4]).insert(AxisLocks { y: true, ..AxisLocks::default() });
    }
    // The pool is there in any case: a scene without its emitter has bodies that are never born.
    let pool: Vec<_> = (7..12_u32)
        .map(|id| {
            let body = (StableId(id), Transform::default(), PhysicsBody::with_mass(0.5), Dormant);
            world.spawn(body).id()
        })
        .collect();
    if has(Effect::Emitters) {
        let launches = (0..5).map(|k| Vector::new(f64::from(k), 5.0, 1.0)).collect();
        let (rate, life, position) = (25.0, 0.15, Vector::new(0.0, 1.0, 0.0));
        world.spawn(Emitter { rate, life, position, pool, launches, inverse_mass: 2.0 });
    }
    world
}

fn lab_of(declared: &[Effect], method: Method) -> Lab {
    Lab::of(world_of(declared), method, H)
}
