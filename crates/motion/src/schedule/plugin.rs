//! The physics in an `App`.

use bevy_app::{App, FixedUpdate, Plugin};
use bevy_ecs::schedule::{InternedScheduleLabel, ScheduleLabel};

use crate::methods::table::Method;
use crate::schedule::drawing::{draw_bodies, is_fixed, share_rate};
use crate::schedule::stepper::Stepper;
use crate::state::clock::TimeStep;
use crate::state::threads::Threads;

/// Puts the physics into a schedule of an [`App`]: each run of the schedule is one tick, with the bits of
/// [`Stepper::tick`]. Needs the feature `bevy`.
///
/// The plugin [installs](Stepper::install) a [`Stepper`], so your systems are ordered by
/// [`StepSystems`](crate::StepSystems).
///
/// ```
/// use bevy_app::{App, FixedUpdate};
/// use bevy_ecs::prelude::*;
/// use motion::units::Vector;
/// use motion::{Forces, Gravity, InertiaPlugin, Method, PhysicsBody, StepSystems, Stepper, TimeStep, Transform};
///
/// fn blow(mut forces: Forces, bodies: Query<Entity, With<PhysicsBody>>) {
///     bodies.iter().for_each(|body| forces.add(body, Vector::X * 0.3));
/// }
///
/// let ball = || (Transform::at(Vector::Y * 10.0), PhysicsBody::with_mass(0.1));
/// let mut app = App::new();
/// app.add_plugins(InertiaPlugin::default().with_method(Method::RungeKutta4).with_hz(120.0))
///     .insert_resource(Gravity::EARTH)
///     .add_systems(FixedUpdate, blow.before(StepSystems::Integrate));
/// let in_app = app.world_mut().spawn(ball()).id();
///
/// // The same without an app.
/// let mut world = World::new();
/// world.insert_resource(Gravity::EARTH);
/// let body = world.spawn(ball()).id();
/// let mut stepper = Stepper::new(&mut world, Method::RungeKutta4, TimeStep(1.0 / 120.0));
/// let mut forces = Schedule::default();
/// forces.add_systems(blow);
///
/// for _ in 0..64 {
///     app.world_mut().run_schedule(FixedUpdate); // what Bevy's `TimePlugin` does at the rate of `Time<Fixed>`
///     forces.run(&mut world);
///     stepper.tick(&mut world);
/// }
/// let bits = |world: &World, body| {
///     let Transform { position } = world.get(body).expect("spawned above");
///     position.to_array().map(f64::to_bits)
/// };
/// assert_eq!(bits(app.world(), in_app), bits(&world, body));
/// ```
///
/// # Rate
/// The length of a tick and Bevy's `Time<Fixed>` are one setting: 64 ticks per second unless you change it, by
/// [`with_hz`](Self::with_hz), `Time::<Fixed>::from_hz`, or later by another [`TimeStep`] or
/// `Time::<Fixed>::set_timestep_hz`; the last one holds, and a [`TimeStep`] if both changed in a frame. Bevy counts whole
/// nanoseconds: the plugin's 120 Hz are 1/120 s to the last bit in [`TimeStep`], and 8,333,333 ns in Bevy.
///
/// The physics reads no clock: how many ticks a frame has is decided by Bevy's `TimePlugin`, one of its default plugins.
/// Without it nothing runs [`FixedUpdate`]: run it yourself, as above, or choose another [schedule](Self::in_schedule),
/// whose ticks have 1/64 s unless you say otherwise.
///
/// # Threads
/// Tables and groups of at least [`Threads::FROM`] bodies are shared between the threads of the app's
/// `ComputeTaskPool`, with the same bits, unless you have inserted other [`Threads`] before the app runs.
///
/// # Energy
/// [`LedgerPlugin`](crate::ledger::LedgerPlugin) beside this plugin keeps a ledger as a resource.
/// [`totals`](crate::totals()), [`each_force`](crate::each_force) and [margins](crate::margin) are functions of `&World`, which a system may
/// have as its parameter, as is [`Stepper::installed_method`]; a [snapshot](crate::snapshot) is taken by [`Stepper::installed`].
///
/// # Inspection
/// Components and settings of plain numbers are `Reflect`; immutable ones, such as [`Spring`](crate::Spring), can only be read. Bevy's
/// feature `reflect_auto_register`, one of its default ones, registers them.
///
/// # Drawing
/// The physics moves its own [`Transform`](crate::Transform), in `f64`. [`with_drawing`](Self::with_drawing) moves Bevy's
/// `Transform` after it, for every entity that has both:
///
/// ```
/// use bevy_app::prelude::*;
/// use bevy_transform::components::Transform;
/// use motion::{FloatingOrigin, InertiaPlugin, PhysicsBody, units::Vector};
///
/// let mut app = App::new();
/// app.add_plugins((bevy_time::TimePlugin, InertiaPlugin::default().with_drawing()))
///     .insert_resource(FloatingOrigin(Vector::X * 1e9));
/// let body = (motion::Transform::at(Vector::X * 1000000000.25), PhysicsBody::with_mass(1.0));
/// let body = app.world_mut().spawn((body, Transform::default())).id();
/// app.update();
/// assert_eq!(app.world().get::<Transform>(body).unwrap().translation.x, 0.25);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct InertiaPlugin {
    method: Method,
    step: Option<TimeStep>,
    pub(crate) schedule: InternedScheduleLabel,
    draws: bool,
}

impl Default for InertiaPlugin {
    fn default() -> Self {
        Self { method: Method::default(), step: None, schedule: FixedUpdate.intern(), draws: false }
    }
}

impl InertiaPlugin {
    /// With this method for every body that has none of its own; semi-implicit Euler otherwise.
    #[must_use]
    pub const fn with_method(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// With that many ticks per second, above 0.
    #[must_use]
    pub const fn with_hz(self, hz: f64) -> Self {
        Self { step: Some(TimeStep(1.0 / hz)), ..self }
    }

    /// In this schedule, such as `Update`, which is created if the app lacks it; in [`FixedUpdate`] otherwise.
    #[must_use]
    pub fn in_schedule(self, schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern(), ..self }
    }

    /// Copies positions to Bevy's `Transform`, around the [`FloatingOrigin`](crate::FloatingOrigin). In a fixed schedule they are those
    /// between the last two ticks, one tick before the time of the frame, and are there in `Update`.
    ///
    /// Rotation and scale are yours. The motion of a parent is added to that of its bodies. Where you move a body to another
    /// place, remove its [`PreviousPosition`](crate::PreviousPosition), or a frame may show it between the two. Hide particles
    /// that are [`Dormant`](crate::Dormant).
    #[must_use]
    pub const fn with_drawing(self) -> Self {
        Self { draws: true, ..self }
    }
}

impl Plugin for InertiaPlugin {
    fn build(&self, app: &mut App) {
        let Self { method, step, schedule, draws } = *self;
        let step = if is_fixed(app, schedule) {
            share_rate(app, step)
        } else {
            step.unwrap_or(TimeStep(1.0 / 64.0))
        };
        let world = app.init_schedule(schedule).world_mut();
        let stepper = Stepper::new(world, method, step);
        world.schedule_scope(schedule, |world, schedule| stepper.install(world, schedule));
        if draws {
            draw_bodies(app, schedule);
        }
    }

    /// The pool of the app exists once every plugin is built.
    fn finish(&self, app: &mut App) {
        if !app.world().contains_resource::<Threads>() {
            app.insert_resource(Threads::of_app());
        }
    }
}
