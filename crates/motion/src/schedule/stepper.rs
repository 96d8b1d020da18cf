//! Carries a world from tick to tick.

mod install;

use bevy_ecs::archetype::{Archetype, ArchetypeId};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryFilter;

use crate::groups::{Groups, is_outdated};
use crate::kernels::evaluations::Evaluations;
use crate::laws::damping::{Damping, DampingRate};
use crate::laws::own::OwnLaws;
use crate::laws::{Affine, Declared, Gravity};
use crate::methods::table::Method;
use crate::methods::{Integrator, with_method};
use crate::schedule::plan::{Demands, Passes, StepPlan};
use crate::schedule::requests::{self, Requests};
use crate::schedule::restart::leave_methods;
use crate::schedule::systems::{inner_schedule, insert_step_resources, step_schedule};
use crate::state::clock::{StepClock, TimeStep};
use crate::state::components::{AxisLocks, GravityOff, PhysicsBody, Quarantined, SpeedLimit};
use crate::state::coupling::{CouplingChanged, Grouped};
use crate::state::emitter::{Dormant, Emissions, Particle};
use crate::state::method_state::LastAcceleration;
use crate::state::rest::{Static, mark_static};
use crate::state::substeps::{OwnSubsteps, Substeps};
use crate::tick::integrate::Unmarked;
use crate::tick::quarantine::Quarantine;
use crate::units::Scalar;

/// The compiled schedule of a world, with what happens around it: requests before a tick, the count after it.
pub struct Stepper {
    plan: StepPlan,
    schedule: Schedule,
    /// How many kinds of entity there were when the plan was made: a new one may have a method of its own.
    archetypes: usize,
    /// How many bodies there were then.
    bodies: usize,
    /// What the world asked for then.
    demands: Demands,
    /// Whether it stands in a schedule of the user's, which has the rest of the tick.
    installed: bool,
    counted: Option<Counted>,
}

/// Evaluations of a tick that are known beforehand: those of bodies that no law is called for.
#[derive(Clone, Debug)]
struct Counted {
    /// What they were counted for.
    world: CountedFor,
    /// Laws that are summed up, gravity aside.
    laws: Vec<&'static str>,
    accelerations: u64,
    with_gravity: u64,
    /// Kinds of entity whose living particles come and go, with evaluations a tick of one body, and whether it
    /// falls.
    particles: Vec<(ArchetypeId, u64, bool)>,
}

/// What the number of evaluations depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CountedFor {
    /// A hash of the number of entities of each archetype.
    entities: u64,
    quarantined: usize,
    damping: Option<Damping>,
    /// The rate of linear drag, 1/s.
    drag: Scalar,
    /// How many laws are called.
    called: usize,
}

impl Stepper {
    /// Prepares `world` for ticks of `step` and compiles the schedule of `method`.
    ///
    /// # Panics
    /// When two systems of the schedule touch the same data without a stated order, which is a fault of this
    /// crate.
    #[must_use]
    pub fn new(world: &mut World, method: Method, step: TimeStep) -> Self {
        insert_step_resources(world, step);
        world.init_resource::<Requests>();
        Self::compile(world, method, false)
    }

    fn compile(world: &mut World, method: Method, installed: bool) -> Self {
        mark_static(world);
        let plan = StepPlan::of(world, method);
        let mut schedule = if installed { inner_schedule(&plan) } else { step_schedule(&plan) };
        schedule.initialize(world).expect("the systems of a tick are totally ordered");
        Self {
            plan,
            schedule,
            archetypes: world.archetypes().len(),
            bodies: bodies(world),
            demands: Demands::of(world),
            installed,
            counted: None,
        }
    }

    /// Compiles the schedule again if the world asks for another one than when it was compiled last. A tick does so by
    /// itself where bodies, laws or effects have come or gone.
    ///
    /// # Panics
    /// As [`Stepper::new`].
    pub fn recompile(&mut self, world: &mut World) {
        mark_static(world);
        self.look_for_newcomers(world);
        let plan = StepPlan::of(world, self.plan.method);
        forget_accelerations(world, &plan);
        (self.archetypes, self.demands) = (world.archetypes().len(), Demands::of(world));
        self.bodies = bodies(world);
        self.counted = None;
        if plan != self.plan {
            *self = Self::compile(world, plan.method, self.installed);
        }
    }

    /// The method of every body that has none of its own.
    #[must_use]
    pub const fn method(&self) -> Method {
        self.plan.method
    }

