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
use crate::state::components::{PhysicsBody, Transform};
use crate::state::previous_position::{PreviousPosition, remember_positions};
use crate::units::Vector;

/// The point of the physics that is drawn at the origin of Bevy's world, m. Bevy's `f32` has steps of 6 cm at a distance of
/// 1,000 km from there. Move it together with the camera when that has gone far, before
/// [`RunFixedMainLoopSystems::AfterFixedMainLoop`].
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, bevy_reflect::Reflect)]
#[reflect(Resource)]
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

/// Bevy has no ticks without a length: those of 0 s leave its rate as it is.
fn set_timestep(time: &mut Time<Fixed>, TimeStep(seconds): TimeStep) {
    let length = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    if length > Duration::ZERO {
        time.set_timestep(length);
    }
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
    if !is_fixed(app, schedule) {
        app.add_systems(PostUpdate, draw::<()>.before(TransformSystems::Propagate));
        return;
    }
    let remember = (add_previous, remember_positions).chain();
    let after = RunFixedMainLoopSystems::AfterFixedMainLoop;
    // What was spawned since is at its place in its first frame already.
    let added = draw::<Or<(Added<BevyTransform>, Added<Transform>)>>;
    app.add_systems(schedule, remember.before(StepSystems::Tick))
        .add_systems(RunFixedMainLoop, draw_between.in_set(after))
        .add_systems(PostUpdate, added.before(TransformSystems::Propagate));
}

type New = (With<BevyTransform>, With<PhysicsBody>, Without<PreviousPosition>);

/// Gives bodies that are drawn a previous position; without one they are drawn where they are.
fn add_previous(mut commands: Commands, drawn: Query<(Entity, &Transform), New>) {
    for (entity, Transform { position }) in &drawn {
        commands.entity(entity).insert(PreviousPosition(*position));
    }
}

/// Draws what has both transforms where it is.
fn draw<Which: QueryFilter>(
    origin: Res<FloatingOrigin>,
    mut drawn: Query<(&Transform, &mut BevyTransform), Which>,
) {
    for (Transform { position }, drawn) in &mut drawn {
        place(drawn, *position, *origin);
    }
}

/// Draws what has both transforms where it was between the last two ticks.
fn draw_between(
    time: Res<Time<Fixed>>,
    origin: Res<FloatingOrigin>,
    mut drawn: Query<(&Transform, Option<&PreviousPosition>, &mut BevyTransform)>,
) {
    let fraction = time.overstep_fraction_f64();
    for (Transform { position }, previous, drawn) in &mut drawn {
        let from = previous.map_or(*position, |PreviousPosition(from)| *from);
        place(drawn, from.lerp(*position, fraction), *origin);
    }
}

fn place(mut drawn: Mut<BevyTransform>, position: Vector, FloatingOrigin(origin): FloatingOrigin) {
    let translation = (position - origin).as_vec3();
    if drawn.translation != translation {
        drawn.translation = translation;
    }
}
