//! Wells that ride on bodies.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};

use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use glam::DMat3;

use super::wells::Well;
use super::{BodyState, EvaluationTime, Jacobians, Law, PrescribedMotion};
use crate::state::clock::StepClock;
use crate::state::components::{PhysicsBody, Quarantined, Transform};
use crate::state::emitter::Dormant;
use crate::units::{Scalar, Vector, at_least_0};

/// A [`Well`] that rides on a body. It attracts the bodies that have it among their [`OwnLaws`](crate::OwnLaws): copies of one
/// well share its motion. Inserting a well among the laws of its own carrier panics.
///
/// Within a tick the carrier counts as moving uniformly, with its velocity at the start of the tick, so that methods of an
/// order above 2 are of order 2 here. A carrier with a [`PrescribedMotion`] is where that has it. The well does not attract while its carrier is removed, disabled, quarantined or
/// dormant. It has no potential energy: as it moves, it does work.
#[derive(Clone, Debug)]
pub struct RidingWell {
    carrier: Entity,
    strength: Scalar,
    softening: Scalar,
    course: Arc<Course>,
}

/// The wells of a world that ride on bodies, one copy of each.
#[derive(Resource, Debug, Default)]
pub struct RidingWells(Vec<RidingWell>);

impl RidingWells {
    /// Adds the wells among the laws of `body`, which moves them from then on.
    ///
    /// # Panics
    /// If one of them rides on `body`.
    pub(crate) fn add_those_of(
        world: &mut DeferredWorld<'_>,
        body: Entity,
        wells: Vec<RidingWell>,
    ) {
        if let Some(well) = wells.iter().find(|well| well.carrier == body) {
            panic!(
                "a well rides on the body {} and is among its own laws; give it to others",
                well.carrier
            );
        }
        if wells.is_empty() {
            return;
        }
        world.commands().queue(move |world: &mut World| {
            let mut all = world.get_resource_or_init::<Self>();
            for well in wells {
                if !all.0.iter().any(|known| Arc::ptr_eq(&known.course, &well.course)) {
                    all.0.push(well);
                }
            }
        });
    }
}

/// Position, m, and velocity, m/s, of the carrier at a time, and that time, s, as bits; NaN while it cannot carry the well.
#[derive(Debug)]
struct Course {
    bits: [AtomicU64; 7],
    /// How often it was set.
    version: AtomicU64,
    /// The motion of a carrier that follows one.
    motion: RwLock<Option<PrescribedMotion>>,
    follows_motion: AtomicBool,
}

impl Course {
    fn set(&self, numbers: [Scalar; 7]) {
        // Set by a system of its own, before the laws are called.
        self.bits
            .iter()
            .zip(numbers)
            .for_each(|(bits, number)| bits.store(number.to_bits(), Ordering::Relaxed));
        self.version.fetch_add(1, Ordering::Relaxed);
    }

    fn follow(&self, motion: Option<&PrescribedMotion>) {
        if motion.is_some() || self.follows_motion.load(Ordering::Relaxed) {
            self.follows_motion.store(motion.is_some(), Ordering::Relaxed);
            *self.motion.write().unwrap_or_else(PoisonError::into_inner) = motion.cloned();
        }
    }

    fn at(&self, at: EvaluationTime) -> Vector {
        if self.follows_motion.load(Ordering::Relaxed) {
            let motion = self.motion.read().unwrap_or_else(PoisonError::into_inner);
            return motion.as_ref().map_or(Vector::NAN, |motion| motion.at(at)[0]);
        }
        let [x, y, z, u, v, w, since] = [0, 1, 2, 3, 4, 5, 6]
            .map(|i: usize| Scalar::from_bits(self.bits[i].load(Ordering::Relaxed)));
        Vector::new(x, y, z) + Vector::new(u, v, w) * (at.time - since)
    }
}

const AWAY: [Scalar; 7] = [Scalar::NAN; 7];

impl RidingWell {
    /// A well on `carrier` of the strength mu, m³/s², negative repels, and the softening s, m, at least 0: as those of a
    /// [`Well`].
    ///
    /// # Panics
    /// If the softening is below 0.
    #[must_use]
    pub fn new(carrier: Entity, strength: Scalar, softening: Scalar) -> Self {
        at_least_0(softening, "the softening of a well", "m");
        let bits = AWAY.map(|number| AtomicU64::new(number.to_bits()));
        let course = Arc::new(Course {
            bits,
            version: AtomicU64::new(0),
            motion: RwLock::default(),
            follows_motion: AtomicBool::new(false),
        });
        Self { carrier, strength, softening, course }
    }

    /// The body on which it rides.
    #[must_use]
    pub const fn carrier(&self) -> Entity {
        self.carrier
    }

    /// The well at a time; `None` while it does not attract.
    fn at(&self, at: EvaluationTime) -> Option<Well> {
        let position = self.course.at(at);
        let well = Well { position, strength: self.strength, softening: self.softening };
        position.is_finite().then_some(well)
    }
}

impl Law for RidingWell {
    fn name(&self) -> &'static str {
        "wells"
    }

    fn text(&self) -> String {
        format!("wells: 1 on {}", self.carrier)
    }

    fn acceleration(&self, at: EvaluationTime, body: BodyState) -> Vector {
        self.at(at).map_or(Vector::ZERO, |well| well.acceleration(body))
    }

    fn jacobians(&self, at: EvaluationTime, body: BodyState) -> Jacobians {
        let position = self.at(at).map_or(DMat3::ZERO, |well| well.add_jacobian(DMat3::ZERO, body));
        Jacobians { position, ..Jacobians::zero() }
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }

    fn riding_well(&self) -> Option<&RidingWell> {
        Some(self)
    }

    /// Changes with the course, once per tick: accelerations cached along the last course are invalid.
    fn version(&self) -> Option<u64> {
        Some(self.course.version.load(Ordering::Relaxed))
    }
}

/// Moves the wells of `world` to their carriers, and forgets those that no body has any more. Returns whether there are any.
pub(crate) fn prepare(world: &mut World) -> bool {
    if let Some(mut wells) = world.get_resource_mut::<RidingWells>() {
        wells.0.retain(|well| Arc::strong_count(&well.course) > 1);
        if wells.0.is_empty() {
            world.remove_resource::<RidingWells>();
        }
    }
    let carries = world.contains_resource::<RidingWells>();
    if carries && world.contains_resource::<StepClock>() {
        world.run_system_cached(carry_wells).expect("its parameters were looked for");
    }
    carries
}

/// A body that can carry a well now.
type Carrier = (Without<Quarantined>, Without<Dormant>);

/// Moves the wells to their carriers at the start of the tick.
pub fn carry_wells(
    wells: Res<RidingWells>,
    clock: Res<StepClock>,
    bodies: Query<(&Transform, &PhysicsBody, Option<&PrescribedMotion>), Carrier>,
) {
    for RidingWell { carrier, course, .. } in &wells.0 {
        let carrier = bodies.get(*carrier);
        course.follow(carrier.ok().and_then(|(.., motion)| motion));
        course.set(carrier.map_or(AWAY, |(transform, body, _)| {
            let ([x, y, z], [u, v, w]) = (transform.position.to_array(), body.velocity.to_array());
            [x, y, z, u, v, w, clock.scene_seconds()]
        }));
    }
}
