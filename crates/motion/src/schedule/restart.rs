//! Restarts of methods between two ticks: method state becomes velocities that any method can start from.

use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryBuilder;
use bevy_ecs::system::BoxedSystem;

use crate::groups::{GroupKernel, Groups, compile_groups, integrate_groups};
use crate::methods::Synchronize;
use crate::methods::markers::{mark_method, own_method};
use crate::methods::table::Method;
use crate::state::clock::TimeStep;
use crate::state::components::{PhysicsBody, Quarantined};
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::tick::body_filter::BodyFilter;
use crate::tick::integrate::integrate;
use crate::tick::quarantine::quarantine_refused;

/// Brings velocities of position Verlet to the time of the positions, for the bodies that `which` selects and for their
/// groups.
fn synchronize_bodies(world: &mut World, which: BodyFilter) {
    // First: a body that has left its group since the last tick is a single body now.
    compile_groups(world);
    let which = which.with::<LastStep>(world);
    let kernel = GroupKernel::of::<Synchronize>();
    let run = |world: &mut World, mut system: BoxedSystem| {
        system
            .run((), world)
            .expect("its resources were inserted with the time step and with the groups");
    };
    let system = integrate(world, kernel.single, &which, "synchronize_bodies".to_owned());
    run(world, system);
    if world.contains_resource::<Groups>() {
        let system = integrate_groups(world, kernel, &which, "synchronize_groups".to_owned());
        run(world, system);
    }
    // Not later: the coming tick runs without the bodies that were refused.
    quarantine_refused(world);
}

/// Removes the method state of the bodies that `which` selects, so that another method can start.
pub(crate) fn leave_methods(world: &mut World, which: BodyFilter) {
    type Keeps = Or<(With<LastStep>, With<LastAcceleration>)>;
    synchronize_bodies(world, which.clone());
    let mut query = QueryBuilder::<Entity, Keeps>::new(world);
    which.select(&mut query);
    let bodies: Vec<_> = query.build().iter(world).collect();
    for body in bodies {
        world.entity_mut(body).remove::<(LastStep, LastAcceleration)>();
    }
}

/// A body that leaves its method.
#[derive(Component)]
struct Leaves;

/// Restarts position Verlet for `bodies` and their groups. Skips quarantined bodies.
pub(crate) fn restart_bodies(world: &mut World, bodies: &[Entity]) {
    let restarts = |body: &&Entity| {
        world
            .get_entity(**body)
            .is_ok_and(|body| body.contains::<LastStep>() && !body.contains::<Quarantined>())
    };
    let bodies: Vec<_> = bodies.iter().filter(restarts).copied().collect();
    if is_prepared(world) && !bodies.is_empty() {
        // First: a body that has left its group since the last tick does not restart with it.
        compile_groups(world);
        leaving(world, &bodies, synchronize_bodies);
    }
}

/// Runs `leave` while `bodies` and the members of their groups are marked with [`Leaves`]; returns all of them.
fn leaving(world: &mut World, bodies: &[Entity], leave: fn(&mut World, BodyFilter)) -> Vec<Entity> {
    let members = Groups::with_members(world, bodies);
    world.insert_batch(members.iter().map(|body| (*body, Leaves)).collect::<Vec<_>>());
    let marked = BodyFilter::default().with::<Leaves>(world);
    leave(world, marked);
    members.iter().for_each(|body| {
        world.entity_mut(*body).remove::<Leaves>();
    });
    members
}

/// Gives a body and its group a method of their own, or the world's.
pub(crate) fn set_body_method(world: &mut World, body: Entity, method: Option<Method>) {
    if world.get::<PhysicsBody>(body).is_none() || own_method(world.entity(body)) == method {
        return;
    }
    compile_groups(world);
    for body in leaving(world, &[body], leave_methods) {
        mark_method(&mut world.entity_mut(body), method);
    }
}

/// Brings all velocities of position Verlet to the time of the positions, before laws change: the next kick would take
/// half of the last step under the new laws.
pub(crate) fn end_half_steps(world: &mut World) {
    if is_prepared(world) {
        synchronize_bodies(world, BodyFilter::default());
    }
}

/// Whether a stepper has prepared the world. Effects are also switched while a world is built.
fn is_prepared(world: &World) -> bool {
    world.contains_resource::<TimeStep>()
}
