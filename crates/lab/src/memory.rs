//! Bytes that effects take in a world, read from its tables.

use std::mem::{size_of, size_of_val};

use bevy_ecs::prelude::*;
use motion::units::{Scalar, Vector};
use motion::{
    AxisLocks, Damping, DampingRate, Drag, Effect, EffectState, Emission, Emitter, Gravity, Groups, Link,
    MutualGravity, Off, OffResource, OwnLaws, SoftBody, SourceMass, SpeedLimit, Spring, Well, Wells,
};

/// Bytes allocated for the column of a component, in all tables that have one.
pub(crate) fn column<C: Component>(world: &World) -> usize {
    let Some(component) = world.components().component_id::<C>() else { return 0 };
    let tables = world.storages().tables.iter().filter(|table| table.has_column(component));
    tables.map(|table| table.capacity() * size_of::<C>()).sum()
}

/// The column of a component, switched on or off.
fn both<C: Component>(world: &World) -> usize {
    column::<C>(world) + column::<Off<C>>(world)
}

fn resource<R: Resource>(world: &World) -> usize {
    let one = |there: bool, size| if there { size } else { 0 };
    one(world.contains_resource::<R>(), size_of::<R>())
        + one(world.contains_resource::<OffResource<R>>(), size_of::<OffResource<R>>())
}

/// Bytes of an effect in `world`: columns as they are allocated, resources, and the lists that they hold; on or
/// kept while it is off.
pub(crate) fn bytes(world: &mut World, effect: Effect) -> usize {
    match effect {
        Effect::Gravity => resource::<Gravity>(world),
        Effect::Damping => resource::<Damping>(world) + both::<DampingRate>(world),
        Effect::Drag => resource::<Drag>(world),
        // A part of drag.
        Effect::Wind => 0,
        Effect::Wells => {
            let wells = world.get_resource::<Wells>();
            let off = world.get_resource::<OffResource<Wells>>().map(|off| &off.0);
            let wells = wells.or(off).map_or(0, |wells| wells.0.capacity() * size_of::<Well>());
            resource::<Wells>(world) + wells + own_laws(world, effect)
        }
        Effect::MutualGravity => {
            resource::<MutualGravity>(world) + column::<SourceMass>(world) + groups(world, effect)
        }
        Effect::Thrusts => own_laws(world, effect),
        Effect::Springs => {
            let lists = |body: &SoftBody| {
                body.points.capacity() * size_of::<Entity>()
                    + body.springs.capacity() * size_of::<Link>()
                    + body.triangles.capacity() * size_of::<[u32; 3]>()
            };
            let lists: usize = world.query::<&SoftBody>().iter(world).map(lists).sum();
            column::<Spring>(world) + column::<SoftBody>(world) + lists + groups(world, effect)
        }
        Effect::SpeedLimits => both::<SpeedLimit>(world),
        Effect::AxisLocks => both::<AxisLocks>(world),
        Effect::Emitters => {
            let lists = |emitter: &Emitter| {
                emitter.pool.capacity() * (size_of::<Entity>() + size_of::<u64>())
                    + emitter.launches.capacity() * size_of::<Vector>()
            };
            let on: usize = world.query::<&Emitter>().iter(world).map(lists).sum();
            let off: usize = world.query::<&Off<Emitter>>().iter(world).map(|off| lists(&off.0)).sum();
            both::<Emitter>(world) + column::<Emission>(world) + on + off
        }
    }
}

/// Bytes of groups, which springs have made, or mutual gravity where there are none.
fn groups(world: &mut World, effect: Effect) -> usize {
    let springs = motion::state(world, Effect::Springs) == EffectState::On;
    let bytes = world.get_resource::<Groups>().map_or(0, Groups::bytes);
    if springs == (effect == Effect::Springs) { bytes } else { 0 }
}

/// Bytes of laws of single bodies of that name; the component itself goes to its first law.
fn own_laws(world: &mut World, effect: Effect) -> usize {
    let of = |own: &OwnLaws| {
        let mut bytes = 0;
        for (place, law) in own.laws().iter().enumerate().filter(|(_, law)| law.name() == effect.name()) {
            bytes += size_of_val(&**law) + size_of::<Box<dyn motion::Law<Scalar>>>() + size_of::<usize>();
            bytes += if place == 0 { size_of::<OwnLaws>() } else { 0 };
        }
        bytes
    };
    let on: usize = world.query::<&OwnLaws>().iter(world).map(of).sum();
    let off: usize = world.query::<&Off<OwnLaws>>().iter(world).map(|off| of(&off.0)).sum();
    on + off
}
