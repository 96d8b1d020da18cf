//! The systems of a tick, their sets, and the schedule that they are compiled to.

use bevy_ecs::prelude::*;
use bevy_ecs::query::{ArchetypeFilter, QueryFilter};
use bevy_ecs::schedule::{
    LogLevel, ScheduleBuildSettings, ScheduleConfigs, ScheduleLabel, SingleThreadedExecutor,
};
use bevy_ecs::system::ScheduleSystem;

use crate::groups::integrate_groups;
use crate::kernels::evaluations::Evaluations;
use crate::kernels::record::TickRecords;
use crate::laws::epoch::Epoch;
use crate::laws::own::OwnLaws;
use crate::methods::table::Method;
use crate::methods::{ExplicitEuler, Integrator, MethodState, SemiImplicitEuler, with_method};
use crate::schedule::emission::emit_particles;
use crate::schedule::plan::{Passes, StepPlan};
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{PhysicsBody, Quarantined};
use crate::state::coupling::Grouped;
use crate::state::emitter::Dormant;
use crate::state::forces::{Forces, PushQueue, PushedBodies};
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::state::static_bodies::Static;
use crate::tick::integrate::{
    Unmarked, integrate, integrate_acceleration, integrate_in_one_pass, integrate_velocity,
};
use crate::tick::quarantine::{Quarantine, quarantine_bodies};

/// The schedule of one tick.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Step;

/// The sets of a tick, in the order in which they run. Order your own systems by them in a schedule that
/// [`Stepper::install`](crate::Stepper::install) has put the physics into.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StepSystems {
    /// Applies queued pushes: they become the [`Force`](crate::Force) of their bodies. Order a system that adds forces
    /// before [`StepSystems::Integrate`].
    ApplyForces,
    /// Integrates the tick: carries out requests, emits particles, and brings velocities and positions to its end.
    Integrate,
    /// Clears the forces of the tick. Order a system that reads them before this set.
    ClearForces,
    /// Quarantines bodies that would have turned non-finite or left the range, and advances the clock.
    Quarantine,
}

/// Compiles the schedule of one tick. Two systems that access the same data in no stated order are an error when it is
/// initialized. It runs on one thread: a multi-threaded executor costs more per system than a thousand bodies do.
#[must_use]
pub fn step_schedule(plan: &StepPlan) -> Schedule {
    schedule_of(step_systems(plan))
}

/// Compiles the schedule of what [`StepSystems::Integrate`] does.
pub(crate) fn inner_schedule(plan: &StepPlan) -> Schedule {
    let births = plan.emits.then(|| emit_particles.into_configs());
    schedule_of(births.into_iter().chain(integration(plan)))
}

fn schedule_of(systems: impl IntoIterator<Item = ScheduleConfigs<ScheduleSystem>>) -> Schedule {
    let mut schedule = Schedule::new(Step);
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.set_build_settings(ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..Default::default()
    });
    let mut systems = systems.into_iter();
    if let Some(first) = systems.next() {
        schedule.add_systems(systems.fold(first, |before, system| (before, system).chain()));
    }
    schedule
}

/// The systems of one tick, in the order in which they run.
#[must_use]
pub fn step_systems(plan: &StepPlan) -> Vec<ScheduleConfigs<ScheduleSystem>> {
    let mut systems: Vec<_> = plan.emits.then(|| emit_particles.into_configs()).into_iter().collect();
    systems.push(apply_forces.into_configs());
    systems.extend(integration(plan));
    systems.extend([clear_forces.into_configs(), quarantine_bodies.into_configs()]);
    systems
}

