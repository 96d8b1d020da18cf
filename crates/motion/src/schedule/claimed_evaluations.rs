//! Evaluations of bodies whose kernels call no law.
//!
//! A kernel counts the laws that it calls. It calls none for bodies on which only constant accelerations and linear
//! drag act: those are summed up before the tick. Such a body takes as many evaluations as its method claims. Their
//! number is cached, because it takes a walk over all bodies.

use bevy_ecs::archetype::{Archetype, ArchetypeEntity, ArchetypeId};
use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use crate::kernels::evaluations::Evaluations;
use crate::laws::damping::{Damping, DampingRate};
use crate::laws::own::OwnLaws;
use crate::laws::{Affine, Declared, Gravity};
use crate::methods::markers::is_marked;
use crate::methods::table::Method;
use crate::schedule::plan::StepPlan;
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{AxisLocks, GravityOff, PhysicsBody, Quarantined, SpeedLimit};
use crate::state::coupling::Grouped;
use crate::state::emitter::{Dormant, Particle};
use crate::state::static_bodies::Static;
use crate::state::substeps::OwnSubsteps;
use crate::tick::environment::Environment;

/// Evaluations per tick of the bodies whose kernels call no law.
#[derive(Debug, Default)]
pub(crate) struct ClaimedEvaluations {
    /// What they were computed for; `None` if they are to be computed again.
    conditions: Option<Conditions>,
    accelerations: u64,
    /// Those of bodies that gravity acts on.
    with_gravity: u64,
    /// Archetypes of particles, with evaluations per particle and whether gravity acts on it.
    particles: Vec<(ArchetypeId, u64, bool)>,
}

/// What the number of evaluations depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Conditions {
    /// A hash of the number of entities of each archetype, particles aside: emission changes theirs in every tick.
    entities: u64,
    damping: Option<Damping>,
    has_linear_drag: bool,
    calls_laws: bool,
}

impl Conditions {
    fn of(world: &World, plan: &StepPlan) -> Self {
        let particle = world.components().component_id::<Particle>().filter(|_| plan.emits);
        let hash = |hash: u64, kind: &Archetype| {
            let is_particle = particle.is_some_and(|particle| kind.contains(particle));
            let entities = if is_particle { 0 } else { u64::from(kind.len()) };
            hash.wrapping_mul(0x100_0000_01b3) ^ entities
        };
        let laws = Declared::of(world);
        Self {
            // From 1 on, so that a new archetype changes it even while it is empty.
            entities: world.archetypes().iter().fold(1, hash),
            damping: world.get_resource().copied(),
            has_linear_drag: Affine::sum(laws.all()).rate != 0.0,
            calls_laws: laws.called().next().is_some(),
        }
    }
}

impl ClaimedEvaluations {
    /// Counts the evaluations of the coming tick, those of particles aside.
    pub fn count(&mut self, world: &mut World, plan: &StepPlan) {
        self.update(world, plan);
        note(world, self.accelerations, self.with_gravity);
    }

    /// Counts the evaluations of the particles that lived in the tick that is over, of which some were born in it.
    pub fn count_particles(&mut self, world: &mut World, plan: &StepPlan) {
        self.update(world, plan);
        let (mut accelerations, mut with_gravity) = (0, 0);
        for (kind, per_particle, gravity) in &self.particles {
            let living = world.archetypes().get(*kind).map_or(0, Archetype::len);
            let evaluations = u64::from(living) * per_particle;
            accelerations += evaluations;
            with_gravity += if *gravity { evaluations } else { 0 };
        }
        note(world, accelerations, with_gravity);
    }

    /// Whether there may be particles among the bodies.
    pub const fn has_particles(&self) -> bool {
        !self.particles.is_empty()
    }

    fn update(&mut self, world: &mut World, plan: &StepPlan) {
        let conditions = Conditions::of(world, plan);
        if self.conditions != Some(conditions) {
            *self = Self { conditions: Some(conditions), ..Self::default() };
            if conditions.calls_laws {
                return;
            }
            self.add_bodies(world, plan.method);
        }
    }

    /// Adds the bodies whose kernels call no law. One query for all methods: each query is a good deal of code.
    fn add_bodies(&mut self, world: &mut World, method: Method) {
        type Plain = (
            Without<Quarantined>,
            Without<Grouped>,
            Without<Static>,
            Without<Dormant>,
            Without<DampingRate>,
            Without<SpeedLimit>,
            Without<AxisLocks>,
            Without<OwnLaws>,
            Without<OwnSubsteps>,
        );
        let per_tick = Method::ALL.map(|method| per_tick(world, method));
        let particle = world.register_component::<Particle>();
        let gravity_off = world.register_component::<GravityOff>();
        let mut bodies = world.query_filtered::<&PhysicsBody, Plain>();
        let matched: Vec<_> = bodies.matched_archetypes().collect();
        let world = &*world;
        for kind in matched.into_iter().filter_map(|kind| world.archetypes().get(kind)) {
            let own = Method::ALL.into_iter().find(|own| is_marked(world, kind, *own));
            let per_tick = per_tick[own.unwrap_or(method) as usize];
            let gravity = !kind.contains(gravity_off);
            if kind.contains(particle) {
                self.particles.push((kind.id(), per_tick, gravity));
                continue;
            }
            let bodies = bodies.iter_many(world, kind.entities().iter().map(ArchetypeEntity::id));
            let evaluations =
                per_tick * bodies.flatten().filter(|body| body.inverse_mass > 0.0).count() as u64;
            self.accelerations += evaluations;
            self.with_gravity += if gravity { evaluations } else { 0 };
        }
    }
}

/// Evaluations per tick of a body of `method` whose kernel calls no law; 0 if that kernel counts them itself.
fn per_tick(world: &World, method: Method) -> u64 {
    let (clock, step) = (*world.resource::<StepClock>(), world.resource::<TimeStep>().0);
    let environment = Environment::of(world, clock, step);
    let terms = environment.terms(method.traits(), &[]);
    // Linear drag and damping in one step go to the kernel that counts.
    if terms.drags_and_damps() { 0 } else { terms.evaluations() }
}

/// Counts accelerations under the laws that are summed up before the tick, gravity being among those of some bodies.
fn note(world: &mut World, accelerations: u64, with_gravity: u64) {
    let exact = world.get_resource::<Damping>().is_some_and(Damping::is_exact);
    let laws = Declared::of(world).affine().map(|law| law.name()).chain(exact.then_some("damping"));
    let laws: SmallVec<[_; 8]> = laws.collect();
    let gravity = world.get_resource::<Gravity>().is_some_and(|gravity| gravity.on);
    let mut evaluations = world.resource_mut::<Evaluations>();
    evaluations.count_accelerations(accelerations, laws.into_iter());
    if gravity {
        evaluations.count("gravity", with_gravity);
    }
}
