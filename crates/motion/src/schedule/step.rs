//! The schedule of a tick.

use bevy_ecs::archetype::Archetype;
use bevy_ecs::prelude::*;
use bevy_ecs::query::{ArchetypeFilter, QueryFilter};
use bevy_ecs::schedule::{
    LogLevel, ScheduleBuildSettings, ScheduleConfigs, ScheduleLabel, SingleThreadedExecutor,
};
use bevy_ecs::system::ScheduleSystem;

use crate::groups::{Groups, integrate_groups, update_groups};
use crate::kernels::evaluations::Evaluations;
use crate::kernels::record::TickRecords;
use crate::laws::damping::Damping;
use crate::laws::epoch::Epoch;
use crate::laws::own::OwnLaws;
use crate::laws::{Declared, Drag, MutualGravity};
use crate::methods::markers::OwnMethod;
use crate::methods::table::Method;
use crate::methods::{ExplicitEuler, Integrator, Memory, SemiImplicitEuler, with_method};
use crate::schedule::emission::{self, emit_particles};
use crate::state::archetypes::{contains, may_exist};
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{AxisLocks, PhysicsBody, Quarantined, SpeedLimit};
use crate::state::coupling::Grouped;
use crate::state::emitter::{Dormant, Emitter};
use crate::state::forces::{Forces, PushQueue, PushedBodies};
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::state::range::Range;
use crate::state::rest::Static;
use crate::state::substeps::{OwnSubsteps, Substeps};
use crate::tick::integrate::{
    Unmarked, integrate, integrate_acceleration, integrate_in_one_pass, integrate_velocity,
};
use crate::tick::quarantine::{Quarantine, quarantine_bodies};

/// The schedule of one tick.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Step;

/// The parts of a tick in the order in which they run: places for systems of your own to stand before, between and after, in
/// a schedule that [`Stepper::install`](crate::Stepper::install) has put the physics into.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StepSystems {
    /// Queued pushes become the [`Force`](crate::Force) of their bodies. A system that adds forces stands before
    /// [`StepSystems::Integrate`].
    ApplyForces,
    /// Requests are carried out, particles born, and velocities and positions brought to the end of the tick.
    Integrate,
    /// The forces of the tick are forgotten; until then they can be read.
    ClearForces,
    /// Bodies that would have turned non-finite are frozen, and the clock goes on.
    Quarantine,
}

/// How the two middle systems of a tick are run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Passes {
    /// One after the other, each over all bodies, as the tutorial has it.
    #[default]
    Two,
    /// [`integrate_in_one_pass`]: the same arithmetic, half the memory traffic.
    One,
}

impl Passes {
    /// Bodies from which one pass is taken. It measured faster at every size (bench `motion_step`): 1.25 times
    /// at 100,000 bodies, 1.7 times at a million. Below this number the gain is under a tenth of a
    /// microsecond, and the four systems of the tutorial stay separate to be seen and stepped through.
    pub const CROSSOVER: usize = 256;

    /// What the plan takes for a world of `bodies` bodies.
    #[must_use]
    pub const fn for_bodies(bodies: usize) -> Self {
        if bodies < Self::CROSSOVER { Self::Two } else { Self::One }
    }
}

/// What the schedule of a tick is compiled from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StepPlan {
    /// Method of every body that has none of its own.
    pub method: Method,
    /// How the two Eulers are run.
    pub passes: Passes,
    /// Methods that single bodies are marked with, in the order of the table.
    pub own: Vec<Method>,
    /// Whether all bodies that move by the world's method are in groups.
    pub grouped_only: bool,
    /// Methods of groups; `None` is the world's.
    pub groups: Vec<Option<Method>>,
    /// Whether particles are thrown out, or still fly.
    pub emits: bool,
    /// Whether laws are called for every body, none of which looks at velocities: accelerations are then kept
    /// by the methods that can use them once more.
    pub keeps_accelerations: bool,
}

impl StepPlan {
    /// The plan for `world` as it is; groups and pools of particles are made ready for it.
    #[must_use]
    pub fn of(world: &mut World, method: Method) -> Self {
        let Demands { looks_at_state, keeps_accelerations, bounded, substeps, .. } = Demands::of(world);
        let emits = emission::prepare(world);
        update_groups(world, true);
        let bodies = world.query::<&PhysicsBody>().iter(world).len();
        let world = &*world;
        let marked = |grouped: bool| {
            Method::ALL
                .into_iter()
                .filter(move |method| with_method!(*method, M => is_marked::<M>(world, grouped)))
        };
        let own: Vec<_> = marked(false).collect();
        let of_world = has_bodies(world, true, |kind| !contains::<OwnMethod>(world, kind));
        let groups: Vec<_> = of_world.then_some(None).into_iter().chain(marked(true).map(Some)).collect();
        // Where nothing acts between bodies the systems of single ones stand, be there bodies or not.
        let is_free = |kind: &Archetype| !contains::<OwnMethod>(world, kind);
        let grouped_only = !groups.is_empty() && !has_bodies(world, false, is_free);
        let asks = may_exist::<OwnLaws>(world) || may_exist::<OwnSubsteps>(world);
        // The kick alone does not know whether a speed limit is before it or after it.
        let restrained =
            |kind: &Archetype| contains::<SpeedLimit>(world, kind) && contains::<AxisLocks>(world, kind);
        let moves_first = method == Method::ExplicitEuler && world.archetypes().iter().any(restrained);
        let apart = !looks_at_state && !asks && !bounded && !moves_first && substeps == 1;
        let passes = if apart { Passes::for_bodies(bodies) } else { Passes::One };
        Self { method, passes, own, grouped_only, groups, emits, keeps_accelerations }
    }
}

