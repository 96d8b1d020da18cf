//! Experiments: changes of state that a person or a script asks for, carried out between two ticks.

use bevy_ecs::prelude::*;

use crate::components::{PhysicsBody, Quarantined, Transform};
use crate::effects::{Damping, Gravity};
use crate::interpolate::PreviousPosition;
use crate::quarantine::{Cause, Quarantine, quarantine_bodies};
use crate::units::{Scalar, Vector};

/// One change that is asked for. Values may be non-finite on purpose: such a body is quarantined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// Adds an impulse `J`, N s: `v += J w`, the same at every step size.
    Impulse(Entity, Vector),
    /// Sets the velocity, m/s.
    SetVelocity(Entity, Vector),
    /// Sets the position, m.
    SetPosition(Entity, Vector),
    /// Sets the inverse mass, 1/kg, at least 0.
    SetInverseMass(Entity, Scalar),
    /// Turns every velocity round.
    ReverseVelocities,
    /// Sets the acceleration of gravity, m/s²; declares gravity, switched on, where there was none.
    SetGravity(Vector),
    /// Switches gravity on or off; does nothing where gravity was never declared.
    SwitchGravity(bool),
    /// Replaces model and rate of the scene's damping; declares it where there was none.
    SetDamping(Damping),
    /// Removes a body.
    Remove(Entity),
}

/// Requests on their way to the next tick.
#[derive(Resource, Debug, Default)]
pub struct Requests(Vec<Request>);

impl Requests {
    /// Asks for `request` at the start of the next tick.
    pub fn ask(&mut self, request: Request) {
        self.0.push(request);
    }

    /// Whether nothing is asked for.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Carries out every request, in the order in which they were asked.
pub(crate) fn carry_out(world: &mut World) {
    let requests = std::mem::take(&mut world.resource_mut::<Requests>().0);
    for request in requests {
        match request {
            Request::Impulse(body, impulse) => change(world, body, |_, body| {
                if body.inverse_mass > 0.0 {
                    body.velocity += impulse * body.inverse_mass;
                }
            }),
            Request::SetVelocity(body, velocity) => change(world, body, |_, body| body.velocity = velocity),
            Request::SetPosition(body, position) => {
                change(world, body, |at, _| at.position = position);
                // It did not travel there: nothing is drawn between.
                let now = world.get::<Transform>(body).map(|at| at.position);
                if let (Some(now), Some(mut before)) = (now, world.get_mut::<PreviousPosition>(body)) {
                    before.0 = now;
                }
            }
            Request::SetInverseMass(body, w) => change(world, body, |_, body| body.inverse_mass = w),
            Request::ReverseVelocities => {
                for mut body in
                    world.query_filtered::<&mut PhysicsBody, Without<Quarantined>>().iter_mut(world)
                {
                    body.velocity = -body.velocity;
                }
            }
            Request::SetGravity(acceleration) => {
                let on = world.get_resource::<Gravity>().is_none_or(|gravity| gravity.on);
                world.insert_resource(Gravity { acceleration, on });
            }
            Request::SwitchGravity(on) => {
                if let Some(mut gravity) = world.get_resource_mut::<Gravity>() {
                    gravity.on = on;
                }
            }
            Request::SetDamping(damping) => world.insert_resource(damping),
            Request::Remove(body) => {
                world.despawn(body);
            }
        }
    }
}

/// Changes one body, or quarantines it at its present state where the change is not finite.
fn change(world: &mut World, entity: Entity, edit: impl FnOnce(&mut Transform, &mut PhysicsBody)) {
    let Ok((mut transform, mut body)) = world
        .query_filtered::<(&mut Transform, &mut PhysicsBody), Without<Quarantined>>()
        .get_mut(world, entity)
    else {
        return;
    };
    let (old_transform, old_body) = (*transform, *body);
    let (mut new_transform, mut new_body) = (old_transform, old_body);
    edit(&mut new_transform, &mut new_body);
    let finite = new_transform.position.is_finite()
        && new_body.velocity.is_finite()
        && new_body.inverse_mass.is_finite()
        && new_body.inverse_mass >= 0.0;
    if finite {
        (*transform, *body) = (new_transform, new_body);
    } else {
        world.resource_mut::<Quarantine>().refuse(entity, old_transform, old_body, Cause::Request);
        world.run_system_cached(quarantine_bodies).expect("its resources are inserted with the step's");
    }
}
