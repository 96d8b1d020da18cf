//! The system of bodies that follow a prescribed motion.

use bevy_ecs::prelude::*;

use crate::laws::{EvaluationTime, PrescribedMotion};
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{PhysicsBody, Quarantined, Transform};
use crate::state::range::{Bounds, Quantity, Range};
use crate::tick::quarantine::{Cause, Fault, Quarantine, Refused, place};

/// Brings bodies with a [`PrescribedMotion`] to the end of the tick.
pub fn follow_motion(
    clock: Res<StepClock>,
    step: Res<TimeStep>,
    range: Option<Res<Range>>,
    mut quarantine: ResMut<Quarantine>,
    mut bodies: Query<
        (Entity, &PrescribedMotion, &mut Transform, &mut PhysicsBody),
        Without<Quarantined>,
    >,
) {
    let end = EvaluationTime::at(clock.after(step.0).scene_seconds());
    let (range, bounds) =
        (range.as_deref().copied().unwrap_or_default(), Bounds::of(range.as_deref()));
    for (entity, motion, mut transform, mut body) in &mut bodies {
        let [position, velocity] = motion.at(end);
        let [u, v, w] = velocity.to_array();
        match bounds.breach(&position.to_array(), &[u, v, w, 0.0]) {
            None => (transform.position, body.velocity) = (position, velocity),
            Some(breach) => {
                let (component, bound) = match breach.of {
                    Quantity::Position => (place::POSITION, range.position),
                    Quantity::Velocity => (place::VELOCITY, range.speed),
                };
                let (component, fault) = match breach.finite {
                    false => (component, Fault::Overflow),
                    true if bound.is_nan() => (place::RANGE, Fault::Found),
                    true => (component, Fault::Range(bound)),
                };
                let cause = Cause { system: Cause::FOLLOW_MOTION, component, fault };
                quarantine.refuse(Refused {
                    body: entity,
                    transform: *transform,
                    state: *body,
                    cause,
                });
            }
        }
    }
}
