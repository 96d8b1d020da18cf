//! The stepper: carries a world from tick to tick.

use bevy_ecs::prelude::*;

use crate::groups::is_outdated;
use crate::laws::damping::Damping;
use crate::laws::own::OwnLaws;
use crate::laws::{MutualGravity, SharedLaws};
use crate::methods::Integrator;
use crate::methods::table::Method;
use crate::schedule::plan::{OutsideMethod, PlanInputs, StepPlan};
use crate::schedule::requests::{self, Requests};
use crate::schedule::restart::leave_methods;
use crate::schedule::systems::{
    StepSystems, apply_forces, check_step_resources, clear_forces, inner_schedule,
    insert_step_resources, step_schedule,
};
use crate::state::clock::{StepClock, TimeStep};
use crate::state::disabled::watch_disabled;
use crate::state::emitter::Emissions;
use crate::state::forces::PushedBodies;
use crate::state::method_state::LastAcceleration;
use crate::state::range::Range;
use crate::state::static_bodies::{StaticWatch, mark_static};
use crate::state::substeps::Substeps;
use crate::tick::body_filter::BodyFilter;
use crate::tick::quarantine::quarantine_bodies;

const NOT_INSTALLED: &str = "no stepper is installed in this world, or it is in use: call `Stepper::install` first, and do \
     not call it inside the closure of `Stepper::installed`";

/// The compiled schedule of a world and what a tick does around it: before it, requests and compiling again; after it,
/// the clock.
///
/// # Changes between two ticks
/// The next tick notices these without a call:
/// - resources inserted, changed or removed: [`Gravity`](crate::Gravity), [`Damping`](crate::Damping),
///   [`Drag`](crate::Drag), [`Wells`](crate::Wells), [`Laws`](crate::Laws), [`MutualGravity`](crate::MutualGravity),
///   [`Substeps`](crate::Substeps), [`Range`](crate::Range), [`Threads`](crate::Threads), and another [`TimeStep`];
/// - bodies, springs and emitters spawned, despawned, disabled and enabled;
/// - components inserted into bodies or removed from them, such as [`OwnLaws`] or another
///   [`PhysicsBody`](crate::PhysicsBody), whose velocity is that at the time of the position;
/// - a mass or a velocity given to a body that was immovable and at rest.
///
/// Ticks skip a body, spring or emitter with Bevy's [`Disabled`](bevy_ecs::entity_disabling::Disabled), and a body without its
/// `Transform` or [`Force`](crate::Force), as if it were removed. A body and a spring come back in the state in which they left,
/// without a force; an emitter begins as a new one, and its particles are dormant meanwhile.
///
/// ```
/// use bevy_ecs::entity_disabling::Disabled;
/// use bevy_ecs::prelude::*;
/// use motion::prelude::*;
///
/// let mut world = World::new();
/// let moving = PhysicsBody::with_mass(1.0).moving_at(Vector::X);
/// let [one, other] = [(); 2].map(|()| world.spawn(moving).id());
/// let mut stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(1.0));
/// stepper.tick(&mut world);
/// world.despawn(other);
/// world.entity_mut(one).insert(Disabled);
/// stepper.tick(&mut world);
/// world.entity_mut(one).remove::<Disabled>();
/// world.insert_resource(Gravity::EARTH);
/// stepper.tick(&mut world);
/// assert_eq!(world.get::<motion::Transform>(one).unwrap().position, Vector::new(2.0, -9.8, 0.0));
/// ```
///
/// A running body's velocity, position, inverse mass and method are changed by a [`Request`](crate::Request): the method
/// state of position Verlet belongs to the old values, and so do the counts of evaluations and the groups. Under position
/// Verlet use requests for gravity and damping too: they first bring velocities to the time of the positions.
pub struct Stepper {
    plan: StepPlan,
    schedule: Schedule,
    /// The inputs from which the plan was made.
    inputs: PlanInputs,
    statics: StaticWatch,
    /// Whether the stepper is installed in a user's schedule, which runs the rest of the tick.
    installed: bool,
    /// Whether a tick did not end, because a law panicked in it.
    interrupted: bool,
}

/// The stepper of a user's schedule.
#[derive(Resource)]
struct Installed {
    /// `None` while it is in use.
    stepper: Option<Stepper>,
    /// The systems that run it.
    systems: StepperSystems,
    /// Whether [`StepSystems::Integrate`] has run, and the clock has not counted the tick.
    integrated: bool,
}

