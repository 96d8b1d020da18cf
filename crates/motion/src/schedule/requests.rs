//! Requests: changes of the state of a world, carried out between two ticks.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;

use crate::laws::damping::Damping;
use crate::laws::{Gravity, PrescribedMotion};
use crate::methods::table::Method;
use crate::schedule::backend::ParticleBackend;
use crate::schedule::effects::{Effect, switch};
use crate::schedule::restart::{end_half_steps, restart_bodies, set_body_method};
use crate::state::components::{PhysicsBody, Quarantined, Transform};
use crate::state::coupling::CouplingChanged;
use crate::state::method_state::LastStep;
use crate::state::previous_position::PreviousPosition;
use crate::state::range::{Bounds, Range};
use crate::state::static_bodies::update_static_mark;
use crate::tick::quarantine::{Cause, Fault, Quarantine, Refused, place, quarantine_refused};
use crate::units::{Scalar, Vector};

/// A request to change the state of a world between two ticks. Restarts methods where it has to. A body whose state would
/// not be finite, or out of [`Range`], is quarantined instead.
///
/// `Body` names a body: an entity, or a name that is the same in several worlds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum Request<Body = Entity> {
    /// Adds an impulse `J`, N s: `v += J w`, the same at every step size.
    Impulse(Body, Vector),
    /// Sets the velocity, m/s; not that of a body that follows a [`PrescribedMotion`].
    SetVelocity(Body, Vector),
    /// Sets the position, m; not that of a body that follows a [`PrescribedMotion`].
    SetPosition(Body, Vector),
    /// Sets the inverse mass, 1/kg, at least 0.
    SetInverseMass(Body, Scalar),
    /// Reverses every velocity that is not [prescribed](PrescribedMotion).
    ReverseVelocities,
    /// Sets the acceleration of gravity, m/s². Declares gravity, switched on, if there is none.
    SetGravity(Vector),
    /// Switches gravity on or off. Does nothing if gravity was never declared.
    SwitchGravity(bool),
    /// Replaces model and rate of the scene's damping. Declares damping if there is none, switches it on if it is off.
    SetDamping(
        #[cfg_attr(feature = "serde", serde(deserialize_with = "Damping::read_checked"))] Damping,
    ),
    /// Switches an effect off, or on again. Does nothing if it was never declared.
    Switch(Effect, bool),
    /// Gives a body, and its group, a method of its own; `None` gives back the world's.
    SetBodyMethod(Body, Option<Method>),
    /// Removes a body.
    Remove(Body),
}