    /// What the schedule was compiled from.
    #[must_use]
    pub const fn plan(&self) -> &StepPlan {
        &self.plan
    }

    /// How the two middle systems are run, decided by the number of bodies when the schedule was compiled.
    #[must_use]
    pub const fn passes(&self) -> Passes {
        self.plan.passes
    }

    /// Changes the method of every body that has none of its own, between two ticks: what the old one kept is
    /// turned into what the new one starts from.
    ///
    /// # Panics
    /// As [`Stepper::new`].
    pub fn set_method(&mut self, world: &mut World, method: Method) {
        if method == self.plan.method {
            return;
        }
        self.look_for_newcomers(world);
        leave_methods::<Unmarked>(world);
        *self = Self::compile(world, method, self.installed);
    }

    /// Lets groups be made anew where bodies have come or gone: one may be new to mutual gravity, or have held a
    /// spring.
    fn look_for_newcomers(&self, world: &mut World) -> bool {
        let changed = world.contains_resource::<Groups>() && bodies(world) != self.bodies;
        if changed {
            CouplingChanged::set(world);
        }
        changed
    }

    /// Simulates one tick.
    ///
    /// # Panics
    /// As [`Stepper::new`], and for one that was [installed](Stepper::install): its tick is a run of the schedule that it is in.
    pub fn tick(&mut self, world: &mut World) {
        assert!(!self.installed, "run the schedule that the stepper is installed in");
        self.integrate(world);
        if self.finish(world) {
            // The world remembers for others what was removed, and every birth removes a mark.
            world.clear_trackers();
        }
    }

    fn integrate(&mut self, world: &mut World) {
        self.make_ready(world);
        self.count(world);
        self.schedule.run(world);
    }

    /// What a tick does after it; whether there may be particles.
    fn finish(&mut self, world: &mut World) -> bool {
        let emits =
            self.plan.emits || self.counted.as_ref().is_some_and(|counted| !counted.particles.is_empty());
        if emits {
            self.count_particles(world);
            if let Some(mut emissions) = world.get_resource_mut::<Emissions>() {
                emissions.births.clear();
            }
        }
        let TimeStep(step) = *world.resource::<TimeStep>();
        world.resource_mut::<StepClock>().count(step);
        emits
    }

    /// What a tick does before it: requests, and the schedule if the world asks for another one. Doing it twice is
    /// doing it once.
    pub(crate) fn make_ready(&mut self, world: &mut World) {
        self.carry_out_requests(world);
        if self.look_for_newcomers(world)
            || is_outdated(world)
            || world.archetypes().len() != self.archetypes
            || Demands::of(world) != self.demands
            || world.get_resource::<Emissions>().is_some_and(|emissions| emissions.over)
        {
            self.recompile(world);
        }
    }

    /// Carries out what was asked for without simulating: what a tick does first, for a world that is paused.
    pub fn carry_out_requests(&mut self, world: &mut World) {
        if !world.resource::<Requests>().is_empty() {
            self.counted = None;
            if requests::carry_out(world) {
                self.recompile(world);
            }
        }
    }

    /// Names of the systems of a tick in the order in which they run, read from the compiled schedule.
    ///
    /// # Panics
    /// Never: the schedule was initialized when it was compiled.
    #[must_use]
    pub fn systems(&self) -> Vec<String> {
        let systems = self.schedule.systems().expect("initialized when compiled");
        systems.map(|(_, system)| system.name().shortname().to_string()).collect()
    }

    /// Counts the evaluations of the coming tick that no kernel counts: a body that no law is called for takes
    /// as many as its method claims.
    fn count(&mut self, world: &mut World) {
        self.look_what_counts(world);
        let Some(counted) = &self.counted else { return };
        counted.note(world, counted.accelerations, counted.with_gravity);
    }

    /// The same for the particles that lived in the tick that is over, of which some were born in it.
    fn count_particles(&mut self, world: &mut World) {
        if world.archetypes().len() != self.archetypes {
            self.counted = None;
        }
        self.look_what_counts(world);
        let Some(counted) = &self.counted else { return };
        let (mut accelerations, mut with_gravity) = (0, 0);
        for (kind, of_a_tick, falls) in &counted.particles {
            let living = world.archetypes().get(*kind).map_or(0, Archetype::len);
            accelerations += u64::from(living) * of_a_tick;
            with_gravity += if *falls { u64::from(living) * of_a_tick } else { 0 };
        }
        counted.note(world, accelerations, with_gravity);
    }