/// The systems that a stepper was installed with into one schedule, by the number of that schedule.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct StepperSystems(u32);

impl StepperSystems {
    /// Whether the stepper is installed in the schedule of these systems.
    fn run(self) -> impl Fn(Option<Res<Installed>>) -> bool + Clone {
        move |installed| installed.is_some_and(|installed| installed.systems == self)
    }
}

/// The number of schedules that steppers were installed into.
#[derive(Resource, Default)]
struct Schedules(u32);

/// The method of the table or of your own that the bodies without their own were last integrated with, whose state they have.
#[derive(Resource, Clone, Copy, PartialEq)]
struct LastMethod(Method, Option<OutsideMethod>);

/// The installed stepper while it is in use; dropping it puts the stepper back, also where a law panics.
struct Lent<'w> {
    world: &'w mut World,
    stepper: Option<Stepper>,
}

impl<'w> Lent<'w> {
    fn take(world: &'w mut World) -> Self {
        let stepper = world
            .get_resource_mut::<Installed>()
            .and_then(|mut installed| installed.stepper.take());
        Self { world, stepper }
    }
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        if let Some(mut installed) = self.world.get_resource_mut::<Installed>() {
            installed.stepper = self.stepper.take();
        }
    }
}

impl Stepper {
    /// Prepares `world` for ticks of `step` and compiles the schedule of `method`.
    ///
    /// Several steppers may take turns in a world, each with its method. The length of a tick belongs to the world, so that of the last
    /// one that was made holds.
    ///
    /// # Panics
    /// If `step` is negative or not finite. When two systems of the schedule access the same data in no stated order,
    /// which is a bug of this crate.
    #[must_use]
    pub fn new(world: &mut World, method: Method, step: TimeStep) -> Self {
        Self::prepare(world, method, None, step)
    }

    /// [`Stepper::new`] with a method of your own for every body that has none of its own.
    ///
    /// The row of [`Integrator::METHOD`] in the table stands for the method wherever it is not run: a
    /// [margin](crate::margin) is of that method, and a [snapshot](crate::snapshot) names it and has to be restored into a
    /// stepper made by this function. [`Integrator::DAMPS_INSIDE`] and [`Integrator::STATE`] must be those of that row.
    ///
    /// ```
    /// use bevy_ecs::prelude::*;
    /// use motion::methods::{Field, Integrator, StepState};
    /// use motion::prelude::*;
    ///
    /// /// Ralston's method of order 2 (Ralston 1962).
    /// #[derive(Clone, Copy, Default)]
    /// struct Ralston;
    /// impl Integrator for Ralston {
    ///     const METHOD: Method = Method::RungeKutta2Heun;
    ///     fn step<F: Field>(f: &mut F, x: F::Space, v: F::Space, _: &mut StepState<F>) -> (F::Space, F::Space) {
    ///         let h = f.step();
    ///         let a1 = f.acceleration(0.0, x, v);
    ///         let (x2, v2) = (x + v * (h * 2.0 / 3.0), v + a1 * (h * 2.0 / 3.0));
    ///         let a2 = f.acceleration(2.0 / 3.0, x2, v2);
    ///         (x + (v + v2 * 3.0) * (h / 4.0), v + (a1 + a2 * 3.0) * (h / 4.0))
    ///     }
    /// }
    /// let mut world = World::new();
    /// world.insert_resource(motion::Wells(vec![motion::Well::new(Vector::ZERO, 1.0)]));
    /// let body = (motion::Transform::at(Vector::X), PhysicsBody::with_mass(1.0).moving_at(Vector::Y));
    /// let body = world.spawn(body).id();
    /// let mut stepper = Stepper::of::<Ralston>(&mut world, TimeStep(std::f64::consts::TAU / 1000.0));
    /// (0..1000).for_each(|_| stepper.tick(&mut world)); // once round a circle
    /// assert!(world.get::<motion::Transform>(body).unwrap().position.distance(Vector::X) < 1e-3);
    /// assert_eq!(world.resource::<motion::Evaluations>().accelerations(), 2 * 1000);
    /// ```
    ///
    /// # Panics
    /// As [`Stepper::new`].
    #[must_use]
    pub fn of<M: Integrator>(world: &mut World, step: TimeStep) -> Self {
        Self::prepare(world, M::METHOD, Some(OutsideMethod::of::<M>()), step)
    }

