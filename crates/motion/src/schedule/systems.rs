//! The systems of a tick, their sets, and the schedule that they are compiled to.

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{
    LogLevel, ScheduleBuildSettings, ScheduleConfigs, ScheduleLabel, SingleThreadedExecutor,
};
use bevy_ecs::system::{ParamBuilder, ScheduleSystem, SystemState};

use crate::groups::integrate_groups;
use crate::kernels::evaluations::Evaluations;
use crate::kernels::record::TickRecords;
use crate::laws::PrescribedMotion;
use crate::laws::epoch::Epoch;
use crate::laws::own::OwnLaws;
use crate::laws::riding_well::carry_wells;
use crate::methods::table::Method;
use crate::methods::{ExplicitEuler, MethodStateKind, SemiImplicitEuler};
use crate::schedule::backend::ParticleBackend;
use crate::schedule::emission::emit_particles;
use crate::schedule::plan::{Passes, StepPlan};
use crate::schedule::requests::Requests;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{PhysicsBody, Quarantined};
use crate::state::coupling::Grouped;
use crate::state::emitter::Dormant;
use crate::state::forces::{Forces, PushQueue, PushedBodies};
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::state::static_bodies::Static;
use crate::tick::body_filter::BodyFilter;
use crate::tick::columns::register_observed;
use crate::tick::follow_motion::follow_motion;
use crate::tick::integrate::{
    integrate, integrate_acceleration, integrate_in_one_pass, integrate_velocity,
};
use crate::tick::quarantine::{Quarantine, quarantine_bodies};

/// The schedule of one tick.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Step;

/// The sets of a tick, in the order in which they run. Order your own systems by them in a schedule that
/// [`Stepper::install`](crate::Stepper::install) has put the physics into.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum StepSystems {
    /// All of the sets below. A run condition on it pauses the physics, with its clock, emitters and engines; pushes wait.
    /// While a condition on [`StepSystems::Integrate`] alone is false, forces are cleared without having moved anything.
    Tick,
    /// Applies queued pushes: they become the [`Force`](crate::Force) of their bodies. Order a system that adds forces
    /// before [`StepSystems::Integrate`]; one that is added later acts in the next tick.
    ApplyForces,
    /// Integrates the tick: carries out requests, emits particles, and brings velocities and positions to its end.
    Integrate,
    /// Clears the forces of the tick. Order a system that reads them before this set.
    ClearForces,
    /// Quarantines bodies that would have turned non-finite or left the range, and advances the clock.
    Quarantine,
}

/// Compiles the schedule of one tick of `world`. Two systems that access the same data in no stated order are an error when it is
/// initialized. It runs on one thread: a multi-threaded executor costs more per system than a thousand bodies do.
#[must_use]
pub fn step_schedule(world: &mut World, plan: &StepPlan) -> Schedule {
    schedule_of(step_systems(world, plan))
}

