//! The values of effects: where they are stored while on and while off, and how many bodies and bytes they affect.

use std::mem::{replace, size_of, size_of_val};

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryFilter;

use super::EFFECTS;
use crate::groups::Groups;
use crate::laws::damping::DampingRate;
use crate::laws::own::OwnLaws;
use crate::laws::{Drag, Gravity, Law, MutualGravity, SourceMass, Wind, WorldLaw};
use crate::schedule::backend::ParticleBackend;
use crate::schedule::restart::{end_half_steps, restart_bodies};
use crate::schedule::systems::Moving;
use crate::state::archetypes::{collect, values};
use crate::state::components::{GravityOff, Quarantined};
use crate::state::coupling::CouplingChanged;
use crate::state::emitter::{Dormant, Emission, Emitter, Particle};
use crate::state::springs::{Link, SoftBody, Spring};
use crate::state::static_bodies::Static;
use crate::state::switched_off::{Off, OffResource, SpringsOff};
use crate::tick::columns::observed;
use crate::units::Vector;

/// Values of an effect, all of one kind.
pub(super) struct Values {
    /// Whether there are values that are on, and values that are off.
    pub state: fn(&World) -> [bool; 2],
    pub switch: fn(&mut World, bool),
    /// Prepares position Verlet for the switch: half a step under these values cannot be ended without them.
    pub restart: fn(&mut World),
    /// Number of bodies that they act on while they are on.
    pub bodies: fn(&World) -> usize,
    pub bytes: fn(&World) -> usize,
}

/// A resource, which is in the world while it is on.
pub(super) const fn resource<R: Resource>() -> Values {
    Values {
        state: |world| {
            [world.contains_resource::<R>(), world.contains_resource::<OffResource<R>>()]
        },
        switch: |world, on| {
            if on {
                if let Some(OffResource(value)) = world.remove_resource::<OffResource<R>>() {
                    world.insert_resource(value);
                }
            } else if let Some(value) = world.remove_resource::<R>() {
                world.insert_resource(OffResource(value));
            }
        },
        restart: end_half_steps,
        bodies: movable::<()>,
        bytes: |world| {
            (resource::<R>().state)(world)
                .map(|there| usize::from(there) * size_of::<R>())
                .iter()
                .sum()
        },
    }
}

/// A law that is a resource, with its lists.
pub(super) const fn law<R: WorldLaw>() -> Values {
    Values {
        bytes: |world| {
            let off = world.get_resource::<OffResource<R>>().map(|off| &off.0);
            let lists = world.get_resource().or(off).map_or(0, R::list_bytes);
            lists + (resource::<R>().bytes)(world)
        },
        ..resource::<R>()
    }
}

/// A component, which bodies have while it is on.
pub(super) const fn component<C: Component>() -> Values {
    Values {
        state: |world| [exists::<C>(world), exists::<Off<C>>(world)],
        switch: |world, on| match on {
            true => exchange(world, |Off(value): Off<C>| value),
            false => exchange::<C, _>(world, Off),
        },
        restart: |_| {},
        bodies: |world| moving::<C>(world).count(),
        bytes: |world| column_bytes::<C>(world) + column_bytes::<Off<C>>(world),
    }
}