    fn prepare(
        world: &mut World,
        method: Method,
        outside: Option<OutsideMethod>,
        step: TimeStep,
    ) -> Self {
        insert_step_resources(world, step);
        world.init_resource::<Requests>();
        take_over(world, LastMethod(method, outside));
        Self::compile(world, method, outside, false)
    }

    fn compile(
        world: &mut World,
        method: Method,
        outside: Option<OutsideMethod>,
        installed: bool,
    ) -> Self {
        watch_disabled(world);
        mark_static(world);
        let plan = StepPlan::with(world, method, outside);
        Self::compile_plan(world, plan, installed)
    }

    fn compile_plan(world: &mut World, plan: StepPlan, installed: bool) -> Self {
        let mut schedule =
            if installed { inner_schedule(world, &plan) } else { step_schedule(world, &plan) };
        schedule.initialize(world).expect("the systems of a tick are totally ordered");
        let (inputs, statics) = (PlanInputs::of(world), StaticWatch::new(world));
        Self { plan, schedule, inputs, statics, installed, interrupted: false }
    }

    /// Puts the physics into your own schedule. Each run of it is one tick: the systems of [`StepSystems`], in that
    /// order, and everything else that [`Stepper::tick`] does, with the same bits.
    ///
    /// Outside of an `App`, call [`World::clear_trackers`] after each run, as after each [`Stepper::tick`].
    ///
    /// ```
    /// # use bevy_ecs::prelude::*;
    /// # use motion::{Forces, Gravity, Method, PhysicsBody, StepSystems, Stepper, TimeStep, Transform, units::Vector};
    /// fn blow(mut forces: Forces, bodies: Query<Entity, With<PhysicsBody>>) {
    ///     bodies.iter().for_each(|body| forces.add(body, Vector::X * 0.05));
    /// }
    /// let mut world = World::new();
    /// world.insert_resource(Gravity::EARTH);
    /// world.spawn((Transform::at(Vector::Y * 10.0), PhysicsBody::with_mass(0.1)));
    /// let mut schedule = Schedule::default();
    /// let stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(1.0 / 120.0));
    /// stepper.install(&mut world, &mut schedule);
    /// schedule.add_systems(blow.before(StepSystems::Integrate));
    /// schedule.run(&mut world);
    /// ```
    ///
    /// # Pauses
    /// A run condition on [`StepSystems::Tick`] pauses all of it: bodies, emitters, engines, the clock, pushes and forces wait.
    ///
    /// # A law that panics
    /// If the panic is caught, the world and the stepper stay usable. The tick is not counted, and bodies that were integrated
    /// before the panic have moved: [restore](crate::snapshot) a snapshot to undo that. The next run of a schedule with a
    /// single-threaded executor skips the systems that ran before the panic; a new schedule, after
    /// [`uninstall`](Self::uninstall), does not.
    ///
    /// # Panics
    /// As [`Stepper::new`], and if `world` has an installed stepper already: two would simulate every tick twice.
    pub fn install(self, world: &mut World, schedule: &mut Schedule) {
        assert!(
            !world.contains_resource::<Installed>(),
            "a stepper is installed in this world already; change it with `Stepper::installed`"
        );
        let stepper = Self::compile(world, self.plan.method, self.plan.outside, true);
        let Schedules(count) = *world.get_resource_or_init::<Schedules>();
        let is_there = |systems: &StepperSystems| schedule.graph().system_sets.contains(*systems);
        let known = (0..count).map(StepperSystems).find(is_there);
        let systems = known.unwrap_or(StepperSystems(count));
        world.insert_resource(Installed { stepper: Some(stepper), systems, integrated: false });
        if known.is_some() {
            return;
        }
        world.insert_resource(Schedules(count + 1));
        schedule.configure_sets(systems.run_if(systems.run()));
        let sets = (
            StepSystems::ApplyForces,
            StepSystems::Integrate,
            StepSystems::ClearForces,
            StepSystems::Quarantine,
        );
        schedule.configure_sets(sets.chain().in_set(StepSystems::Tick));
        let all = (
            apply_forces.in_set(StepSystems::ApplyForces),
            integrate_bodies.in_set(StepSystems::Integrate),
            clear_forces.in_set(StepSystems::ClearForces),
            (quarantine_bodies, finish_tick).chain().in_set(StepSystems::Quarantine),
        );
        schedule.add_systems(all.in_set(systems));
    }

