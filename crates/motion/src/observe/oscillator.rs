//! A body as an oscillator: how stiffly springs and laws hold it, and how they damp it.

use bevy_ecs::prelude::*;

use super::margin::restoring_rate;
use crate::groups::{LinearGroup, Terms, coming_couplings, couplings};
use crate::laws::{BodyState, EvaluationTime};
use crate::methods::markers::own_method;
use crate::methods::table::Method;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{PhysicsBody, Transform};
use crate::tick::columns::options_of;
use crate::tick::environment::Environment;
use crate::units::Scalar;

/// A body as an oscillator in its present state. Each spring counts with all springs of both of its ends, which swing against
/// each other, so that no motion of the body alone, of a pair or of a chain of equal links is faster.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct BodyOscillator {
    /// Method of the body.
    pub method: Method,
    /// Length of its steps, s.
    pub step: Scalar,
    /// Squared frequency, 1/s².
    pub stiffness: Scalar,
    /// Rate of damping, 1/s, without damping that a method applies beside its steps.
    pub rate: Scalar,
}

impl BodyOscillator {
    /// The oscillator of `body`, where `method` is that of bodies without their own; `None` if it has no physics.
    #[must_use]
    pub fn of(world: &World, body: Entity, method: Method) -> Option<Self> {
        let entity = world.get_entity(body).ok()?;
        let PhysicsBody { velocity, inverse_mass } = *entity.get()?;
        let state =
            BodyState { position: entity.get::<Transform>()?.position, velocity, inverse_mass };
        let method = own_method(entity).unwrap_or(method);
        let clock = world.get_resource::<StepClock>().copied().unwrap_or_default();
        let tick = world.get_resource::<TimeStep>()?.0;
        let environment = Environment::of(world, clock, tick);
        let options = options_of(entity);
        let step = tick / Scalar::from(options.substeps.unwrap_or(environment.times.substeps));
        let [mut stiffness, mut rate] = [0.0; 2];
        let time = clock.scene_seconds();
        for law in environment.on_body(&options, false) {
            let slopes = law.jacobians(EvaluationTime { time, within_step: time }, state);
            stiffness += restoring_rate(slopes.position).max(0.0);
            rate += restoring_rate(slopes.velocity).max(0.0);
        }
        let damping =
            options.damping(environment.damping).filter(|_| !method.traits().damps_inside);
        rate += damping.map_or(0.0, |damping| damping.factors_around_tick(tick).1);
        let coming = coming_couplings(world);
        let mut springs = Terms::default();
        for (coupling, members) in couplings(world, coming.as_deref()) {
            if members.contains(&body) {
                let group = LinearGroup::of(world, coupling, members);
                let bounds = group.ends().zip(group.bounds());
                bounds
                    .filter(|(ends, _)| ends.iter().any(|end| members[*end] == body))
                    .for_each(|(_, bound)| springs = springs.larger(bound));
            }
        }
        let (stiffness, rate) = (stiffness + springs.stiffness, rate + springs.damping);
        Some(Self { method, step, stiffness, rate })
    }
}
