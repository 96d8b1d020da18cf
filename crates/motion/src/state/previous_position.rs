//! Previous positions, for drawing between two ticks.

use bevy_ecs::prelude::*;

use crate::state::components::{PhysicsBody, Transform};
use crate::units::Vector;

/// Position of a body when [`remember_positions`] ran last, m. `InertiaPlugin::with_drawing` inserts it into what is drawn, and runs
/// that before every tick. Without it do both yourself:
///
/// ```
/// use bevy_ecs::prelude::*;
/// use motion::prelude::*;
/// use motion::{PreviousPosition, Transform, remember_positions};
///
/// let mut world = World::new();
/// let ball = |x| (PhysicsBody::with_mass(1.0).moving_at(Vector::X * x), PreviousPosition::default());
/// let [_, runs] = [0.0, 1.0].map(|x| world.spawn(ball(x)).id());
/// let mut schedule = Schedule::default();
/// let stepper = Stepper::new(&mut world, Method::VelocityVerlet, TimeStep(0.01));
/// stepper.install(&mut world, &mut schedule);
/// schedule.add_systems(remember_positions.before(StepSystems::Tick));
/// schedule.run(&mut world);
/// let mut all = world.query::<(Entity, &Transform, &PreviousPosition)>();
/// let moved = all.iter(&world).filter(|(_, now, before)| now.position != before.0);
/// assert_eq!(moved.map(|(body, ..)| body).collect::<Vec<_>>(), [runs]);
/// ```
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Component))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct PreviousPosition(pub Vector);

/// Stores every position as [`PreviousPosition`]. Run it before each tick, or before the last one of a frame.
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
