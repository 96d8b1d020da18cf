//! Restarts of methods between two ticks: what a method keeps of bodies becomes what it, or another one, starts from.

use bevy_ecs::prelude::*;
use bevy_ecs::query::ArchetypeFilter;

use crate::groups::{Groups, compile_groups, integrate_groups};
use crate::methods::Synchronize;
use crate::methods::markers::{mark_method, own_method};
use crate::methods::table::Method;
use crate::state::clock::TimeStep;
use crate::state::components::{PhysicsBody, Quarantined};
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::tick::integrate::integrate;
use crate::tick::quarantine::quarantine_refused;

/// Gives the bodies `Who` of position Verlet, and all members of their groups, the velocities at the time of their
/// positions.
fn synchronize_bodies<Who: ArchetypeFilter + 'static>(world: &mut World) {
    // First: a body that has left its group since the last tick is a single body now.
    compile_groups(world);
    world
        .run_system_cached(integrate::<Synchronize, (Who, With<LastStep>)>)
        .expect("its resources are inserted with the step's");
    if world.contains_resource::<Groups>() {
        world
            .run_system_cached(integrate_groups::<Synchronize, (Who, With<LastStep>)>)
            .expect("its resources are inserted with the step's and the groups");
    }
    // Now: the coming tick runs without the bodies that were refused.
    quarantine_refused(world);
}

/// Removes what the methods of the bodies `Who` keep of them, with velocities that any other method can start from.
pub(crate) fn leave_methods<Who: ArchetypeFilter + 'static>(world: &mut World) {
    synchronize_bodies::<Who>(world);
    let kept = world
        .query_filtered::<Entity, (Who, Or<(With<LastStep>, With<LastAcceleration>)>)>()
        .iter(world)
        .collect::<Vec<_>>();
    for body in kept {
        world.entity_mut(body).remove::<(LastStep, LastAcceleration)>();
    }
}

/// A body that leaves its method.
#[derive(Component)]
struct Leaves;

/// Restarts position Verlet for `bodies` and their groups. Skips quarantined bodies.
pub(crate) fn restart_bodies(world: &mut World, bodies: &[Entity]) {
    let starts = |body: &&Entity| {
        world
            .get_entity(**body)
            .is_ok_and(|body| body.contains::<LastStep>() && !body.contains::<Quarantined>())
    };
    let bodies: Vec<_> = bodies.iter().filter(starts).copied().collect();
    if is_prepared(world) && !bodies.is_empty() {
        // First: a body that has left its group since the last tick does not restart with it.
        compile_groups(world);
        leaving(world, &bodies, synchronize_bodies::<With<Leaves>>);
    }
}

/// Runs `what` while `bodies` and the members of their groups are marked with [`Leaves`]; returns these bodies.
fn leaving(world: &mut World, bodies: &[Entity], what: fn(&mut World)) -> Vec<Entity> {
    let members = Groups::with_members(world, bodies);
    world.insert_batch(members.iter().map(|body| (*body, Leaves)).collect::<Vec<_>>());
    what(world);
    members.iter().for_each(|body| {
        world.entity_mut(*body).remove::<Leaves>();
    });
    members
}

/// Gives one body and its group a method of their own, or the world's again.
pub(crate) fn set_body_method(world: &mut World, body: Entity, method: Option<Method>) {
    if world.get::<PhysicsBody>(body).is_none() || own_method(world.entity(body)) == method {
        return;
    }
    compile_groups(world);
    for body in leaving(world, &[body], leave_methods::<With<Leaves>>) {
        mark_method(&mut world.entity_mut(body), method);
    }
}

/// Brings all velocities of position Verlet to the time of the positions: its next kick is half of the last step's,
/// which was taken under the old laws.
pub(crate) fn end_half_steps(world: &mut World) {
    if is_prepared(world) {
        synchronize_bodies::<()>(world);
    }
}

/// Whether steps can be taken: effects are also switched while a world is built.
fn is_prepared(world: &World) -> bool {
    world.contains_resource::<TimeStep>()
}
