//! The plan of a tick: its systems, and the conditions that decide about them.

use bevy_ecs::archetype::Archetype;
use bevy_ecs::prelude::*;

use crate::groups::{GroupKernel, Groups, update_groups};
use crate::laws::damping::Damping;
use crate::laws::own::OwnLaws;
use crate::laws::{MutualGravity, PrescribedMotion, RidingWells, SharedLaws, riding_well};
use crate::methods::markers::{OwnMethod, is_marked};
use crate::methods::table::Method;
use crate::methods::{Integrator, with_method};
use crate::schedule::backend::ParticleBackend;
use crate::schedule::emission;
use crate::state::archetypes::{contains, may_exist};
use crate::state::components::{AxisLocks, PhysicsBody, SpeedLimit};
use crate::state::coupling::Grouped;
use crate::state::emitter::EmittersChanged;
use crate::state::range::Range;
use crate::state::static_bodies::Static;
use crate::state::substeps::{OwnSubsteps, Substeps};

/// How the two middle systems of a tick are run: as two passes over the bodies or as one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum Passes {
    /// One system after the other, each over all bodies, as the tutorial has it.
    #[default]
    Two,
    /// `integrate_in_one_pass`: the same arithmetic, half the memory traffic.
    One,
}

/// The number of bodies from which one pass is taken. One pass is faster at every size (bench `motion_step`): 1.25
/// times at 100,000 bodies, 1.7 times at a million. Below this number it saves less than 0.1 µs, and the four
/// systems of the tutorial stay separate to be seen and stepped through.
const CROSSOVER: usize = 256;

/// A method of another crate, which is not in the table.
#[derive(Clone, Copy, Debug)]
pub struct OutsideMethod {
    name: &'static str,
    kernel: GroupKernel,
}

impl OutsideMethod {
    pub(crate) fn of<M: Integrator>() -> Self {
        const {
            let row = M::METHOD.traits();
            assert!(M::DAMPS_INSIDE == row.damps_inside, "`DAMPS_INSIDE` is that of `METHOD`");
            assert!(M::STATE as u8 == row.state as u8, "`STATE` is that of `METHOD`");
        }
        Self { name: std::any::type_name::<M>(), kernel: GroupKernel::of::<M>() }
    }

    pub(crate) const fn name(self) -> &'static str {
        self.name
    }
}

/// Two methods are the same if their types have the same path.
impl PartialEq for OutsideMethod {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for OutsideMethod {}

/// The plan of a tick: what its schedule is compiled from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StepPlan {
    /// The method of every body that has none of its own.
    pub method: Method,
    /// How the two Euler methods are run.
    pub passes: Passes,
    /// The methods that single bodies are marked with, in the order of the table.
    pub own: Vec<Method>,
    /// Whether all bodies of the world's method are in groups.
    pub grouped_only: bool,
    /// The methods of groups; `None` is the world's.
    pub groups: Vec<Option<Method>>,
    /// Whether there are emitters, or particles that still live.
    pub emits: bool,
    /// Whether a [`ParticleBackend`] keeps particles.
    pub backend: bool,
    /// Whether wells ride on bodies.
    pub carries_wells: bool,
    /// Whether bodies follow a prescribed motion.
    pub follows_motion: bool,
    /// Whether laws are called for every body and none of them depends on velocity: methods that can use an acceleration
    /// twice then cache it.
    pub caches_accelerations: bool,
    /// A method of another crate in place of [`StepPlan::method`].
    pub outside: Option<OutsideMethod>,
}

impl StepPlan {
    /// The kernel of the bodies with this method of their own, or of those that use the world's.
    pub(crate) fn kernel(&self, own: Option<Method>) -> GroupKernel {
        match (own, self.outside) {
            (None, Some(outside)) => outside.kernel,
            _ => with_method!(own.unwrap_or(self.method), M => const { GroupKernel::of::<M>() }),
        }
    }

    /// The name of a system of these bodies: `integrate<RungeKutta4, Without<OwnMethod>>`.
    pub(crate) fn name(&self, system: &str, own: Option<Method>) -> String {
        let bodies = own.map_or("Without<OwnMethod>".to_owned(), |own| format!("With<{own:?}>"));
        match (own, self.outside) {
            (None, Some(OutsideMethod { name, .. })) => format!("{system}<{name}, {bodies}>"),
            _ => format!("{system}<{:?}, {bodies}>", own.unwrap_or(self.method)),
        }
    }

    /// The plan for `world` as it is. Compiles its groups and prepares its pools of particles.
    #[must_use]
    pub fn of(world: &mut World, method: Method) -> Self {
        Self::with(world, method, None)
    }