/// Compiles the schedule that [`StepSystems::Integrate`] runs.
pub(crate) fn inner_schedule(world: &mut World, plan: &StepPlan) -> Schedule {
    schedule_of(births(world, plan).into_iter().chain(integration(world, plan)))
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

/// The systems of one tick of `world`, in the order in which they run.
#[must_use]
pub fn step_systems(world: &mut World, plan: &StepPlan) -> Vec<ScheduleConfigs<ScheduleSystem>> {
    let mut systems = births(world, plan);
    systems.push(apply_forces.into_configs());
    systems.extend(integration(world, plan));
    systems.extend([clear_forces.into_configs(), quarantine_bodies.into_configs()]);
    systems
}

/// The systems of births and deaths.
fn births(world: &World, plan: &StepPlan) -> Vec<ScheduleConfigs<ScheduleSystem>> {
    let particles = plan.emits.then(|| emit_particles.into_configs());
    let backend = world.get_resource::<ParticleBackend>().filter(|_| plan.backend);
    particles.into_iter().chain(backend.map(|backend| (backend.system)())).collect()
}

/// The systems that change velocities and positions.
fn integration(world: &mut World, plan: &StepPlan) -> Vec<ScheduleConfigs<ScheduleSystem>> {
    let mut systems: Vec<_> =
        plan.carries_wells.then(|| carry_wells.into_configs()).into_iter().collect();
    // Groups first, while the single bodies that anchor them are still at the start of the tick.
    for own in &plan.groups {
        let (kernel, which) = (plan.kernel(*own), BodyFilter::of_method(world, *own));
        // A group caches the accelerations of its members itself.
        if kernel.single.traits.state == MethodStateKind::LastStep {
            let members = which.clone().with::<Grouped>(world);
            systems.push(remember_steps(world, &members));
        }
        let name = plan.name("integrate_groups", *own);
        systems.push(integrate_groups(world, kernel, &which, name).into_configs());
    }
    if !plan.grouped_only {
        systems.extend(remember(world, plan, None));
        match (plan.passes, plan.method) {
            _ if plan.outside.is_some() => systems.push(integrate_method(world, plan, None)),
            (Passes::Two, Method::SemiImplicitEuler) => {
                systems.extend([
                    integrate_acceleration.into_configs(),
                    integrate_velocity.into_configs(),
                ]);
            }
            (Passes::Two, Method::ExplicitEuler) => {
                systems.extend([
                    integrate_velocity.into_configs(),
                    integrate_acceleration.into_configs(),
                ]);
            }
            (Passes::One, Method::SemiImplicitEuler) => {
                systems.push(integrate_in_one_pass::<SemiImplicitEuler>.into_configs());
            }
            (Passes::One, Method::ExplicitEuler) => {
                systems.push(integrate_in_one_pass::<ExplicitEuler>.into_configs());
            }
            _ => systems.push(integrate_method(world, plan, None)),
        }
    }
    for method in &plan.own {
        systems.extend(remember(world, plan, Some(*method)));
        systems.push(integrate_method(world, plan, Some(*method)));
    }
    // Last, because groups have their anchors at the start of the tick.
    systems.extend(plan.follows_motion.then(|| follow_motion.into_configs()));
    systems
}

/// The system that integrates the single bodies with the method `own`, or with the world's.
fn integrate_method(
    world: &mut World,
    plan: &StepPlan,
    own: Option<Method>,
) -> ScheduleConfigs<ScheduleSystem> {
    let which = BodyFilter::of_method(world, own);
    integrate(world, plan.kernel(own).single, &which, plan.name("integrate", own)).into_configs()
}

/// The system that gives added single bodies the state of their method, which is `own` or the world's.
fn remember(
    world: &mut World,
    plan: &StepPlan,
    own: Option<Method>,
) -> Option<ScheduleConfigs<ScheduleSystem>> {
    let which = BodyFilter::of_method(world, own).without::<Grouped>(world);
    match plan.kernel(own).single.traits.state {
        MethodStateKind::None => None,
        MethodStateKind::LastStep => Some(remember_steps(world, &which)),
        MethodStateKind::LastAcceleration if plan.caches_accelerations => {
            Some(remember_accelerations(world, &which))
        }
        MethodStateKind::LastAcceleration => {
            let with_laws = which.with::<OwnLaws>(world);
            Some(remember_accelerations(world, &with_laws))
        }
    }
}

/// Bodies that are integrated.
pub(crate) type Moving =
    (Without<Quarantined>, Without<Static>, Without<Dormant>, Without<PrescribedMotion>);

/// Gives bodies that are new to position Verlet their [`LastStep`], which starts them with the Taylor value.
fn remember_steps(world: &mut World, which: &BodyFilter) -> ScheduleConfigs<ScheduleSystem> {
    remember_state::<LastStep>(world, which, "remember_steps")
}

/// Gives bodies their [`LastAcceleration`], the cache of an acceleration that the next step starts with.
fn remember_accelerations(
    world: &mut World,
    which: &BodyFilter,
) -> ScheduleConfigs<ScheduleSystem> {
    remember_state::<LastAcceleration>(world, which, "remember_accelerations")
}

fn remember_state<State: Component + Default>(
    world: &mut World,
    which: &BodyFilter,
    name: &'static str,
) -> ScheduleConfigs<ScheduleSystem> {
    type Bodies<'w, 's, State> = Query<'w, 's, Entity, (With<PhysicsBody>, Without<State>, Moving)>;
    let state: SystemState<(Bodies<State>, Commands)> =
        (which.query(), ParamBuilder).build_state(world);
    let system = state.build_system(|added, mut commands| {
        added.iter().for_each(|body| {
            commands.entity(body).insert(State::default());
        });
    });
    system.with_name(name).into_configs()
}

/// Inserts the resources that the systems of a tick need. [`Gravity`](crate::Gravity) and the other effects are for you
/// to add.
///
/// # Panics
/// If `step` is negative or not finite.
pub fn insert_step_resources(world: &mut World, step: TimeStep) {
    step.check();
    register_observed(world);
    world.insert_resource(step);
    world.init_resource::<StepClock>();
    world.init_resource::<Evaluations>();
    world.init_resource::<PushQueue>();
    world.init_resource::<PushedBodies>();
    world.init_resource::<Quarantine>();
    world.init_resource::<Epoch>();
    world.init_resource::<TickRecords>();
}

/// Checks that the resources of a tick are in `world`. Ticks of an optimized build do without: there Bevy names the system that
/// misses one.
///
/// # Panics
/// If one was removed; the message names it.
pub(crate) fn check_step_resources(world: &World) {
    fn check<R: Resource>(world: &World) {
        assert!(world.contains_resource::<R>(), "{}", removed::<R>());
    }
    check::<TimeStep>(world);
    check::<StepClock>(world);
    check::<Evaluations>(world);
    check::<PushQueue>(world);
    check::<Quarantine>(world);
    check::<Requests>(world);
}

fn removed<R>() -> String {
    let path = std::any::type_name::<R>();
    let name = path.rsplit("::").next().unwrap_or(path);
    format!(
        "the resource `{name}` was removed from the world; insert it again, or make a new `Stepper`, which does"
    )
}

/// Turns queued pushes into the forces of this tick.
pub fn apply_forces(queue: Option<ResMut<PushQueue>>, mut forces: Forces) {
    let mut queue = queue.unwrap_or_else(|| panic!("{}", removed::<PushQueue>()));
    for push in queue.bypass_change_detection().take() {
        forces.add(push.body, push.newtons);
    }
}

/// Clears the forces of this tick, and opens the next one to the forces that were added too late for this one. To push a
/// body for longer, add the force in every tick.
pub fn clear_forces(mut forces: Forces) {
    forces.clear();
}
