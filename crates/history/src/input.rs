//! What acts on a simulation from outside: read from one, given to others of the same scene.

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{PushQueue, Request, Requests, StableId};

use crate::simulation::Simulation;

/// Something that a tick takes in. Bodies are stable ids, so that it means the same in every world of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// A change between two ticks.
    Request(Request<u32>),
    /// A force on a body for one tick, N.
    Push(u32, Vector),
}

impl Simulation {
    /// What the next tick will take in, in its order: changes first, then pushes, of which the sustained ones will be
    /// there in the tick after it as well. What concerns a thing without a stable id is left out.
    #[must_use]
    pub fn pending(&self) -> Vec<Input> {
        let pushes = self.world.resource::<PushQueue>().pending();
        let pushes = pushes.filter_map(|push| Some(Input::Push(self.id(push.body)?, push.newtons)));
        self.requested().map(Input::Request).chain(pushes).collect()
    }

    /// The changes alone: what a simulation that is paused carries out at once.
    pub fn requested(&self) -> impl Iterator<Item = Request<u32>> + '_ {
        let requests = self.world.resource::<Requests>().pending();
        requests.filter_map(|request| request.rename(|body| self.id(body)))
    }

    /// The stable id of a body.
    pub(crate) fn id(&self, body: Entity) -> Option<u32> {
        self.world.get::<StableId>(body).map(|id| id.0)
    }

    /// Hands `inputs` to the next tick. What concerns a body that is gone is left out.
    pub fn give(&mut self, inputs: impl IntoIterator<Item = Input>) {
        for input in inputs {
            match input {
                Input::Request(request) => {
                    if let Some(request) = request.rename(|id| self.body(id)) {
                        self.request(request);
                    }
                }
                Input::Push(body, newtons) => {
                    if let Some(body) = self.body(body) {
                        self.push(body, newtons);
                    }
                }
            }
        }
    }
}
