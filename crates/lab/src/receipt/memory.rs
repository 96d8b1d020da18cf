//! The memory that effects and methods take in a world: columns as they are allocated, resources, and the lists that
//! they hold.

use bevy_ecs::prelude::*;
use motion::effects::{Effect, EffectState};
use motion::groups::Groups;
use motion::snapshot::{Off, OffResource};
use motion::units::Vector;
use motion::{
    AxisLocks, Damping, DampingRate, Drag, Emission, Emitter, Gravity, Law, Link, MutualGravity, OwnLaws,
    SoftBody, SourceMass, SpeedLimit, Spring, Well, Wells,
};

/// Bytes of the state of `effect`, whether it is on or off.
pub(super) fn effect_bytes(world: &mut World, effect: Effect) -> usize {
    match effect {
        Effect::Gravity => resource_bytes::<Gravity>(world),
        Effect::Damping => resource_bytes::<Damping>(world) + component_bytes::<DampingRate>(world),
        Effect::Drag => resource_bytes::<Drag>(world) + own_law_bytes(world, effect),
        // Wind is a field of drag.
        Effect::Wind => 0,
        Effect::Wells => {
            let off = world.get_resource::<OffResource<Wells>>().map(|off| &off.0);
            let wells = world.get_resource().or(off).map_or(0, |Wells(wells)| wells.capacity());
            wells * size_of::<Well>() + resource_bytes::<Wells>(world) + own_law_bytes(world, effect)
        }
        Effect::MutualGravity => {
            let groups = if springs_are_on(world) { 0 } else { group_bytes(world) };
            groups + column_bytes::<SourceMass>(world) + resource_bytes::<MutualGravity>(world)
        }
        Effect::Thrusts => own_law_bytes(world, effect),
        Effect::Springs => {
            let lists = |body: &SoftBody| {
                body.points.capacity() * size_of::<Entity>()
                    + body.springs.len() * size_of::<Link>()
                    + body.triangles.capacity() * size_of::<[u32; 3]>()
            };
            let lists: usize = world.query::<&SoftBody>().iter(world).map(lists).sum();
            let groups = if springs_are_on(world) { group_bytes(world) } else { 0 };
            lists + groups + column_bytes::<Spring>(world) + column_bytes::<SoftBody>(world)
        }
        Effect::SpeedLimits => component_bytes::<SpeedLimit>(world),
        Effect::AxisLocks => component_bytes::<AxisLocks>(world),
        Effect::Emitters => {
            let lists = |emitter: &Emitter| {
                emitter.pool.capacity() * (size_of::<Entity>() + size_of::<u64>())
                    + emitter.launches.capacity() * size_of::<Vector>()
            };
            sum(world, lists) + column_bytes::<Emission>(world) + component_bytes::<Emitter>(world)
        }
    }
}

/// Bytes allocated for the column of a component, in all tables that have one.
pub(super) fn column_bytes<C: Component>(world: &World) -> usize {
    let Some(component) = world.components().component_id::<C>() else { return 0 };
    let tables = world.storages().tables.iter().filter(|table| table.has_column(component));
    tables.map(|table| table.capacity() * size_of::<C>()).sum()
}

fn component_bytes<C: Component>(world: &World) -> usize {
    column_bytes::<C>(world) + column_bytes::<Off<C>>(world)
}

fn resource_bytes<R: Resource>(world: &World) -> usize {
    let found = [world.contains_resource::<R>(), world.contains_resource::<OffResource<R>>()];
    found.map(|is_found| usize::from(is_found) * size_of::<R>()).iter().sum()
}

/// Bytes of the own laws of bodies that have the name of `effect`.
fn own_law_bytes(world: &mut World, effect: Effect) -> usize {
    sum(world, |laws: &OwnLaws| {
        let laws = laws.laws().iter().enumerate().filter(|(_, law)| law.name() == effect.name());
        let bytes = laws.map(|(place, law)| {
            // The component goes to the first law of the body.
            let component = if place == 0 { size_of::<OwnLaws>() } else { 0 };
            size_of_val(&**law) + size_of::<Box<dyn Law>>() + size_of::<usize>() + component
        });
        bytes.sum()
    })
}

/// The sum over a component, on or off.
fn sum<C: Component>(world: &mut World, of: impl Fn(&C) -> usize) -> usize {
    let on: usize = world.query::<&C>().iter(world).map(&of).sum();
    on + world.query::<&Off<C>>().iter(world).map(|off| of(&off.0)).sum::<usize>()
}

fn springs_are_on(world: &mut World) -> bool {
    motion::effects::state(world, Effect::Springs) == EffectState::On
}

/// Bytes of the groups. They are the springs', or mutual gravity's if no springs are on.
fn group_bytes(world: &World) -> usize {
    world.get_resource::<Groups>().map_or(0, Groups::bytes)
}
