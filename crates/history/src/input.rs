//! What acts on a run from outside: read from one world, given to others of the same scene.

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{Push, PushQueue, Request, Requests, StableId};

/// Something that a tick takes in. Bodies are stable ids, so that it means the same in every world of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// A change between two ticks.
    Request(Request<u32>),
    /// A force on a body for one tick, N.
    Push(u32, Vector),
}

/// What the next tick of `world` will take in, in its order: changes first, then pushes, of which the sustained
/// ones will be there in the tick after it as well. What concerns a thing without a stable id is left out.
#[must_use]
pub fn pending(world: &World) -> Vec<Input> {
    let pushes = world.get_resource::<PushQueue>().into_iter().flat_map(PushQueue::pending);
    let pushes = pushes.filter_map(|Push { body, newtons }| Some(Input::Push(id(world, body)?, newtons)));
    asked(world).chain(pushes).collect()
}

/// The changes alone: what a world that is paused carries out at once.
pub fn asked(world: &World) -> impl Iterator<Item = Input> + '_ {
    let requests = world.get_resource::<Requests>().into_iter().flat_map(Requests::pending);
    requests.filter_map(|request| Some(Input::Request(request.rename(|body| id(world, body))?)))
}

fn id(world: &World, body: Entity) -> Option<u32> {
    world.get::<StableId>(body).map(|id| id.0)
}

/// Hands `inputs` to the next tick of `world`, in which `bodies` are those of the scene by stable id, as
/// [`Scene::spawn`](scene::Scene::spawn) returns them. What concerns a body that is gone is left out.
///
/// # Panics
/// In a world that no [`Stepper`](motion::Stepper) has prepared.
pub fn give(inputs: impl IntoIterator<Item = Input>, world: &mut World, bodies: &[Entity]) {
    for input in inputs {
        let here = |id: u32| bodies.get(id as usize).copied().filter(|body| world.get_entity(*body).is_ok());
        match input {
            Input::Request(request) => {
                if let Some(request) = request.rename(here) {
                    world.resource_mut::<Requests>().ask(request);
                }
            }
            Input::Push(body, newtons) => {
                if let Some(body) = here(body) {
                    world.resource_mut::<PushQueue>().push_once(body, newtons);
                }
            }
        }
    }
}
