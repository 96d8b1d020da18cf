//! Previous positions, for drawing between two ticks.

use bevy_ecs::prelude::*;

use crate::state::components::{PhysicsBody, Transform};
use crate::units::Vector;

/// Position of a body at the start of the last tick, m. Present only in runs that draw between ticks.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct PreviousPosition(pub Vector);

/// Stores every position as [`PreviousPosition`]. Run it before the last tick of a frame.
pub fn remember_positions(
    mut bodies: Query<(&Transform, &mut PreviousPosition), With<PhysicsBody>>,
) {
    let tables =
        bodies.contiguous_iter_mut().expect("every component of a body is stored in tables");
    for (transforms, mut previous) in tables {
        for (transform, previous) in transforms.iter().zip(previous.bypass_change_detection()) {
            previous.0 = transform.position;
        }
    }
}
