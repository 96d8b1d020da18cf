//! A run that is simulated again from a snapshot and what came from outside.

use std::fmt;
use std::iter::Peekable;

use crate::{BadSnapshot, EnergyState, Event, Happening, Snapshot, hash_of_states};
use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::{Stepper, Substeps, TimeStep};
use scene::Scene;

use super::{Fault, Watch};
use crate::input::{Input, give};
use crate::states;

/// A world that was not what it had been when it was simulated again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Broken {
    /// The tick at which it was looked at.
    pub tick: u64,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tick {} comes out differently when it is simulated again", self.tick)
    }
}

impl std::error::Error for Broken {}

/// A world on its way through a past run.
pub struct Replay {
    /// The world.
    pub world: World,
    /// Its stepper.
    pub stepper: Stepper,
    /// Its bodies, by stable id.
    pub bodies: Vec<Entity>,
    /// What looks for faults.
    pub watch: Watch,
}

impl Replay {
    /// A world of `scene` in the state of `snapshot`, when `energy` was what [`Watch::energy`] was.
    ///
    /// # Errors
    /// A snapshot of another scene.
    pub fn of(scene: &Scene, snapshot: &Snapshot, energy: EnergyState) -> Result<Self, BadSnapshot> {
        let (mut world, stepper, bodies) = snapshot.restore(scene)?;
        let watch = Watch::going_on(&mut world, energy);
        Ok(Self { world, stepper, bodies, watch })
    }

    /// Ticks simulated so far.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.world.resource::<StepClock>().ticks()
    }

    /// Hash of the state, as summaries have it.
    pub fn state_hash(&mut self) -> u64 {
        let states = states(&mut self.world).into_iter();
        hash_of_states(states.map(|(_, position, velocity)| (position.to_array(), velocity.to_array())))
    }

    /// Simulates a tick with the next of `events` that belong to it; what went wrong in it.
    pub fn tick<'a>(&mut self, events: &mut Peekable<impl Iterator<Item = &'a Event>>) -> Option<Fault> {
        self.carry_out(events);
        self.watch.tick(&mut self.stepper, &mut self.world, None)
    }

    /// Does what the next of `events` did at this tick; those of ticks before it are passed over. Pushes wait for the
    /// coming tick.
    pub fn carry_out<'a>(&mut self, events: &mut Peekable<impl Iterator<Item = &'a Event>>) {
        let now = self.ticks();
        while let Some(event) = events.next_if(|event| event.tick <= now) {
            if event.tick == now {
                happen(&event.what, &mut self.world, &mut self.stepper, &self.bodies);
            }
        }
    }
}

/// Does to `world`, between two ticks, what happened to another one of its scene. `bodies` are those of the scene by
/// stable id. A push waits for the coming tick.
pub fn happen(what: &Happening, world: &mut World, stepper: &mut Stepper, bodies: &[Entity]) {
    match what {
        Happening::Requests(requests) => {
            give(requests.iter().copied().map(Input::Request), world, bodies);
            stepper.carry_out_requests(world);
        }
        Happening::Method(method) => stepper.set_method(world, *method),
        Happening::Substeps(substeps) => {
            world.insert_resource(Substeps((*substeps).clamp(1, Substeps::MOST)));
        }
        Happening::Step(step) if *step > 0.0 && step.is_finite() => {
            world.insert_resource(TimeStep(*step));
        }
        // No step that a run can have taken.
        Happening::Step(_) => {}
        Happening::Push(body, newtons) => give([Input::Push(*body, *newtons)], world, bodies),
    }
}