    /// Takes the stepper that was [installed](Stepper::install) out of `world`, to tick by itself or to be installed again, into
    /// the same or another schedule. The systems in the old schedule do nothing from then on.
    ///
    /// # Panics
    /// If none is installed, or if it is called within [`Stepper::installed`].
    #[must_use]
    pub fn uninstall(world: &mut World) -> Self {
        let stepper = Lent::take(world).stepper.take().expect(NOT_INSTALLED);
        world.remove_resource::<Installed>();
        Self::compile(world, stepper.plan.method, stepper.plan.outside, false)
    }

    /// Whether a stepper is [installed](Stepper::install) in a schedule of `world`.
    #[must_use]
    pub fn is_installed(world: &World) -> bool {
        world.contains_resource::<Installed>()
    }

    /// The [method](Self::method) of the stepper that is [installed](Stepper::install) in `world`, if there is one that is not in use.
    #[must_use]
    pub fn installed_method(world: &World) -> Option<Method> {
        world.get_resource::<Installed>()?.stepper.as_ref().map(Self::method)
    }

    /// Calls `use_it` with the stepper that was [installed](Stepper::install), for example to change the method.
    ///
    /// # Panics
    /// If none is installed, or if it is called within itself.
    pub fn installed<R>(world: &mut World, use_it: impl FnOnce(&mut Self, &mut World) -> R) -> R {
        let mut lent = Lent::take(world);
        use_it(lent.stepper.as_mut().expect(NOT_INSTALLED), lent.world)
    }

    /// Simulates one tick.
    ///
    /// Births of particles and changes of methods remove components, which the world remembers for its
    /// [`RemovedComponents`] until you call [`World::clear_trackers`], once per tick or per frame.
    ///
    /// # Panics
    /// As [`Stepper::new`], and if `world` has an [installed](Stepper::install) stepper: then run its schedule. If the stepper
    /// was made for another world. If a resource that it inserted, such as [`TimeStep`] or [`Requests`], was removed. If a
    /// number of a law, a spring, an emitter, the [`TimeStep`] or [`Substeps`] is out of
    /// the range that its documentation states; nothing has moved then.
    pub fn tick(&mut self, world: &mut World) {
        assert!(
            !world.contains_resource::<Installed>(),
            "a stepper is installed in this world; run the schedule that it is installed in"
        );
        self.integrate(world);
        self.finish(world);
    }

    /// The part of a tick up to the end of [`StepSystems::Integrate`].
    fn integrate(&mut self, world: &mut World) {
        self.make_ready(world);
        self.interrupted = true;
        self.schedule.run(world);
        self.interrupted = false;
    }

    /// Brings the schedule up to date: carries out requests, and compiles again where the world asks for it. Idempotent.
    pub(crate) fn make_ready(&mut self, world: &mut World) {
        if cfg!(debug_assertions) {
            check_step_resources(world);
        }
        if take_over(world, LastMethod(self.plan.method, self.plan.outside)) {
            self.recompile(world);
        }
        self.carry_out_requests(world);
        check(world);
        if self.interrupted {
            // A schedule in which a system panicked skips those that ran before it.
            *self = Self::compile(world, self.plan.method, self.plan.outside, self.installed);
        }
        self.statics.release(world);
        if is_outdated(world)
            || PlanInputs::of(world) != self.inputs
            || world.get_resource::<Emissions>().is_some_and(|emissions| emissions.over)
        {
            self.recompile(world);
        }
    }

    /// Carries out the pending requests without simulating. A tick does so first; call it while the world is paused.
    ///
    /// # Panics
    /// As [`Stepper::tick`].
    pub fn carry_out_requests(&mut self, world: &mut World) {
        if !world.resource::<Requests>().is_empty() && requests::carry_out(world) {
            self.recompile(world);
        }
    }

    /// The end of a tick.
    fn finish(&mut self, world: &mut World) {
        if self.plan.emits
            && let Some(mut emissions) = world.get_resource_mut::<Emissions>()
        {
            emissions.births.clear();
        }
        let TimeStep(step) = *world.resource::<TimeStep>();
        world.resource_mut::<StepClock>().count(step);
    }

