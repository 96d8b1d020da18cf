//! How much of a world an effect takes: the bodies that it acts on, and the bytes of its state.

use std::mem::{size_of, size_of_val};

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;

use super::{Effect, EffectState, state};
use crate::groups::Groups;
use crate::laws::damping::{Damping, DampingRate};
use crate::laws::own::OwnLaws;
use crate::laws::{Drag, Gravity, Law, MutualGravity, SourceMass, Wells, laws};
use crate::state::components::{AxisLocks, GravityOff, PhysicsBody, Quarantined, SpeedLimit};
use crate::state::emitter::{Dormant, Emission, Emitter, Particle};
use crate::state::off::{Off, OffResource};
use crate::state::rest::Static;
use crate::state::springs::{Link, SoftBody, Spring};
use crate::units::{Scalar, Vector};

/// Bodies that a step looks at.
type Looked = (Without<Quarantined>, Without<Static>, Without<Dormant>);

/// Bytes allocated for the column of a component, in all tables that have one.
#[must_use]
pub fn column_bytes<C: Component>(world: &World) -> usize {
    let Some(component) = world.components().component_id::<C>() else { return 0 };
    let tables = world.storages().tables.iter().filter(|table| table.has_column(component));
    tables.map(|table| table.capacity() * size_of::<C>()).sum()
}

impl Effect {
    /// Bodies that the effect acts on in the coming step; 0 where it is off. Of springs, all ends.
    pub fn bodies(self, world: &mut World) -> usize {
        if state(world, self) != EffectState::On {
            return 0;
        }
        match self {
            Self::MutualGravity => world.get_resource::<Groups>().map_or(0, Groups::bodies),
            Self::Springs => spring_ends(world),
            Self::SpeedLimits => world.query_filtered::<&SpeedLimit, Looked>().iter(world).count(),
            Self::AxisLocks => world.query_filtered::<&AxisLocks, Looked>().iter(world).count(),
            Self::Emitters => world.query::<&Particle>().iter(world).count(),
            Self::Gravity => movable::<Without<GravityOff>>(world),
            // Wind is a part of drag.
            Self::Damping | Self::Wind => movable::<()>(world),
            Self::Drag | Self::Wells | Self::Thrusts => {
                if laws(world).any(|law| law.name() == self.name()) {
                    return movable::<()>(world);
                }
                let has = |own: &&OwnLaws| own.laws().iter().any(|law| law.name() == self.name());
                world.query_filtered::<&OwnLaws, Looked>().iter(world).filter(has).count()
            }
        }
    }

    /// Bytes of the effect's state in `world`: columns as they are allocated, resources, and the lists that they hold;
    /// on, or kept while it is off.
    pub fn bytes(self, world: &mut World) -> usize {
        match self {
            Self::Gravity => resource::<Gravity>(world),
            Self::Damping => resource::<Damping>(world) + both::<DampingRate>(world),
            Self::Drag => resource::<Drag>(world),
            // A part of drag.
            Self::Wind => 0,
            Self::Wells => {
                let off = world.get_resource::<OffResource<Wells>>().map(|off| &off.0);
                let list = world.get_resource().or(off).map_or(0, Wells::list_bytes);
                resource::<Wells>(world) + list + own_laws(world, self)
            }
            Self::MutualGravity => {
                resource::<MutualGravity>(world) + column_bytes::<SourceMass>(world) + groups(world, self)
            }
            Self::Thrusts => own_laws(world, self),
            Self::Springs => {
                let lists = |body: &SoftBody| {
                    body.points.capacity() * size_of::<Entity>()
                        + body.springs.len() * size_of::<Link>()
                        + body.triangles.capacity() * size_of::<[u32; 3]>()
                };
                let lists: usize = world.query::<&SoftBody>().iter(world).map(lists).sum();
                column_bytes::<Spring>(world) + column_bytes::<SoftBody>(world) + lists + groups(world, self)
            }
            Self::SpeedLimits => both::<SpeedLimit>(world),
            Self::AxisLocks => both::<AxisLocks>(world),
            Self::Emitters => {
                let lists = |emitter: &Emitter| {
                    emitter.pool.capacity() * (size_of::<Entity>() + size_of::<u64>())
                        + emitter.launches.capacity() * size_of::<Vector>()
                };
                let on: usize = world.query::<&Emitter>().iter(world).map(lists).sum();
                let off: usize = world.query::<&Off<Emitter>>().iter(world).map(|off| lists(&off.0)).sum();
                both::<Emitter>(world) + column_bytes::<Emission>(world) + on + off
            }
        }
    }
}

fn movable<Who: bevy_ecs::query::QueryFilter>(world: &mut World) -> usize {
    let mut bodies = world.query_filtered::<&PhysicsBody, (Who, Looked)>();
    bodies.iter(world).filter(|body| body.inverse_mass > 0.0).count()
}

fn spring_ends(world: &mut World) -> usize {
    let mut ends: EntityHashSet =
        world.query::<&Spring>().iter(world).flat_map(|spring| spring.ends).collect();
    for body in world.query::<&SoftBody>().iter(world) {
        let points = body.springs.iter().flat_map(|link| link.ends);
        ends.extend(points.filter_map(|point| body.points.get(point as usize)));
    }
    ends.len()
}

/// The column of a component, switched on or off.
fn both<C: Component>(world: &World) -> usize {
    column_bytes::<C>(world) + column_bytes::<Off<C>>(world)
}

fn resource<R: Resource>(world: &World) -> usize {
    let one = |there: bool, size| if there { size } else { 0 };
    one(world.contains_resource::<R>(), size_of::<R>())
        + one(world.contains_resource::<OffResource<R>>(), size_of::<OffResource<R>>())
}

/// Bytes of groups, which springs have made, or mutual gravity in a world without springs.
fn groups(world: &mut World, effect: Effect) -> usize {
    let springs = state(world, Effect::Springs) == EffectState::On;
    let bytes = world.get_resource::<Groups>().map_or(0, Groups::bytes);
    if springs == (effect == Effect::Springs) { bytes } else { 0 }
}

/// Bytes of laws of single bodies of that name; the component itself goes to its first law.
fn own_laws(world: &mut World, effect: Effect) -> usize {
    let of = |own: &OwnLaws| {
        let mut bytes = 0;
        for (place, law) in own.laws().iter().enumerate().filter(|(_, law)| law.name() == effect.name()) {
            bytes += size_of_val(&**law) + size_of::<Box<dyn Law<Scalar>>>() + size_of::<usize>();
            bytes += if place == 0 { size_of::<OwnLaws>() } else { 0 };
        }
        bytes
    };
    let on: usize = world.query::<&OwnLaws>().iter(world).map(of).sum();
    let off: usize = world.query::<&Off<OwnLaws>>().iter(world).map(|off| of(&off.0)).sum();
    on + off
}
