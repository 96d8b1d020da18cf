//! Changes of a running simulation from outside.

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{Damping, Method, PushQueue, Request, Requests, StableId, TimeStep};
use scene::lists::list;
use scene::{ChangeAction, Substepping};
use serde::{Deserialize, Serialize};

use crate::simulation::Simulation;

/// A change of a running simulation. It names bodies by stable id, so that it has the same meaning in every world of
/// a scene. Scripts, panels, recordings and bundles make changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Changes of bodies and laws that are carried out together, between two ticks.
    Requests(#[serde(deserialize_with = "list")] Vec<Request<u32>>),
    /// Sets the scene's method.
    Method(Method),
    /// Sets the scene's substeps.
    Substeps(Substepping),
    /// Sets the scene's tick length, s.
    Step(f64),
    /// A force on a body in the next tick, N.
    Push(u32, Vector),
}

/// A body of this name was removed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no body {0} any more")]
pub struct Gone(pub String);

impl Change {
    /// Whether it may add energy: all but the length of ticks.
    #[must_use]
    pub const fn may_add_energy(&self) -> bool {
        !matches!(self, Self::Step(_))
    }

    /// A change of one body or law.
    #[must_use]
    pub fn request(request: Request<u32>) -> Self {
        Self::Requests(vec![request])
    }

    /// The change of `simulation` that a script's action makes.
    ///
    /// # Errors
    /// If the action names a body that was removed.
    pub fn of(action: &ChangeAction, simulation: &Simulation) -> Result<Self, Gone> {
        let id = |name: &String| {
            let body = simulation.named(name).and_then(|body| simulation.id(body));
            body.ok_or_else(|| Gone(name.clone()))
        };
        // The arms of actions that are no requests return.
        Ok(Self::request(match action {
            ChangeAction::Push(body, newtons) => return Ok(Self::Push(id(body)?, *newtons)),
            ChangeAction::SetMethod(method) => return Ok(Self::Method(*method)),
            ChangeAction::SetSubsteps(substeps) => return Ok(Self::Substeps(*substeps)),
            ChangeAction::Impulse(body, impulse) => Request::Impulse(id(body)?, *impulse),
            ChangeAction::SetVelocity(body, velocity) => Request::SetVelocity(id(body)?, *velocity),
            ChangeAction::SetPosition(body, position) => Request::SetPosition(id(body)?, *position),
            ChangeAction::SetBodyMethod(body, method) => {
                Request::SetBodyMethod(id(body)?, Some(*method))
            }
            ChangeAction::Remove(body) => Request::Remove(id(body)?),
            ChangeAction::SetGravity(acceleration) => Request::SetGravity(*acceleration),
            ChangeAction::SetDamping(rate) => {
                let damping = simulation.world.get_resource::<Damping>();
                let model = damping.map_or_else(Default::default, |damping| damping.model);
                Request::SetDamping(Damping { model, rate: *rate })
            }
            ChangeAction::ReverseVelocities => Request::ReverseVelocities,
            ChangeAction::SwitchEffect(effect, on) => Request::Switch(*effect, *on),
        }))
    }
}

impl Simulation {
    /// Changes that wait for the next tick, in the order in which it applies them: requests that are not carried out yet, then
    /// pushes. A sustained push appears as its push in that tick. Changes of an entity without a stable id are left out.
    #[must_use]
    pub fn pending(&self) -> Vec<Change> {
        // `rename` gives the same request for the stable id instead of the entity; in `give` the other way round.
        let requests = self.world.resource::<Requests>().pending();
        let requests: Vec<_> =
            requests.filter_map(|request| request.rename(|body| self.id(body))).collect();
        let requests = (!requests.is_empty()).then_some(Change::Requests(requests));
        let pushes = self.world.resource::<PushQueue>().pending();
        let pushes =
            pushes.filter_map(|push| Some(Change::Push(self.id(push.body)?, push.newtons)));
        requests.into_iter().chain(pushes).collect()
    }

    /// The stable id of a body.
    #[must_use]
    pub fn id(&self, body: Entity) -> Option<u32> {
        self.world.get::<StableId>(body).map(|id| id.0)
    }

    /// Makes a change between two ticks: at once, but a push waits for the coming tick. Changes of a body that was removed
    /// are left out.
    pub fn give(&mut self, change: &Change) {
        match change {
            Change::Requests(requests) => {
                let requests: Vec<_> = requests
                    .iter()
                    .filter_map(|request| request.rename(|id| self.body(id)))
                    .collect();
                requests.into_iter().for_each(|request| self.request(request));
                self.carry_out_requests();
            }
            Change::Method(method) => self.set_method(*method),
            Change::Substeps(substeps) => substeps.clamped().put(&mut self.world),
            Change::Step(step) if *step > 0.0 && step.is_finite() => {
                self.world.insert_resource(TimeStep(*step));
            }
            // An invalid length (from a damaged file) is ignored.
            Change::Step(_) => {}
            Change::Push(body, newtons) => {
                if let Some(body) = self.body(*body) {
                    self.push(body, *newtons);
                }
            }
        }
    }
}
