//! The ledger of a stepper that is installed in a schedule: systems of its own at both ends of a tick.

use bevy_ecs::prelude::*;

use super::{Ledger, OpenTick};
use crate::schedule::stepper::{Stepper, finish_tick, integrate_bodies};
use crate::schedule::systems::StepSystems;

impl Ledger {
    /// Adds systems to `schedule` that keep a ledger of each tick of the stepper that is [installed](Stepper::install) there: the
    /// resource `Ledger`, opened at the start of the first tick. Order a system that reads it after [`StepSystems::Quarantine`];
    /// remove it, and the next tick opens another one.
    ///
    /// ```
    /// use bevy_ecs::prelude::*;
    /// use motion::ledger::Ledger;
    /// use motion::{Gravity, Method, PhysicsBody, Stepper, TimeStep, Transform};
    ///
    /// let mut world = World::new();
    /// world.insert_resource(Gravity::EARTH);
    /// world.spawn((Transform::default(), PhysicsBody::with_mass(2.0)));
    /// let mut schedule = Schedule::default();
    /// let stepper = Stepper::new(&mut world, Method::ExplicitEuler, TimeStep(0.01));
    /// stepper.install(&mut world, &mut schedule);
    /// Ledger::install(&mut schedule);
    /// (0..100).for_each(|_| schedule.run(&mut world));
    ///
    /// // Explicit Euler falls g h t / 2 too little in t = 1 s, so that energy comes from nowhere: m g times that.
    /// let invented = world.resource::<Ledger>().since_opening().energy.residual;
    /// let g = Gravity::EARTH.acceleration.length();
    /// assert!((invented - 2.0 * g * (g * 0.01 / 2.0)).abs() < 1e-9);
    /// ```
    pub fn install(schedule: &mut Schedule) {
        schedule.add_systems((
            begin_tick.in_set(StepSystems::Integrate).before(integrate_bodies),
            end_tick.in_set(StepSystems::Quarantine).after(finish_tick),
        ));
    }
}

/// Begins the tick of the ledger, if a stepper is installed.
fn begin_tick(world: &mut World) {
    if !Stepper::is_installed(world) {
        return;
    }
    if !world.contains_resource::<Ledger>() {
        let ledger = Ledger::open(world);
        world.insert_resource(ledger);
    }
    let open = Stepper::installed(world, OpenTick::begin);
    world.insert_resource(open);
}

/// Adds the tick to the ledger, unless it was not simulated.
fn end_tick(world: &mut World) {
    if let Some(open) = world.remove_resource::<OpenTick>()
        && let Some(mut ledger) = world.remove_resource::<Ledger>()
        && let Some(method) = Stepper::installed_method(world)
    {
        ledger.close_tick(world, method, &open);
        world.insert_resource(ledger);
    }
}

/// Keeps a [`Ledger`] of the ticks of [`InertiaPlugin`](crate::InertiaPlugin), as [`Ledger::install`] says. Needs the feature `bevy`.
#[cfg(feature = "bevy")]
#[derive(Clone, Copy, Debug)]
pub struct LedgerPlugin {
    schedule: bevy_ecs::schedule::InternedScheduleLabel,
}

#[cfg(feature = "bevy")]
impl Default for LedgerPlugin {
    fn default() -> Self {
        Self { schedule: crate::InertiaPlugin::default().schedule }
    }
}

#[cfg(feature = "bevy")]
impl LedgerPlugin {
    /// In the [schedule](crate::InertiaPlugin::in_schedule) of the physics, if that is another than the default one.
    #[must_use]
    pub fn in_schedule(schedule: impl bevy_ecs::schedule::ScheduleLabel) -> Self {
        Self { schedule: schedule.intern() }
    }
}

#[cfg(feature = "bevy")]
impl bevy_app::Plugin for LedgerPlugin {
    fn build(&self, app: &mut bevy_app::App) {
        let world = app.init_schedule(self.schedule).world_mut();
        world.schedule_scope(self.schedule, |_, schedule| Ledger::install(schedule));
    }
}
