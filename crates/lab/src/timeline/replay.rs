//! A run that is simulated again from a snapshot and what came from outside.

use std::fmt;
use std::iter::Peekable;

use bevy_ecs::prelude::*;
use motion::{Ledger, StepClock, Stepper, Substeps, TimeStep};
use scene::{BadSnapshot, Event, Happening, Scene, Snapshot, hash_of_states};

use crate::input::{Input, give};
use crate::run::states;

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
}

impl Replay {
    /// A world of `scene` in the state of `snapshot`.
    ///
    /// # Errors
    /// A snapshot of another scene.
    pub fn of(scene: &Scene, snapshot: &Snapshot) -> Result<Self, BadSnapshot> {
        let (world, stepper, bodies) = snapshot.restore(scene)?;
        Ok(Self { world, stepper, bodies })
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

    /// Simulates a tick with the next of `events` that belong to it, booked by `ledger` if there is one.
    pub fn tick<'a>(
        &mut self,
        events: &mut Peekable<impl Iterator<Item = &'a Event>>,
        ledger: Option<&mut Ledger>,
    ) {
        self.carry_out(events);
        match ledger {
            Some(ledger) => ledger.tick(&mut self.stepper, &mut self.world),
            None => self.stepper.tick(&mut self.world),
        }
    }

    /// Does what the next of `events` did at this tick; those of ticks before it are passed over. Pushes wait for the
    /// coming tick.
    pub fn carry_out<'a>(&mut self, events: &mut Peekable<impl Iterator<Item = &'a Event>>) {
        let now = self.ticks();
        while let Some(event) = events.next_if(|event| event.tick <= now) {
            if event.tick == now {
                self.happen(&event.what);
            }
        }
    }

    fn happen(&mut self, what: &Happening) {
        match what {
            Happening::Requests(requests) => {
                let inputs = requests.iter().copied().map(Input::Request);
                give(inputs, &mut self.world, &self.bodies);
                self.stepper.carry_out_requests(&mut self.world);
            }
            Happening::Method(method) => self.stepper.set_method(&mut self.world, *method),
            Happening::Substeps(substeps) => {
                self.world.insert_resource(Substeps((*substeps).clamp(1, Substeps::MOST)));
            }
            Happening::Step(step) if *step > 0.0 && step.is_finite() => {
                self.world.insert_resource(TimeStep(*step));
            }
            // No step that a run can have taken.
            Happening::Step(_) => {}
            Happening::Push(body, newtons) => {
                give([Input::Push(*body, *newtons)], &mut self.world, &self.bodies);
            }
        }
    }
}