impl<Body> Request<Body> {
    /// The same request with the body that `renamed` returns; `None` if `renamed` returns `None`.
    pub fn rename<Other>(
        self,
        renamed: impl FnOnce(Body) -> Option<Other>,
    ) -> Option<Request<Other>> {
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

/// The requests for the next tick.
#[derive(Resource, Debug, Default)]
pub struct Requests(Vec<Request>);

impl Requests {
    /// Has `request` carried out at the start of the next tick.
    pub fn ask(&mut self, request: Request) {
        self.0.push(request);
    }

    /// The pending requests, in their order.
    pub fn pending(&self) -> impl Iterator<Item = Request> + '_ {
        self.0.iter().copied()
    }

    /// Whether no request is pending.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Carries out the pending requests in their order. Returns whether effects were switched or declared.
pub(crate) fn carry_out(world: &mut World) -> bool {
    let requests = std::mem::take(&mut world.resource_mut::<Requests>().0);
    for run in
        requests.chunk_by(|a, b| matches!((a, b), (Request::Switch(..), Request::Switch(..))))
    {
        match run[0] {
            Request::Impulse(body, impulse) => change(world, body, |_, body| {
                if body.inverse_mass > 0.0 {
                    body.velocity += impulse * body.inverse_mass;
                }
            }),
            // It stays on its curves.
            Request::SetVelocity(body, _) | Request::SetPosition(body, _)
                if world.get::<PrescribedMotion>(body).is_some() => {}
            Request::SetVelocity(body, velocity) => {
                change(world, body, |_, body| body.velocity = velocity);
                // Restarts position Verlet: this velocity belongs to now, not to half a step ago.
                if let Some(mut last) = world.get_mut::<LastStep>(body) {
                    last.0 = 0.0;
                }
                update_static_mark(world, body);
            }
            Request::SetPosition(body, position) => {
                displace(world, body, |at, _| at.position = position);
                // The body did not move there: it is not drawn in between.
                let now = world.get::<Transform>(body).map(|at| at.position);
                if let (Some(now), Some(mut before)) =
                    (now, world.get_mut::<PreviousPosition>(body))
                {
                    before.0 = now;
                }
            }
            Request::SetInverseMass(body, w) => {
                displace(world, body, |_, body| body.inverse_mass = w);
                CouplingChanged::set(world);
                update_static_mark(world, body);
            }
            Request::ReverseVelocities => {
                let mut bodies = world.query_filtered::<(&mut PhysicsBody, Option<&mut LastStep>), (
                    Without<Quarantined>,
                    Without<PrescribedMotion>,
                )>();
                for (mut body, last) in bodies.iter_mut(world) {
                    // Not "-velocity", which would change the sign of 0.
                    body.velocity = Vector::ZERO - body.velocity;
                    if let Some(mut last) = last {
                        last.0 = -last.0;
                    }
                }
                ParticleBackend::with(world, |backend, world| (backend.reverse)(world));
            }
            Request::SetGravity(acceleration) => {
                end_half_steps(world);
                let on = world.get_resource::<Gravity>().is_none_or(|gravity| gravity.on);
                world.insert_resource(Gravity { acceleration, on });
            }
            Request::SwitchGravity(on) => {
                end_half_steps(world);
                if let Some(mut gravity) = world.get_resource_mut::<Gravity>() {
                    gravity.on = on;
                }
            }
            Request::SetDamping(damping) => {
                end_half_steps(world);
                // Damping that was never declared has nothing to switch on.
                let _ = switch(world, Effect::Damping, true);
                world.insert_resource(damping);
            }
            Request::Switch(..) => {
                // Consecutive switches are applied as one: off and on again does nothing at all.
                let switches = run.iter().filter_map(|request| {
                    if let Request::Switch(effect, on) = request {
                        Some((*effect, *on))
                    } else {
                        None
                    }
                });
                for (effect, on) in switches.collect::<BTreeMap<_, _>>() {
                    let _ = switch(world, effect, on);
                }
            }
            Request::SetBodyMethod(body, method) => set_body_method(world, body, method),
            Request::Remove(body) => {
                world.despawn(body);
            }
        }
    }
    requests.iter().any(|request| matches!(request, Request::Switch(..) | Request::SetDamping(_)))
}

type State = (Transform, PhysicsBody);

/// The state of a body and its new one, or the component at fault in the new one; `None` if the body is quarantined or
/// gone.
type Outcome = (State, Result<State, (&'static str, Fault)>);

fn proposed(
    world: &World,
    entity: Entity,
    edit: impl FnOnce(&mut Transform, &mut PhysicsBody),
) -> Option<Outcome> {
    let body = world.get_entity(entity).ok().filter(|body| !body.contains::<Quarantined>())?;
    let old = (*body.get::<Transform>()?, *body.get::<PhysicsBody>()?);
    let mut new = old;
    edit(&mut new.0, &mut new.1);
    let fault = fault_of(&old, &new, world.get_resource::<Range>());
    Some((old, fault.map_or(Ok(new), Err)))
}

/// Changes one body, or quarantines it at its present state if the new one is not finite or out of range.
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

/// Changes the position or mass of one body. Restarts position Verlet for its group, whose next kick would otherwise
/// count the new position or mass for half of the last step. A change that is refused restarts nothing.
fn displace(world: &mut World, entity: Entity, edit: impl Fn(&mut Transform, &mut PhysicsBody)) {
    if proposed(world, entity, &edit).is_some_and(|(_, new)| new.is_ok()) {
        restart_bodies(world, &[entity]);
    }
    change(world, entity, edit);
}

/// The component at fault in a new state, among those that the request has changed.
fn fault_of(old: &State, new: &State, range: Option<&Range>) -> Option<(&'static str, Fault)> {
    let changed = |old: Vector, new: Vector| {
        old.to_array().map(f64::to_bits) != new.to_array().map(f64::to_bits)
    };
    let (x, v, w) = (new.0.position, new.1.velocity, new.1.inverse_mass);
    let moved = changed(old.0.position, x);
    let kicked = changed(old.1.velocity, v);
    let bounds = Bounds::of(range);
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
