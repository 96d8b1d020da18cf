//! Drawing in Bevy: positions between two ticks, around a floating origin, and the rate of ticks.

use core::time::Duration;

use bevy_app::FixedMainScheduleOrder;
use bevy_app::prelude::*;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryFilter;
use bevy_ecs::schedule::InternedScheduleLabel;
use bevy_time::{Fixed, Time};
use bevy_transform::TransformSystems;
use bevy_transform::components::Transform as BevyTransform;

use crate::schedule::systems::StepSystems;
use crate::state::clock::TimeStep;
use crate::state::components::Transform;
use crate::state::previous_position::{PreviousPosition, remember_positions};
use crate::units::Vector;

/// The point of the physics that is drawn at the origin of Bevy's world, m. Set it to the position of what the camera follows, and
/// keep the camera near the origin: Bevy's `f32` has steps of 6 cm at a distance of 1,000 km, the physics has none that can be seen.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct FloatingOrigin(pub Vector);

/// The length of a tick, as the physics and [`Time<Fixed>`] were last seen to have it.
#[derive(Resource)]
struct Rate {
    step: TimeStep,
    fixed: Duration,
}

/// Whether `schedule` runs at the rate of [`Time<Fixed>`].
pub(crate) fn is_fixed(app: &App, schedule: InternedScheduleLabel) -> bool {
    let order = app.world().get_resource::<FixedMainScheduleOrder>();
    order.is_some_and(|order| order.labels.contains(&schedule))
}

/// Makes the length of a tick and [`Time<Fixed>`] one setting, which has the value `step` or else the one that the app has. Returns
/// the value.
pub(crate) fn share_rate(app: &mut App, step: Option<TimeStep>) -> TimeStep {
    let mut time = app.world_mut().get_resource_or_init::<Time<Fixed>>();
    let step = match step {
        Some(step) => {
            step.check();
            set_timestep(&mut time, step);
            step
        }
        None => TimeStep(time.timestep().as_secs_f64()),
    };
    let fixed = time.timestep();
    app.insert_resource(Rate { step, fixed });
    let before = RunFixedMainLoopSystems::BeforeFixedMainLoop;
    app.add_systems(RunFixedMainLoop, follow_rate.in_set(before));
    step
}

fn set_timestep(time: &mut Time<Fixed>, TimeStep(seconds): TimeStep) {
    time.set_timestep(Duration::from_secs_f64(seconds).max(Duration::from_nanos(1)));
}

/// Carries a change of the length of a tick over to [`Time<Fixed>`], or the reverse.
fn follow_rate(mut last: ResMut<Rate>, mut step: ResMut<TimeStep>, mut time: ResMut<Time<Fixed>>) {
    if *step != last.step {
        step.check();
        set_timestep(&mut time, *step);
    } else if time.timestep() != last.fixed {
        *step = TimeStep(time.timestep().as_secs_f64());
    }
    *last = Rate { step: *step, fixed: time.timestep() };
}

/// Copies positions to Bevy's `Transform`; between the last two ticks if `schedule` is a fixed one.
pub(crate) fn draw_bodies(app: &mut App, schedule: InternedScheduleLabel) {
    app.init_resource::<FloatingOrigin>();
    if is_fixed(app, schedule) {
        let remember = (add_previous, remember_positions).chain();
        app.add_systems(schedule, remember.before(StepSystems::Tick));
    }
    let after = RunFixedMainLoopSystems::AfterFixedMainLoop;
    app.add_systems(RunFixedMainLoop, draw::<()>.in_set(after));
    // What was spawned since is at its place in its first frame already.
    let added = draw::<Added<BevyTransform>>.before(TransformSystems::Propagate);
    app.add_systems(PostUpdate, added);
}

/// Gives what is drawn a previous position; without one it is drawn where it is.
fn add_previous(
    mut commands: Commands,
    drawn: Query<(Entity, &Transform), (With<BevyTransform>, Without<PreviousPosition>)>,
) {
    for (entity, Transform { position }) in &drawn {
        commands.entity(entity).insert(PreviousPosition(*position));
    }
}

fn draw<Which: QueryFilter>(
    time: Res<Time<Fixed>>,
    origin: Res<FloatingOrigin>,
    mut drawn: Query<(&Transform, Option<&PreviousPosition>, &mut BevyTransform), Which>,
) {
    let fraction = time.overstep_fraction_f64();
    for (Transform { position }, previous, mut drawn) in &mut drawn {
        let from = previous.map_or(*position, |PreviousPosition(from)| *from);
        let translation = (from.lerp(*position, fraction) - origin.0).as_vec3();
        if drawn.translation != translation {
            drawn.translation = translation;
        }
    }
}
