//! The physics in an `App`.

use bevy_app::{App, FixedUpdate, Plugin};
use bevy_ecs::schedule::{InternedScheduleLabel, ScheduleLabel};

use crate::methods::table::Method;
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
/// use motion::{Forces, Gravity, InertiaPlugin, PhysicsBody, StepSystems, Stepper, Transform};
///
/// fn blow(mut forces: Forces, bodies: Query<Entity, With<PhysicsBody>>) {
///     bodies.iter().for_each(|body| forces.add(body, Vector::X * 0.3));
/// }
///
/// let ball = || (Transform::at(Vector::Y * 10.0), PhysicsBody::with_mass(0.1));
/// let plugin = InertiaPlugin::default();
/// let mut app = App::new();
/// app.add_plugins(plugin)
///     .insert_resource(Gravity::EARTH)
///     .add_systems(FixedUpdate, blow.before(StepSystems::Integrate));
/// let in_app = app.world_mut().spawn(ball()).id();
///
/// // The same without an app.
/// let mut world = World::new();
/// world.insert_resource(Gravity::EARTH);
/// let body = world.spawn(ball()).id();
/// let mut stepper = Stepper::new(&mut world, plugin.method, plugin.step);
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
/// Bevy's `TimePlugin`, one of its default plugins, runs [`FixedUpdate`] as often as the resource `Time<Fixed>` says:
/// 64 times per second unless you change it. The default `step` is that, 1/64 s. The physics does not read Bevy's clock,
/// so another rate is set in both places:
///
/// ```text
/// app.insert_resource(Time::<Fixed>::from_hz(120.0))
///     .add_plugins(InertiaPlugin { step: TimeStep(1.0 / 120.0), ..InertiaPlugin::default() });
/// ```
///
/// To change it later, insert another [`TimeStep`] between two ticks and call `Time::<Fixed>::set_timestep_hz`.
/// Without `TimePlugin` nothing runs [`FixedUpdate`]: run it yourself, as above, or set `schedule`.
///
/// # Threads
/// Tables and groups of at least [`Threads::FROM`] bodies are shared between the threads of the app's
/// `ComputeTaskPool`, with the same bits, unless you have inserted other [`Threads`] before the app runs.
///
/// # Energy
/// [`LedgerPlugin`](crate::ledger::LedgerPlugin) beside this plugin keeps a ledger as a resource.
/// [`totals`](crate::totals()), [`each_force`](crate::each_force) and [margins](crate::margin) are functions of `&World`, which a system may
/// have as its parameter; a [snapshot](crate::snapshot) is taken by [`Stepper::installed`].
///
/// # Drawing
/// The physics moves its own [`Transform`](crate::Transform), in f64. Copy positions to Bevy's `Transform` after the
/// ticks of a frame, in `RunFixedMainLoopSystems::AfterFixedMainLoop`.
#[derive(Clone, Copy, Debug)]
pub struct InertiaPlugin {
    /// The method of every body that has none of its own.
    pub method: Method,
    /// Length of a tick, s.
    pub step: TimeStep,
    /// The schedule that the physics is put into, such as `Update.intern()`; created if the app lacks it.
    pub schedule: InternedScheduleLabel,
}

impl Default for InertiaPlugin {
    fn default() -> Self {
        Self {
            method: Method::default(),
            step: TimeStep(1.0 / 64.0),
            schedule: FixedUpdate.intern(),
        }
    }
}

impl Plugin for InertiaPlugin {
    fn build(&self, app: &mut App) {
        let world = app.init_schedule(self.schedule).world_mut();
        let stepper = Stepper::new(world, self.method, self.step);
        world.schedule_scope(self.schedule, |world, schedule| stepper.install(world, schedule));
    }

    /// The pool of the app exists once every plugin is built.
    fn finish(&self, app: &mut App) {
        if !app.world().contains_resource::<Threads>() {
            app.insert_resource(Threads::of_app());
        }
    }
}
