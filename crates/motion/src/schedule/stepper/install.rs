//! The physics in a schedule of your own.

use bevy_ecs::prelude::*;

use super::Stepper;
use crate::schedule::systems::{StepSystems, apply_forces, clear_forces};
use crate::tick::quarantine::quarantine_bodies;

/// The stepper of a schedule of your own; absent while it is at work.
#[derive(Resource)]
struct Installed(Option<Stepper>);

impl Stepper {
    /// Puts the physics into a schedule of your own, of which each run is then one tick: the systems of [`StepSystems`], in
    /// that order, with everything that [`Stepper::tick`] does and to the same bits. Where particles are emitted and no
    /// `App` does it, call [`World::clear_trackers`] after each run: the world remembers removed components until then.
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
    /// # Panics
    /// As [`Stepper::new`].
    pub fn install(self, world: &mut World, schedule: &mut Schedule) {
        let stepper = Self::compile(world, self.plan.method, true);
        world.insert_resource(Installed(Some(stepper)));
        let parts = (
            StepSystems::ApplyForces,
            StepSystems::Integrate,
            StepSystems::ClearForces,
            StepSystems::Quarantine,
        );
        schedule.configure_sets(parts.chain());
        schedule.add_systems((
            apply_forces.in_set(StepSystems::ApplyForces),
            integrate_bodies.in_set(StepSystems::Integrate),
            clear_forces.in_set(StepSystems::ClearForces),
            (quarantine_bodies, finish_tick).chain().in_set(StepSystems::Quarantine),
        ));
    }

    /// Does something with the stepper that was installed, such as to change the method.
    ///
    /// # Panics
    /// Where none was installed, and in itself.
    pub fn installed<R>(world: &mut World, what: impl FnOnce(&mut Self, &mut World) -> R) -> R {
        let stepper = world.get_resource_mut::<Installed>().and_then(|mut installed| installed.0.take());
        let mut stepper = stepper.expect("call `Stepper::install` first; it cannot be used within itself");
        let result = what(&mut stepper, world);
        world.resource_mut::<Installed>().0 = Some(stepper);
        result
    }
}

/// [`StepSystems::Integrate`].
fn integrate_bodies(world: &mut World) {
    Stepper::installed(world, Stepper::integrate);
}

/// The end of [`StepSystems::Quarantine`].
fn finish_tick(world: &mut World) {
    Stepper::installed(world, Stepper::finish);
}