    /// Changes the method of every body that has none of its own, between two ticks. Velocities are brought to the time
    /// of the positions, from where the new method starts.
    ///
    /// # Panics
    /// As [`Stepper::new`].
    pub fn set_method(&mut self, world: &mut World, method: Method) {
        if method == self.plan.method && self.plan.outside.is_none() {
            return;
        }
        take_over(world, LastMethod(method, None));
        *self = Self::compile(world, method, None, self.installed);
    }

    /// Plans again, and compiles the schedule again if the plan has changed. A tick does so by itself where
    /// [it is needed](Stepper#changes-between-two-ticks).
    ///
    /// # Panics
    /// As [`Stepper::new`].
    pub fn recompile(&mut self, world: &mut World) {
        mark_static(world);
        let plan = StepPlan::with(world, self.plan.method, self.plan.outside);
        forget_accelerations(world, &plan);
        if plan == self.plan {
            self.inputs = PlanInputs::of(world);
        } else {
            *self = Self::compile_plan(world, plan, self.installed);
        }
    }

    /// Plans again for a world that was restored to another state, with the method of that state.
    pub(crate) fn resume(&mut self, world: &mut World, method: Method) {
        if method == self.plan.method {
            self.recompile(world);
        } else {
            *self = Self::compile(world, method, None, self.installed);
        }
        world.insert_resource(LastMethod(method, self.plan.outside));
    }

    /// The method of every body that has none of its own; for a method of your own, its [`Integrator::METHOD`].
    #[must_use]
    pub const fn method(&self) -> Method {
        self.plan.method
    }

    /// The type of the method [of your own](Self::of), if it is one.
    #[must_use]
    pub fn integrator(&self) -> Option<&'static str> {
        self.plan.outside.map(|outside| outside.name())
    }

    /// The plan that the schedule was compiled from.
    #[doc(hidden)]
    #[must_use]
    pub const fn plan(&self) -> &StepPlan {
        &self.plan
    }

    /// The names of the systems of a tick in the order in which they run, read from the compiled schedule.
    ///
    /// # Panics
    /// Never: the schedule was initialized when it was compiled.
    #[must_use]
    pub fn systems(&self) -> Vec<String> {
        let systems = self.schedule.systems().expect("initialized when compiled");
        systems.map(|(_, system)| system.name().shortname().to_string()).collect()
    }
}

/// Brings velocities to the time of the positions if the bodies were integrated with another method than `coming`, such as that of
/// another stepper. Returns whether they were.
fn take_over(world: &mut World, coming: LastMethod) -> bool {
    let last = world.get_resource::<LastMethod>().copied();
    if last == Some(coming) {
        return false;
    }
    world.insert_resource(coming);
    if last.is_some() {
        let bodies = BodyFilter::of_method(world, None);
        leave_methods(world, bodies);
    }
    last.is_some()
}

/// [`StepSystems::Integrate`] of a user's schedule.
pub(crate) fn integrate_bodies(world: &mut World) {
    Stepper::installed(world, Stepper::integrate);
    world.resource_mut::<PushedBodies>().close();
    world.resource_mut::<Installed>().integrated = true;
}

/// The end of [`StepSystems::Quarantine`] of a user's schedule.
pub(crate) fn finish_tick(world: &mut World) {
    if std::mem::take(&mut world.resource_mut::<Installed>().integrated) {
        Stepper::installed(world, Stepper::finish);
    }
}

/// Checks the numbers of the resources that act on every body.
///
/// # Panics
/// If a number is out of its range; the message names it.
fn check(world: &World) {
    world.resource::<TimeStep>().check();
    if let Some(Substeps(substeps)) = world.get_resource() {
        Substeps::check(*substeps);
    }
    world.get_resource().map(Damping::check);
    world.get_resource().map(Range::check);
    world.get_resource().map(MutualGravity::check);
    SharedLaws::of(world).check();
}

/// Removes the cached accelerations of bodies for which no law is called any more.
fn forget_accelerations(world: &mut World, plan: &StepPlan) {
    if !plan.caches_accelerations {
        let mut bodies =
            world.query_filtered::<Entity, (With<LastAcceleration>, Without<OwnLaws>)>();
        for body in bodies.iter(world).collect::<Vec<_>>() {
            world.entity_mut(body).remove::<LastAcceleration>();
        }
    }
}
