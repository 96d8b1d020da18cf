//! Experiments: changes of state that a person or a script asks for, carried out between two ticks.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use crate::laws::Gravity;
use crate::laws::damping::Damping;
use crate::methods::table::Method;
use crate::schedule::effects::{Effect, switch};
use crate::schedule::restart::{end_half_steps, restart_bodies, set_body_method};
use crate::state::components::{PhysicsBody, Quarantined, Transform};
use crate::state::coupling::CouplingChanged;
use crate::state::interpolate::PreviousPosition;
use crate::state::method_state::LastStep;
use crate::state::range::{Bounds, Range};
use crate::state::rest::look_again;
use crate::tick::quarantine::{Cause, Fault, Quarantine, Refused, place, quarantine_refused};
use crate::units::{Scalar, Vector};

/// One change that is asked for. Values may be non-finite on purpose: such a body is quarantined.
///
/// `Body` is what names a body: an entity, which means something in one world, or what means the same in several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request<Body = Entity> {
    /// Adds an impulse `J`, N s: `v += J w`, the same at every step size.
    Impulse(Body, Vector),
    /// Sets the velocity, m/s.
    SetVelocity(Body, Vector),
    /// Sets the position, m.
    SetPosition(Body, Vector),
    /// Sets the inverse mass, 1/kg, at least 0.
    SetInverseMass(Body, Scalar),
    /// Turns every velocity round.
    ReverseVelocities,
    /// Sets the acceleration of gravity, m/s²; declares gravity, switched on, where there was none.
    SetGravity(Vector),
    /// Switches gravity on or off; does nothing where gravity was never declared.
    SwitchGravity(bool),
    /// Replaces model and rate of the scene's damping; declares it where there was none, switches it on where it
    /// was off.
    SetDamping(Damping),
    /// Switches an effect off, or on again; does nothing where it was never declared.
    Switch(Effect, bool),
    /// Gives a body a method of its own; `None` the world's again.
    SetBodyMethod(Body, Option<Method>),
    /// Removes a body.
    Remove(Body),
}

impl<Body> Request<Body> {
    /// The same request with the name that `renamed` gives the body; `None` where it gives none.
    pub fn rename<Other>(self, renamed: impl FnOnce(Body) -> Option<Other>) -> Option<Request<Other>> {
        Some(match self {
            Self::Impulse(body, impulse) => Request::Impulse(renamed(body)?, impulse),
            Self::SetVelocity(body, velocity) => Request::SetVelocity(renamed(body)?, velocity),
            Self::SetPosition(body, position) => Request::SetPosition(renamed(body)?, position),
            Self::SetInverseMass(body, w) => Request::SetInverseMass(renamed(body)?, w),
            Self::ReverseVelocities => Request::ReverseVelocities,
            Self::SetGravity(acceleration) => Request::SetGravity(acceleration),
            Self::SwitchGravity(on) => Request::SwitchGravity(on),
            Self::SetDamping(damping) => Request::SetDamping(damping),
            Self::Switch(effect, on) => Request::Switch(effect, on),
            Self::SetBodyMethod(body, method) => Request::SetBodyMethod(renamed(body)?, method),
            Self::Remove(body) => Request::Remove(renamed(body)?),
        })
    }
}

/// Requests on their way to the next tick.
#[derive(Resource, Debug, Default)]
pub struct Requests(Vec<Request>);

impl Requests {
    /// Asks for `request` at the start of the next tick.
    pub fn ask(&mut self, request: Request) {
        self.0.push(request);
    }

    /// What is asked for, in the order in which it was.
    pub fn pending(&self) -> impl Iterator<Item = Request> + '_ {
        self.0.iter().copied()
    }

    /// Whether nothing is asked for.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Carries out every request, in the order in which they were asked; whether effects came or went.