/// Own laws of bodies whose name is that of the effect.
pub(super) const fn own_laws<const EFFECT: usize>() -> Values {
    fn have<const EFFECT: usize>(laws: &OwnLaws) -> bool {
        laws.laws().iter().any(|law| law.name() == EFFECTS[EFFECT].1)
    }
    Values {
        state: |world| {
            [any(world, have::<EFFECT>), any(world, |Off(laws): &_| have::<EFFECT>(laws))]
        },
        switch: |world, on| {
            let [any_on, any_off] = (own_laws::<EFFECT>().state)(world);
            if !(if on { any_off } else { any_on }) {
                return;
            }
            let bodies = if on {
                entities_with::<Off<OwnLaws>>(world)
            } else {
                entities_with::<OwnLaws>(world)
            };
            for body in bodies {
                let mut body = world.entity_mut(body);
                let mut laws =
                    [body.take::<OwnLaws>(), body.take::<Off<OwnLaws>>().map(|off| off.0)];
                let [from, to] = if on { [1, 0] } else { [0, 1] };
                let (named, rest) =
                    laws[from].take().map_or((None, None), |laws| laws.split(EFFECTS[EFFECT].1));
                laws[to] = match (laws[to].take(), named) {
                    (Some(laws), Some(named)) => Some(laws.merge(named)),
                    (laws, named) => laws.or(named),
                };
                laws[from] = rest;
                let [on, off] = laws;
                if let Some(laws) = on {
                    body.insert(laws);
                }
                if let Some(laws) = off {
                    body.insert(Off(laws));
                }
            }
        },
        restart: |world| {
            let mut bodies = world.query::<(Entity, AnyOf<(&OwnLaws, &Off<OwnLaws>)>)>();
            let bodies = bodies.iter(world).filter(|(_, (on, off))| {
                on.is_some_and(have::<EFFECT>) || off.is_some_and(|off| have::<EFFECT>(&off.0))
            });
            let bodies: Vec<_> = bodies.map(|(body, _)| body).collect();
            restart_bodies(world, &bodies);
        },
        bodies: |world| moving::<OwnLaws>(world).filter(|laws| have::<EFFECT>(laws)).count(),
        bytes: |world| {
            sum(world, |laws: &OwnLaws| {
                let laws = laws
                    .laws()
                    .iter()
                    .enumerate()
                    .filter(|(_, law)| law.name() == EFFECTS[EFFECT].1);
                let bytes = laws.map(|(place, law)| {
                    // The bytes of the component count with the first law of the body.
                    let component = if place == 0 { size_of::<OwnLaws>() } else { 0 };
                    size_of_val(&**law) + size_of::<Box<dyn Law>>() + size_of::<usize>() + component
                });
                bytes.sum()
            })
        },
    }
}

/// Gravity stays in the world with its flag.
pub(super) const GRAVITY: Values = Values {
    state: |world| {
        let gravity = world.get_resource::<Gravity>();
        [gravity.is_some_and(|gravity| gravity.on), gravity.is_some()]
    },
    switch: |world, on| {
        if let Some(mut gravity) = world.get_resource_mut::<Gravity>() {
            gravity.on = on;
        }
    },
    bodies: movable::<Without<GravityOff>>,
    ..resource::<Gravity>()
};

/// Rates of single bodies mean nothing without the damping of the scene.
pub(super) const DAMPING_RATES: Values =
    Values { state: |_| [false; 2], ..component::<DampingRate>() };

/// The wind of a scene, off: still air.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
struct OffWind(Wind);

/// A part of a law that is switched alone, whether the law is on or off.
pub(super) trait PartOfLaw {
    const VALUES: Values;
}

impl PartOfLaw for Wind {
    const VALUES: Values = Values {
        state: |world| {
            let off = || world.get_resource::<OffResource<Drag>>().map(|off| &off.0);
            let drag = world.get_resource::<Drag>().or_else(off);
            [drag.is_some_and(|drag| drag.wind.is_some()), world.contains_resource::<OffWind>()]
        },
        switch: |world, on| {
            let off = world.remove_resource().map(|OffWind(wind)| wind).filter(|_| on);
            let drag = if world.contains_resource::<Drag>() {
                world.get_resource_mut::<Drag>().map(Mut::into_inner)
            } else {
                world.get_resource_mut::<OffResource<Drag>>().map(|drag| &mut drag.into_inner().0)
            };
            if let Some(wind) = drag.and_then(|drag| replace(&mut drag.wind, off)) {
                world.insert_resource(OffWind(wind));
            }
        },
        bytes: |_| 0,
        ..resource::<Drag>()
    };
}

pub(super) const MUTUAL_GRAVITY: Values = Values {
    switch: |world, on| {
        (resource::<MutualGravity>().switch)(world, on);
        CouplingChanged::set(world);
    },
    bodies: |world| world.get_resource::<Groups>().map_or(0, Groups::bodies),
    bytes: |world| {
        let groups = if springs_are_on(world) { 0 } else { group_bytes(world) };
        groups + column_bytes::<SourceMass>(world) + (resource::<MutualGravity>().bytes)(world)
    },
    ..resource::<MutualGravity>()
};

