//! Prescribed motion: immovable bodies that follow curves.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::curve::in_order;
use super::{Curve, EvaluationTime};
use crate::state::coupling::structure_changed;
use crate::units::{Scalar, Vector, at_least_0};

/// The motion of an immovable body along curves over time: a support that is shaken, a platform. No force or law changes it;
/// springs, mutual gravity, wells and emitters have the body where the curves put it, at every evaluation of a method. Give it
/// no mass ([`PhysicsBody::IMMOVABLE`](crate::PhysicsBody::IMMOVABLE)): a ledger would count it.
///
/// ```
/// use bevy_ecs::prelude::*;
/// use motion::prelude::*;
/// use motion::{Curve, PrescribedMotion, Transform};
///
/// let mut world = World::new();
/// let shaken = Curve::Sine { amplitude: Vector::Y * 0.1, angular_frequency: 6.0, phase: 0.0 };
/// let motion = PrescribedMotion::new(Vector::ZERO, [(shaken, 0.0, f64::INFINITY)]);
/// let support = world.spawn((PhysicsBody::IMMOVABLE, motion)).id();
/// let mut stepper = Stepper::new(&mut world, Method::RungeKutta4, TimeStep(0.01));
/// (0..50).for_each(|_| stepper.tick(&mut world));
/// let y = world.get::<Transform>(support).unwrap().position.y;
/// assert!((y - 0.1 * (6.0 * 0.5_f64).sin()).abs() < 1e-15);
/// ```
///
/// The component is immutable: insert another one to change it.
#[derive(Component, Clone, Debug, PartialEq)]
#[component(immutable, on_insert = structure_changed, on_discard = structure_changed)]
pub struct PrescribedMotion {
    origin: Vector,
    curves: Arc<[Leg]>,
    discontinuities: Arc<[Scalar]>,
}

/// A curve and the time in which it is followed.
#[derive(Clone, Debug, PartialEq)]
struct Leg {
    curve: Curve,
    from: Scalar,
    until: Scalar,
    /// The value of the curve at `from`.
    start: Vector,
}

impl PrescribedMotion {
    /// The motion from `origin`, m, along the sum of curves, m, each with the times from and until which it is followed, s. A
    /// curve is a function of the time since the start of the scene; its displacement counts from its value at the first of
    /// these times, and stays as it is after the second.
    ///
    /// # Panics
    /// If a first time is below 0.
    #[must_use]
    pub fn new(origin: Vector, curves: impl IntoIterator<Item = (Curve, Scalar, Scalar)>) -> Self {
        let leg = |(curve, from, until): (Curve, Scalar, Scalar)| {
            at_least_0(from, "the start of a prescribed motion", "s");
            let start = curve.value(EvaluationTime::at(from));
            Leg { curve, from, until, start }
        };
        let curves: Arc<[Leg]> = curves.into_iter().map(leg).collect();
        let bends = curves.iter().flat_map(|leg| leg.curve.bends(leg.from, leg.until));
        let discontinuities = in_order(bends.collect()).into();
        Self { origin, curves, discontinuities }
    }

    /// The same motion from another origin, m; both share their curves.
    #[must_use]
    pub fn starting_at(&self, origin: Vector) -> Self {
        Self { origin, ..self.clone() }
    }

    /// Position, m, and velocity, m/s, at a time.
    #[must_use]
    pub fn at(&self, at: EvaluationTime) -> [Vector; 2] {
        let mut state = [self.origin, Vector::ZERO];
        for Leg { curve, from, until, start } in &*self.curves {
            if at.within_step >= *until {
                state[0] += curve.value(EvaluationTime::at(*until)) - *start;
            } else if at.within_step >= *from {
                state[0] += curve.value(at) - *start;
                state[1] += curve.rate(at);
            }
        }
        state
    }

    /// Times at which the velocity jumps or bends, s, ascending. Steps are split at these times.
    pub(crate) fn discontinuities(&self) -> &[Scalar] {
        &self.discontinuities
    }
}