    fn look_what_counts(&mut self, world: &mut World) {
        // A body that asks for something new goes from one kind to another, and their sum stays.
        let mix = |sum: u64, kind: &Archetype| sum.wrapping_mul(0x100_0000_01b3) ^ u64::from(kind.len());
        // Births and deaths change numbers in every tick, and nothing else.
        let particle = world.components().component_id::<Particle>().filter(|_| self.plan.emits);
        let stays = |kind: &&Archetype| particle.is_none_or(|particle| !kind.contains(particle));
        let declared = Declared::of(world);
        let counted_for = CountedFor {
            entities: world.archetypes().iter().filter(stays).fold(0, mix),
            quarantined: world.resource::<Quarantine>().records().len(),
            damping: world.get_resource().copied(),
            drag: Affine::sum(declared.all()).rate,
            called: declared.called().count(),
        };
        let exact = counted_for.damping.is_some_and(|damping| damping.is_exact());
        let laws = || declared.affine().map(|law| law.name()).chain(exact.then_some("damping"));
        let current =
            |counted: &Counted| counted.world == counted_for && laws().eq(counted.laws.iter().copied());
        if !self.counted.as_ref().is_some_and(current) {
            let mut counted = Counted {
                world: counted_for,
                laws: laws().collect(),
                accelerations: 0,
                with_gravity: 0,
                particles: Vec::new(),
            };
            with_method!(self.plan.method, M => counted.add::<M, Unmarked>(world));
            for method in &self.plan.own {
                with_method!(*method, M => counted.add::<M, With<M>>(world));
            }
            self.counted = Some(counted);
        }
    }
}

fn bodies(world: &World) -> usize {
    let Some(body) = world.components().component_id::<PhysicsBody>() else { return 0 };
    world
        .archetypes()
        .iter()
        .filter(|kind| kind.contains(body))
        .map(Archetype::len)
        .map(|len| len as usize)
        .sum()
}

impl Counted {
    fn note(&self, world: &mut World, accelerations: u64, with_gravity: u64) {
        let gravity = world.get_resource::<Gravity>().is_some_and(|gravity| gravity.on);
        let mut evaluations = world.resource_mut::<Evaluations>();
        evaluations.count_accelerations(accelerations, self.laws.iter().copied());
        if gravity {
            evaluations.count("gravity", with_gravity);
        }
    }

    fn add<M: Integrator, Who: QueryFilter>(&mut self, world: &mut World) {
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
        let CountedFor { damping, called, .. } = self.world;
        let drag = self.world.drag != 0.0;
        // Bodies for which `kernels::integrate` calls laws, or counts as if it did.
        if called > 0 || drag && damping.is_some() && M::DAMPS_INSIDE {
            return;
        }
        let exact = damping.is_some_and(|damping| damping.is_exact() && damping.rate != 0.0);
        let looks_at_velocity = drag || exact && !M::DAMPS_INSIDE;
        let claims = M::METHOD.claims();
        let of_a_step =
            if looks_at_velocity { claims.evaluations_with_velocity_laws } else { claims.evaluations };
        let of_a_tick = u64::from(of_a_step) * u64::from(Substeps::parts(world.get_resource()));
        let mut bodies =
            world.query_filtered::<(&PhysicsBody, Has<GravityOff>), (Who, Plain, Without<Particle>)>();
        for (body, gravity_off) in bodies.iter(world) {
            if body.inverse_mass > 0.0 {
                self.accelerations += of_a_tick;
                self.with_gravity += if gravity_off { 0 } else { of_a_tick };
            }
        }
        let floats = world.register_component::<GravityOff>();
        let particles = world.query_filtered::<&PhysicsBody, (Who, Plain, With<Particle>)>();
        self.particles.extend(particles.matched_archetypes().map(|kind| {
            (kind, of_a_tick, world.archetypes().get(kind).is_some_and(|kind| !kind.contains(floats)))
        }));
    }
}

/// Takes the room for accelerations from bodies that no law is called for any more.
fn forget_accelerations(world: &mut World, plan: &StepPlan) {
    if !plan.keeps_accelerations {
        let mut bodies = world.query_filtered::<Entity, (With<LastAcceleration>, Without<OwnLaws>)>();
        for body in bodies.iter(world).collect::<Vec<_>>() {
            world.entity_mut(body).remove::<LastAcceleration>();
        }
    }
}
