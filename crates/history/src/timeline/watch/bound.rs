//! The watch over orbits: none that is bound becomes free while nothing but attraction acts.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use motion::clock::StepClock;
use motion::{Orbit, TimeStep, orbits};

use crate::timeline::Fault;

/// Ticks from look to look: an orbit takes as long as an evaluation of its law.
const EVERY: u64 = 8;

/// Ticks after which an orbit that became free is a fault even if it has not turned far, so that a timeline still has the
/// tick in which it did.
const LONGEST_DOUBT: u64 = 512;

/// Share of kinetic and potential energy that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// What is known of one orbit.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// Energy when it was bound last, J, and the tick.
    bound_j: f64,
    bound_tick: u64,
    /// The tick from which on it is a fault that it is free, if it is.
    fault_from: Option<u64>,
    reported: bool,
}

/// The orbits that were bound.
#[derive(Debug, Default)]
pub(super) struct BoundOrbits(HashMap<u32, Known>);

impl BoundOrbits {
    /// The orbits of `world`, where a run begins or continues.
    pub fn of(world: &mut World) -> Self {
        let mut bound = Self::default();
        bound.look_at(world);
        bound
    }

    /// Forgets all orbits: something came from outside.
    pub fn forget(&mut self) {
        self.0.clear();
    }

    /// Looks at the orbits after a tick.
    pub fn look(&mut self, world: &mut World) -> Option<Fault> {
        let tick = world.resource::<StepClock>().ticks();
        if tick.is_multiple_of(EVERY) { self.look_at(world) } else { None }
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count of ticks")]
    fn look_at(&mut self, world: &mut World) -> Option<Fault> {
        let tick = world.get_resource::<StepClock>().map_or(0, StepClock::ticks);
        let length = world.get_resource::<TimeStep>().map_or(0.0, |step| step.0);
        let mut fault = None;
        for orbit in orbits(world) {
            let Orbit { body, kinetic, potential, frequency } = orbit;
            let energy = orbit.energy();
            let rounding = ROUNDING * (kinetic - potential);
            if energy < -rounding {
                let known = Known { bound_j: energy, bound_tick: tick, fault_from: None, reported: false };
                self.0.insert(body, known);
                continue;
            }
            let Some(known) = self.0.get_mut(&body).filter(|known| !known.reported) else { continue };
            // At its closest approach a method that keeps the orbit may show it free, for a part of a turn there.
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
                        "the orbit becomes free here although only attraction acts, {energy:.3e} J where there were {:.3e} J",
                        known.bound_j
                    ),
                });
            }
        }
        fault
    }
}