pub(crate) fn carry_out(world: &mut World) -> bool {
    let requests = std::mem::take(&mut world.resource_mut::<Requests>().0);
    let mut effects_changed = false;
    let mut switches = BTreeMap::new();
    let mut requests = requests.into_iter().peekable();
    while let Some(request) = requests.next() {
        if matches!(request, Request::SetGravity(_) | Request::SwitchGravity(_) | Request::SetDamping(_)) {
            end_half_steps(world);
        }
        effects_changed |= matches!(request, Request::Switch(..) | Request::SetDamping(_));
        match request {
            Request::Impulse(body, impulse) => change(world, body, |_, body| {
                if body.inverse_mass > 0.0 {
                    body.velocity += impulse * body.inverse_mass;
                }
            }),
            Request::SetVelocity(body, velocity) => {
                change(world, body, |_, body| body.velocity = velocity);
                // Position Verlet starts anew: this is the velocity now, not that of half a step ago.
                if let Some(mut last) = world.get_mut::<LastStep>(body) {
                    last.0 = 0.0;
                }
                look_again(world, body);
            }
            Request::SetPosition(body, position) => {
                displace(world, body, |at, _| at.position = position);
                // It did not travel there: nothing is drawn between.
                let now = world.get::<Transform>(body).map(|at| at.position);
                if let (Some(now), Some(mut before)) = (now, world.get_mut::<PreviousPosition>(body)) {
                    before.0 = now;
                }
            }
            Request::SetInverseMass(body, w) => {
                displace(world, body, |_, body| body.inverse_mass = w);
                CouplingChanged::set(world);
                look_again(world, body);
            }
            Request::ReverseVelocities => {
                let mut bodies =
                    world.query_filtered::<(&mut PhysicsBody, Option<&mut LastStep>), Without<Quarantined>>();
                for (mut body, last) in bodies.iter_mut(world) {
                    // Not "-velocity": at rest nothing turns round, not even the sign of 0.
                    body.velocity = Vector::ZERO - body.velocity;
                    if let Some(mut last) = last {
                        last.0 = -last.0;
                    }
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
            Request::SetDamping(damping) => {
                // One that was never declared has nothing to switch on.
                let _ = switch(world, Effect::Damping, true);
                world.insert_resource(damping);
            }
            Request::Switch(effect, on) => {
                // Several in a row are one: off and on again is nothing at all.
                switches.insert(effect, on);
                if !matches!(requests.peek(), Some(Request::Switch(..))) {
                    for (effect, on) in std::mem::take(&mut switches) {
                        let _ = switch(world, effect, on);
                    }
                }
            }
            Request::SetBodyMethod(body, method) => set_body_method(world, body, method),
            Request::Remove(body) => {
                world.despawn(body);
            }
        }
    }
    effects_changed
}

/// Place and what moves of a body.
type State = (Transform, PhysicsBody);

/// A body as it is and as it is asked to be, with what is wrong with that; `None` if it is frozen or gone.
type Change = (State, Result<State, (&'static str, Fault)>);

fn proposed(
    world: &World,
    entity: Entity,
    edit: impl FnOnce(&mut Transform, &mut PhysicsBody),
) -> Option<Change> {
    let body = world.get_entity(entity).ok().filter(|body| !body.contains::<Quarantined>())?;
    let old = (*body.get::<Transform>()?, *body.get::<PhysicsBody>()?);
    let mut new = old;
    edit(&mut new.0, &mut new.1);
    let fault = fault_of(&old, &new, world.get_resource::<Range>());
    Some((old, fault.map_or(Ok(new), Err)))
}

/// Changes one body, or quarantines it at its present state where the change is not finite or out of range.
fn change(world: &mut World, entity: Entity, edit: impl FnOnce(&mut Transform, &mut PhysicsBody)) {
    let Some(((transform, state), new)) = proposed(world, entity, edit) else { return };
    match new {
        Ok((transform, state)) => {
            let mut both = world.query::<(&mut Transform, &mut PhysicsBody)>();
            if let Ok((mut old_transform, mut old_state)) = both.get_mut(world, entity) {
                (*old_transform, *old_state) = (transform, state);
            }
        }
        Err((component, fault)) => {
            let cause = Cause { system: Cause::REQUESTS, component, fault };
            let refused = Refused { body: entity, transform, state, cause };
            world.resource_mut::<Quarantine>().refuse(refused);
            quarantine_refused(world);
        }
    }
}

/// Gives one body another place or mass: position Verlet starts anew with its group, because its next kick would be one
/// of the new place or mass for the last step as well. What is refused is noticed by no other body.
fn displace(world: &mut World, entity: Entity, edit: impl Fn(&mut Transform, &mut PhysicsBody)) {
    if proposed(world, entity, &edit).is_some_and(|(_, new)| new.is_ok()) {
        restart_bodies(world, &[entity]);
    }
    change(world, entity, edit);
}

/// What is wrong with what a request makes another one of a state.
fn fault_of(old: &State, new: &State, range: Option<&Range>) -> Option<(&'static str, Fault)> {
    let changed =
        |old: Vector, new: Vector| old.to_array().map(f64::to_bits) != new.to_array().map(f64::to_bits);
    let (x, v, w) = (new.0.position, new.1.velocity, new.1.inverse_mass);
    let moved = changed(old.0.position, x);
    let kicked = changed(old.1.velocity, v);
    let bounds = Bounds::<Scalar>::of(range);
    let Range { position, speed } = range.copied().unwrap_or_default();
    if moved && !x.is_finite() {
        Some((place::POSITION, Fault::Request))
    } else if kicked && !v.is_finite() {
        Some((place::VELOCITY, Fault::Request))
    } else if w.to_bits() != old.1.inverse_mass.to_bits() && !(w.is_finite() && w >= 0.0) {
        Some((place::INVERSE_MASS, Fault::Request))
    } else if moved && !bounds.holds_position(&x.to_array()) {
        Some((place::POSITION, Fault::Range(position)))
    } else if kicked && !bounds.holds_velocity(&v.to_array()) {
        Some((place::VELOCITY, Fault::Range(speed)))
    } else {
        None
    }
}