/// What decides how bodies are integrated beside what they are: it is looked at before every tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Demands {
    /// Whether a law looks at positions or velocities.
    looks_at_state: bool,
    keeps_accelerations: bool,
    /// Of a range only the end of a tick is asked, which neither half knows to be one.
    bounded: bool,
    substeps: u32,
    attracts: bool,
    /// Each has a pool that is made ready when the schedule is compiled.
    emitters: u32,
}

impl Demands {
    pub fn of(world: &World) -> Self {
        let declared = Declared::of(world);
        let mut called = declared.called().peekable();
        let calls = called.peek().is_some();
        Self {
            looks_at_state: declared.all().next().is_some(),
            keeps_accelerations: calls && called.all(|law| !law.depends_on_velocity()) && !drags(world),
            bounded: world.contains_resource::<Range>(),
            substeps: Substeps::parts(world.get_resource()),
            attracts: world.contains_resource::<MutualGravity>(),
            emitters: world.components().component_id::<Emitter>().map_or(0, |emitter| {
                let kinds = world.archetypes().iter().filter(|kind| kind.contains(emitter));
                kinds.map(Archetype::len).sum()
            }),
        }
    }
}

/// Linear drag or exact damping.
fn drags(world: &World) -> bool {
    world.contains_resource::<Drag>() || world.get_resource::<Damping>().is_some_and(Damping::is_exact)
}

/// Whether there are bodies of such a kind, in groups or not, that a step looks at.
fn has_bodies(world: &World, grouped: bool, such: impl Fn(&Archetype) -> bool) -> bool {
    world.archetypes().iter().any(|kind| {
        !kind.is_empty()
            && contains::<PhysicsBody>(world, kind)
            && contains::<Grouped>(world, kind) == grouped
            && !contains::<Static>(world, kind)
            && such(kind)
    })
}

/// Whether bodies may be marked with that method, in groups or not. What was marked before it came into a group
/// leaves an empty kind behind, which counts as little as the group's own does after it.
fn is_marked<M: Integrator + Component>(world: &World, grouped: bool) -> bool {
    if world.contains_resource::<Groups>() {
        return has_bodies(world, grouped, |kind| contains::<M>(world, kind));
    }
    !grouped && may_exist::<M>(world)
}

/// Compiles the schedule of one tick. Two systems that touch the same data without a stated order are an error
/// when it is initialized, and it runs on one thread: a multi-threaded executor costs more per system than a
/// thousand bodies do.
#[must_use]
pub fn step_schedule(plan: &StepPlan) -> Schedule {
    schedule_of(step_systems(plan))
}

/// The same for what [`StepSystems::Integrate`] has in it.
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

/// The systems of one tick in the order in which they run, for a schedule that has others between them.
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
    // Groups first: what they hang on is then where it was when the tick began.
    for method in &plan.groups {
        match method {
            None => with_method!(plan.method, M => {
                systems.extend(remember_in_groups::<M, Unmarked>());
                systems.push(integrate_groups::<M, Unmarked>.into_configs());
            }),
            Some(method) => with_method!(*method, M => {
                systems.extend(remember_in_groups::<M, With<M>>());
                systems.push(integrate_groups::<M, With<M>>.into_configs());
            }),
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

/// The system that gives new members of groups what `M` keeps of them; an acceleration is kept by the group.
fn remember_in_groups<M: Integrator, Who: ArchetypeFilter + 'static>()
-> Option<ScheduleConfigs<ScheduleSystem>> {
    (M::MEMORY == Memory::LastStep).then(|| remember_steps::<(Who, With<Grouped>)>.into_configs())
}

/// The system that gives new bodies what `M` keeps of them.
fn remember<M: Integrator, Who: ArchetypeFilter + 'static>(
    plan: &StepPlan,
) -> Option<ScheduleConfigs<ScheduleSystem>> {
    match M::MEMORY {
        Memory::None => None,
        Memory::LastStep => Some(remember_steps::<(Who, Without<Grouped>)>.into_configs()),
        Memory::LastAcceleration if plan.keeps_accelerations => {
            Some(remember_accelerations::<(Who, Without<Grouped>)>.into_configs())
        }
        Memory::LastAcceleration => {
            Some(remember_accelerations::<(Who, With<OwnLaws>, Without<Grouped>)>.into_configs())
        }
    }
}

/// Bodies that are integrated.
type Moving = (Without<Quarantined>, Without<Static>, Without<Dormant>);

/// Lets bodies that are new to position Verlet start with the Taylor value.
pub fn remember_steps<Who: QueryFilter>(
    bodies: Query<Entity, (Who, With<PhysicsBody>, Without<LastStep>, Moving)>,
    mut commands: Commands,
) {
    bodies.iter().for_each(|body| {
        commands.entity(body).insert(LastStep::default());
    });
}

/// Gives bodies room for the acceleration that is the next step's first.
pub fn remember_accelerations<Who: QueryFilter>(
    bodies: Query<Entity, (Who, With<PhysicsBody>, Without<LastAcceleration>, Moving)>,
    mut commands: Commands,
) {
    bodies.iter().for_each(|body| {
        commands.entity(body).insert(LastAcceleration::default());
    });
}

/// Inserts the resources that the systems of a tick need; [`Gravity`](crate::Gravity) and the other effects are
/// the scene's to add.
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

/// Forgets the forces of this tick; a push that is to last is added again in the next one.
pub fn clear_forces(mut forces: Forces) {
    forces.clear();
}
