//! The bodies of groups in the tables of a world, and what they ask for by row.

use bevy_ecs::prelude::*;

use super::field::{Askers, RowAsks};
use crate::laws::Law;
use crate::laws::damping::DampingRate;
use crate::laws::own::OwnLaws;
use crate::state::components::{
    AxisLocks, Force, GravityOff, PhysicsBody, Quarantined, SpeedLimit, Transform,
};
use crate::state::coupling::Grouped;
use crate::state::method_state::LastStep;
use crate::units::Scalar;

/// The bodies of a system that move in groups.
pub(super) type Members<'w, 's, Who> = Query<
    'w,
    's,
    (Entity, &'static mut Transform, &'static mut PhysicsBody, &'static Force, Option<&'static mut LastStep>),
    (Who, With<Grouped>, Without<Quarantined>),
>;

/// What members may ask for.
pub(super) type Wishes<'w, 's> = Query<
    'w,
    's,
    (
        Has<GravityOff>,
        Option<&'static DampingRate>,
        Option<&'static SpeedLimit>,
        Option<&'static AxisLocks>,
        Option<&'static OwnLaws>,
    ),
    With<Grouped>,
>;

/// Looks wishes up by row.
pub(super) struct ByRow<'a, 'w, 's> {
    pub bodies: &'a [Entity],
    pub wishes: &'a Wishes<'w, 's>,
}

impl Askers<Scalar> for ByRow<'_, '_, '_> {
    fn asks(&self, row: usize) -> RowAsks {
        match self.wishes.get(self.bodies[row]) {
            Ok((gravity_off, rate, limit, locks, _)) => RowAsks {
                gravity_off,
                damping_rate: rate.map(DampingRate::rate),
                limit: limit.map(|limit| limit.0),
                locks: locks.copied(),
            },
            Err(_) => RowAsks::default(),
        }
    }

    fn laws(&self, row: usize) -> (&[Box<dyn Law<Scalar>>], u64) {
        match self.wishes.get(self.bodies[row]) {
            Ok((.., Some(own))) => (own.laws(), own.version()),
            _ => (&[], 0),
        }
    }
}