/// The systems that change velocities and positions.
fn integration(plan: &StepPlan) -> Vec<ScheduleConfigs<ScheduleSystem>> {
    let mut systems = Vec::new();
    // Groups first: the single bodies that they hang on are then still where the tick began.
    for method in &plan.groups {
        match method {
            None => with_method!(plan.method, M => systems.extend(group_systems::<M, Unmarked>())),
            Some(method) => with_method!(*method, M => systems.extend(group_systems::<M, With<M>>())),
        }
    }
    if !plan.grouped_only {
        systems.extend(with_method!(plan.method, M => remember::<M, Unmarked>(plan)));
        match (plan.passes, plan.method) {
            (Passes::Two, Method::SemiImplicitEuler) => {
                systems.extend([integrate_acceleration.into_configs(), integrate_velocity.into_configs()]);
            }
            (Passes::Two, Method::ExplicitEuler) => {
                systems.extend([integrate_velocity.into_configs(), integrate_acceleration.into_configs()]);
            }
            (Passes::One, Method::SemiImplicitEuler) => {
                systems.push(integrate_in_one_pass::<SemiImplicitEuler>.into_configs());
            }
            (Passes::One, Method::ExplicitEuler) => {
                systems.push(integrate_in_one_pass::<ExplicitEuler>.into_configs());
            }
            (_, method) => systems.push(with_method!(method, M => integrate::<M, Unmarked>.into_configs())),
        }
    }
    for method in &plan.own {
        systems.extend(with_method!(*method, M => remember::<M, With<M>>(plan)));
        systems.push(with_method!(*method, M => integrate::<M, With<M>>.into_configs()));
    }
    systems
}

/// The systems of the groups of one method. Added members get their method state first; a group caches their
/// accelerations itself.
fn group_systems<M: Integrator, Filter: ArchetypeFilter + 'static>()
-> impl Iterator<Item = ScheduleConfigs<ScheduleSystem>> {
    // In a `const`, so that the system is compiled for the methods that need it and no others.
    let remember = if const { matches!(M::STATE, MethodState::LastStep) } {
        Some(remember_steps::<(Filter, With<Grouped>)>.into_configs())
    } else {
        None
    };
    remember.into_iter().chain([integrate_groups::<M, Filter>.into_configs()])
}

/// The system that gives added bodies the method state of `M`.
fn remember<M: Integrator, Filter: ArchetypeFilter + 'static>(
    plan: &StepPlan,
) -> Option<ScheduleConfigs<ScheduleSystem>> {
    if const { matches!(M::STATE, MethodState::LastStep) } {
        Some(remember_steps::<(Filter, Without<Grouped>)>.into_configs())
    } else if const { matches!(M::STATE, MethodState::LastAcceleration) } {
        Some(match plan.caches_accelerations {
            true => remember_accelerations::<(Filter, Without<Grouped>)>.into_configs(),
            false => remember_accelerations::<(Filter, With<OwnLaws>, Without<Grouped>)>.into_configs(),
        })
    } else {
        None
    }
}

/// Bodies that are integrated.
pub(crate) type Moving = (Without<Quarantined>, Without<Static>, Without<Dormant>);

/// Gives bodies that are new to position Verlet their [`LastStep`], which starts them with the Taylor value.
fn remember_steps<Filter: QueryFilter>(
    bodies: Query<Entity, (Filter, With<PhysicsBody>, Without<LastStep>, Moving)>,
    mut commands: Commands,
) {
    bodies.iter().for_each(|body| {
        commands.entity(body).insert(LastStep::default());
    });
}

/// Gives bodies their [`LastAcceleration`], the cache of an acceleration that the next step starts with.
fn remember_accelerations<Filter: QueryFilter>(
    bodies: Query<Entity, (Filter, With<PhysicsBody>, Without<LastAcceleration>, Moving)>,
    mut commands: Commands,
) {
    bodies.iter().for_each(|body| {
        commands.entity(body).insert(LastAcceleration::default());
    });
}

/// Inserts the resources that the systems of a tick need. [`Gravity`](crate::Gravity) and the other effects are for you
/// to add.
pub fn insert_step_resources(world: &mut World, step: TimeStep) {
    world.insert_resource(step);
    world.init_resource::<StepClock>();
    world.init_resource::<Evaluations>();
    world.init_resource::<PushQueue>();
    world.init_resource::<PushedBodies>();
    world.init_resource::<Quarantine>();
    world.init_resource::<Epoch>();
    world.init_resource::<TickRecords>();
}

/// Turns queued pushes into the forces of this tick.
pub fn apply_forces(mut queue: ResMut<PushQueue>, mut forces: Forces) {
    for push in queue.bypass_change_detection().take() {
        forces.add(push.body, push.newtons);
    }
}

/// Clears the forces of this tick. A push that is to last is added again in the next one.
pub fn clear_forces(mut forces: Forces) {
    forces.clear();
}
