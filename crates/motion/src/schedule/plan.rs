//! The plan of a tick: what decides which systems it has.

use bevy_ecs::archetype::Archetype;
use bevy_ecs::prelude::*;

use crate::groups::{Groups, update_groups};
use crate::laws::damping::Damping;
use crate::laws::own::OwnLaws;
use crate::laws::{Declared, Drag, MutualGravity};
use crate::methods::markers::OwnMethod;
use crate::methods::table::Method;
use crate::methods::{Integrator, with_method};
use crate::schedule::emission;
use crate::state::archetypes::{contains, may_exist};
use crate::state::components::{AxisLocks, PhysicsBody, SpeedLimit};
use crate::state::coupling::Grouped;
use crate::state::emitter::Emitter;
use crate::state::range::Range;
use crate::state::rest::Static;
use crate::state::substeps::{OwnSubsteps, Substeps};

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
