//! Detects bound orbits that become free while attraction is the only force.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::{Orbit, TimeStep, orbits};

use crate::timeline::Fault;

/// Ticks between two checks: checking an orbit takes as long as an evaluation of its law.
const EVERY: u64 = 8;

/// Ticks after which a free orbit is a fault even if it has not turned far, so that a timeline still has the tick in
/// which it became free.
const LONGEST_DOUBT: u64 = 512;

/// Part of kinetic energy and magnitude of potential energy that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// An orbit that was bound.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// Energy when it was last bound, J.
    bound_j: f64,
    /// Tick at which it was last bound.
    bound_tick: u64,
    /// The tick from which on a free orbit is a fault; `None` while it is bound.
    fault_from: Option<u64>,
    reported: bool,
}

/// The orbits that were bound, by stable id of the body.
#[derive(Debug, Default)]
pub(super) struct BoundOrbits(HashMap<u32, Known>);

impl BoundOrbits {
    /// The bound orbits of `world`.
    pub fn of(world: &mut World) -> Self {
        let mut bound = Self::default();
        bound.look_at(world);
        bound
    }

    /// Forgets all orbits, after a change from outside.
    pub fn forget(&mut self) {
        self.0.clear();
    }

    /// Checks the orbits after a tick, once every [`EVERY`] ticks.
    pub fn look(&mut self, world: &mut World) -> Option<Fault> {
        let tick = world.resource::<StepClock>().ticks();
        if tick.is_multiple_of(EVERY) { self.look_at(world) } else { None }
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small count of ticks"
    )]
    fn look_at(&mut self, world: &mut World) -> Option<Fault> {
        let tick = world.get_resource::<StepClock>().map_or(0, StepClock::ticks);
        let length = world.get_resource::<TimeStep>().map_or(0.0, |step| step.0);
        let mut fault = None;
        for orbit in orbits(world) {
            let Orbit { body, kinetic, potential, frequency } = orbit;
            let energy = orbit.energy();
            let rounding = ROUNDING * (kinetic - potential);
            if energy < -rounding {
                let known =
                    Known { bound_j: energy, bound_tick: tick, fault_from: None, reported: false };
                self.0.insert(body, known);
                continue;
            }
            let Some(known) = self.0.get_mut(&body).filter(|known| !known.reported) else {
                continue;
            };
            // A method that keeps an orbit bound may show it as free for part of a turn, around the closest approach.
            let doubt = (std::f64::consts::PI / (frequency * length)).ceil();
            let doubt = if doubt < LONGEST_DOUBT as f64 { doubt as u64 } else { LONGEST_DOUBT };
            let fault_from = *known.fault_from.get_or_insert(tick.saturating_add(doubt.max(1)));
            if tick >= fault_from && energy > rounding && fault.is_none() {
                known.reported = true;
                fault = Some(Fault {
                    tick: known.bound_tick.saturating_add(1),
                    found: tick,
                    body: Some(body),
                    quarantined: false,
                    what: format!(
                        "the orbit becomes free here although only attraction acts: its energy rose from {:.3e} J to {energy:.3e} J",
                        known.bound_j
                    ),
                });
            }
        }
        fault
    }
}