/// Springs stay in the world, because a soft body is drawn and picked also while nothing holds it together.
pub(super) const SPRINGS: Values = Values {
    state: |world| [springs_are_on(world), any_spring(world)],
    switch: |world, on| {
        match on {
            true => drop(world.remove_resource::<SpringsOff>()),
            false => world.insert_resource(SpringsOff),
        }
        CouplingChanged::set(world);
    },
    restart: end_half_steps,
    bodies: spring_ends,
    bytes: |world| {
        let lists = |body: &SoftBody| {
            body.points.capacity() * size_of::<Entity>()
                + body.springs.len() * size_of::<Link>()
                + body.triangles.capacity() * size_of::<[u32; 3]>()
        };
        let lists: usize = values::<SoftBody>(world).map(lists).sum();
        let groups = if springs_are_on(world) { group_bytes(world) } else { 0 };
        lists + groups + column_bytes::<Spring>(world) + column_bytes::<SoftBody>(world)
    },
};

pub(super) const EMITTERS: Values = Values {
    bodies: |world| values::<Particle>(world).count(),
    bytes: |world| {
        let lists = |emitter: &Emitter| {
            emitter.pool.capacity() * (size_of::<Entity>() + size_of::<u64>())
                + emitter.launches.capacity() * size_of::<Vector>()
        };
        let kept =
            world.get_resource().map_or(0, |backend: &ParticleBackend| (backend.bytes)(world));
        sum(world, lists)
            + kept
            + column_bytes::<Emission>(world)
            + (component::<Emitter>().bytes)(world)
    },
    ..component::<Emitter>()
};

/// Bytes allocated for the column of a component, in all tables that have one.
#[must_use]
pub fn column_bytes<C: Component>(world: &World) -> usize {
    let Some(component) = world.components().component_id::<C>() else { return 0 };
    let tables = world.storages().tables.iter().filter(|table| table.has_column(component));
    tables.map(|table| table.capacity() * size_of::<C>()).sum()
}

fn any<C: Component>(world: &World, is: impl Fn(&C) -> bool) -> bool {
    world.try_query::<&C>().is_some_and(|mut query| query.iter(world).any(is))
}

fn exists<C: Component>(world: &World) -> bool {
    any::<C>(world, |_| true)
}

/// The values of a component of moving bodies.
fn moving<C: Component>(world: &World) -> impl Iterator<Item = &C> {
    let value = |(body, value): (Entity, _)| {
        let body = world.entity(body);
        let rests = body.contains::<Quarantined>()
            || body.contains::<Static>()
            || body.contains::<Dormant>();
        (!rests).then_some(value)
    };
    collect::<C, _>(world, value).into_iter()
}

/// The sum over a component, on or off.
fn sum<C: Component>(world: &World, of: impl Fn(&C) -> usize) -> usize {
    let on: usize = values::<C>(world).map(&of).sum();
    on + values::<Off<C>>(world).map(|off| of(&off.0)).sum::<usize>()
}

fn entities_with<C: Component>(world: &World) -> Vec<Entity> {
    collect::<C, _>(world, |(entity, _)| Some(entity))
}

fn exchange<Old: Component, New: Component>(world: &mut World, new: fn(Old) -> New) {
    for entity in entities_with::<Old>(world) {
        let mut entity = world.entity_mut(entity);
        if let Some(old) = entity.take::<Old>() {
            entity.insert(new(old));
        }
    }
}

fn movable<Filter: QueryFilter>(world: &World) -> usize {
    let mut bodies = observed::<(Filter, Moving)>(world);
    bodies.iter(world).filter(|row| row.body.inverse_mass > 0.0).count()
}

fn any_spring(world: &World) -> bool {
    exists::<Spring>(world) || exists::<SoftBody>(world)
}

fn springs_are_on(world: &World) -> bool {
    !world.contains_resource::<SpringsOff>() && any_spring(world)
}

fn spring_ends(world: &World) -> usize {
    let mut ends: EntityHashSet = values::<Spring>(world).flat_map(|spring| spring.ends).collect();
    for body in values::<SoftBody>(world) {
        let points = body.springs.iter().flat_map(|link| link.ends);
        ends.extend(points.filter_map(|point| body.points.get(point as usize)));
    }
    ends.len()
}

/// Bytes of the groups, which count with springs, or with mutual gravity if no springs are on.
fn group_bytes(world: &World) -> usize {
    world.get_resource::<Groups>().map_or(0, Groups::bytes)
}