    /// [`StepPlan::of`] with `outside` in place of `method`, if there is one.
    pub(crate) fn with(world: &mut World, method: Method, outside: Option<OutsideMethod>) -> Self {
        let inputs = PlanInputs::of(world);
        let emits = emission::prepare(world);
        let backend = ParticleBackend::with(world, |backend, world| (backend.prepare)(world));
        let carries_wells = riding_well::prepare(world);
        update_groups(world, true);
        let bodies = world.query::<&PhysicsBody>().iter(world).len();
        let world = &*world;
        let marked = |grouped: bool| {
            Method::ALL.into_iter().filter(move |method| is_in_use(world, *method, grouped))
        };
        let own: Vec<_> = marked(false).collect();
        let is_free = |kind: &Archetype| !contains::<OwnMethod>(world, kind);
        let of_world = has_bodies(world, true, is_free);
        let groups: Vec<_> =
            of_world.then_some(None).into_iter().chain(marked(true).map(Some)).collect();
        // Without groups, single bodies have their systems even before the first of them is spawned.
        let grouped_only = !groups.is_empty() && !has_bodies(world, false, is_free);
        let options = may_exist::<OwnLaws>(world) || may_exist::<OwnSubsteps>(world);
        // A kick by itself cannot tell whether a speed limit comes before it or after it.
        let limited = |kind: &Archetype| {
            contains::<SpeedLimit>(world, kind) && contains::<AxisLocks>(world, kind)
        };
        let moves_first = method == Method::ExplicitEuler && world.archetypes().iter().any(limited);
        let separable = outside.is_none()
            && !inputs.laws
            && !options
            && !inputs.range
            && !moves_first
            && inputs.substeps == 1;
        let passes = if separable && bodies < CROSSOVER { Passes::Two } else { Passes::One };
        let caches_accelerations = inputs.caches_accelerations;
        Self {
            method,
            passes,
            own,
            grouped_only,
            groups,
            emits,
            backend,
            carries_wells,
            follows_motion: may_exist::<PrescribedMotion>(world),
            caches_accelerations,
            outside,
        }
    }
}

/// The inputs of a plan that are cheap to compare before every tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PlanInputs {
    /// The number of archetypes: a new one may have a method of its own.
    archetypes: usize,
    /// Whether there are laws besides gravity.
    laws: bool,
    caches_accelerations: bool,
    /// Whether there is a range, which is checked at the end of a tick: neither half of two passes knows that end.
    range: bool,
    substeps: u32,
    mutual_gravity: bool,
    carries_wells: bool,
    /// Whether emitters came or went: the pool of each is prepared with the plan.
    emitters_changed: bool,
}

impl PlanInputs {
    pub fn of(world: &World) -> Self {
        let laws = SharedLaws::of(world);
        let mut called = laws.called().peekable();
        let calls = called.peek().is_some();
        Self {
            archetypes: world.archetypes().len(),
            laws: laws.all().next().is_some(),
            caches_accelerations: calls
                && called.all(|law| !law.depends_on_velocity())
                && !laws.resources().any(|(_, law)| law.depends_on_velocity())
                && !world.get_resource::<Damping>().is_some_and(Damping::is_exact),
            range: world.contains_resource::<Range>(),
            substeps: Substeps::count(world.get_resource()),
            mutual_gravity: world.contains_resource::<MutualGravity>(),
            carries_wells: world.contains_resource::<RidingWells>(),
            emitters_changed: world
                .get_resource::<EmittersChanged>()
                .is_some_and(|changed| changed.0),
        }
    }
}

/// Whether a step integrates bodies of such a kind, in groups or not.
fn has_bodies(world: &World, grouped: bool, such: impl Fn(&Archetype) -> bool) -> bool {
    world.archetypes().iter().any(|kind| {
        !kind.is_empty()
            && contains::<PhysicsBody>(world, kind)
            && contains::<Grouped>(world, kind) == grouped
            && !contains::<Static>(world, kind)
            && !contains::<PrescribedMotion>(world, kind)
            && such(kind)
    })
}

/// Whether bodies may be marked with that method, in groups or not. In a world with groups only archetypes with bodies count:
/// an archetype is left empty when its bodies join a group or leave it.
fn is_in_use(world: &World, method: Method, grouped: bool) -> bool {
    if world.contains_resource::<Groups>() {
        return has_bodies(world, grouped, |kind| is_marked(world, kind, method));
    }
    !grouped && world.archetypes().iter().any(|kind| is_marked(world, kind, method))
}
