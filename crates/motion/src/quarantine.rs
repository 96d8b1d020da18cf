//! Bodies that would turn non-finite: frozen at their last finite state, marked, and named.

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;

use crate::clock::StepClock;
use crate::components::{PhysicsBody, Quarantined, Transform};
use crate::groups::Groups;

/// What would have become infinite or not a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// The velocity, by the force or the law of the tick.
    Velocity,
    /// The position, by the velocity of the tick.
    Position,
    /// Either, by a method that updates both at once.
    State,
    /// Either, in a group: of all its members this one was first.
    Group,
    /// A value that an experiment asked to set.
    Request,
}

impl Cause {
    /// What happened, for summaries and panels.
    #[must_use]
    pub const fn what(self) -> &'static str {
        match self {
            Self::Velocity => "velocity would turn non-finite in integrate_acceleration",
            Self::Position => "position would turn non-finite in integrate_velocity",
            Self::State => "position or velocity would turn non-finite in integrate",
            Self::Group => "position or velocity would turn non-finite in integrate_groups",
            Self::Request => "an experiment asked for a non-finite state",
        }
    }
}

/// One body that was frozen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuarantineRecord {
    /// The body.
    pub body: Entity,
    /// Number of the tick that it did not survive, counted from 1.
    pub tick: u64,
    /// What would have become non-finite.
    pub cause: Cause,
}

/// A body refused in the running tick, with the finite state to freeze it at.
#[derive(Clone, Copy, Debug)]
struct Refused {
    body: Entity,
    transform: Transform,
    state: PhysicsBody,
    cause: Cause,
}

/// Every body that was frozen so far, in the order of events.
#[derive(Resource, Debug, Default)]
pub struct Quarantine {
    refused: Vec<Refused>,
    records: Vec<QuarantineRecord>,
}

impl Quarantine {
    /// The bodies that were frozen, in the order of events.
    #[must_use]
    pub fn records(&self) -> &[QuarantineRecord] {
        &self.records
    }

    /// A kernel did not commit a row: `transform` and `state` are what it holds and stays at.
    #[cold]
    pub(crate) fn refuse(&mut self, body: Entity, transform: Transform, state: PhysicsBody, cause: Cause) {
        self.refused.push(Refused { body, transform, state, cause });
    }
}

/// Freezes the bodies that the tick refused and marks them [`Quarantined`].
pub fn quarantine_bodies(
    mut commands: Commands,
    mut quarantine: ResMut<Quarantine>,
    groups: Option<ResMut<Groups>>,
    clock: Option<Res<StepClock>>,
) {
    if quarantine.refused.is_empty() {
        return;
    }
    if let Some(mut groups) = groups {
        // Its springs are inert.
        groups.outdate();
    }
    let tick = clock.map_or(0, |clock| clock.ticks() + 1);
    let Quarantine { refused, records } = &mut *quarantine;
    let mut seen = EntityHashSet::default();
    for Refused { body, transform, state, cause } in refused.drain(..) {
        // The first refusal of a tick has the state before the tick went wrong; a later one has not.
        if !seen.insert(body) {
            continue;
        }
        // The rest of the tick may have moved the row on: the state before is put back with the mark.
        commands.entity(body).try_insert((transform, state, Quarantined));
        records.push(QuarantineRecord { body, tick, cause });
    }
}
