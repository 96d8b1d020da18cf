//! Broken methods, each of a mistake that is easily made, and the check that rejects it.

#[macro_use]
mod kinds;
mod broken;

use crate::rigs::Bare;
use glam::DVec3;
use motion::internals::{Axes, BLOCK_BODIES, BodyBlock};
use motion::{BodyState, EvaluationTime, Gravity, Jacobians, Law};

use super::pushes::{check_gravity, check_passes_over};
use super::{Check, Stepper, damping, fingerprint, orders, pushes, verlet};
use crate::rigs::Formula;

/// A check of a method.
type Checked = (&'static str, fn(&Stepper) -> Check);

const FINGERPRINT: Checked = ("fingerprint", fingerprint::check);
const ORDERS: Checked = ("orders", orders::check);
const PUSH: Checked = ("push", pushes::check_push);
const CHANGING_STEPS: Checked = ("changing steps", verlet::check_jitter);
const START: Checked = ("start", verlet::check_start);
const FAR_AWAY: Checked = ("far away", verlet::check_far_away);
const DECAY: Checked = ("decay", damping::check_decay);
const TERMINAL_SPEED: Checked = ("terminal speed", damping::check_terminal);
const MULTIPLIERS: Checked = ("multipliers", damping::check_multipliers);

#[test]
fn every_broken_method_is_rejected() {
    let mut survivors = vec![];
    for (mutant, (name, check)) in broken::all() {
        match check(&mutant) {
            Ok(()) => survivors.push((mutant.name, name)),
            Err(why) => {
                println!("{}: rejected by {name}: {}", mutant.name, why.lines().next().unwrap());
            }
        }
    }
    assert!(survivors.is_empty(), "not rejected: {survivors:?}");
}

#[test]
fn gravity_by_mass_is_rejected() {
    // Gravity as a force: heavy bodies fall slower.
    let by_mass = |bare: Bare| {
        let law = |at, body: BodyState| Gravity::EARTH.acceleration(at, body) * body.inverse_mass;
        bare.with_law(Formula::new("gravity by mass", law))
    };
    check_gravity(by_mass).unwrap_err();
}

/// Gravity that forgets that some bodies cannot be moved.
#[derive(Debug)]
struct OnEverything;

impl Law for OnEverything {
    fn name(&self) -> &'static str {
        "gravity on everything"
    }
    fn acceleration(&self, at: EvaluationTime, body: BodyState) -> DVec3 {
        Gravity::EARTH.acceleration(at, body)
    }
    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians::zero()
    }
    fn depends_on_velocity(&self) -> bool {
        false
    }
    fn accelerate(&self, at: EvaluationTime, bodies: &BodyBlock<'_>, sum: &mut Axes) {
        #[expect(clippy::needless_range_loop, reason = "one number for many arrays")]
        for k in 0..BLOCK_BODIES {
            let a = self.acceleration(at, bodies.body(k)).to_array();
            (0..3).for_each(|axis| sum[axis][k] += a[axis]);
        }
    }
}

#[test]
fn gravity_on_immovable_bodies_is_rejected() {
    check_passes_over(&OnEverything).unwrap_err();
}
