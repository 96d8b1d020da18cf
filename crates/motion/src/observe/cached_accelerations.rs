//! Cached accelerations of methods, to copy them to another world with the same bodies.
//!
//! A cache only saves evaluations: without it the next step evaluates the accelerations again, bit for bit.

use bevy_ecs::prelude::*;

use crate::groups::{GroupCache, Groups, Row};
use crate::laws::MutualGravity;
use crate::laws::epoch::Epoch;
use crate::laws::own::OwnLaws;
use crate::state::components::{PhysicsBody, Transform};
use crate::state::method_state::{CachedAcceleration, LastAcceleration};
use crate::units::Scalar;

/// The cached acceleration of a single body by called laws, from its [`LastAcceleration`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CachedBodyAcceleration {
    /// Position, m, and inverse mass, 1/kg, of the evaluation.
    pub at: [Scalar; 4],
    /// Time of the evaluation, s since the start of the scene.
    pub time: Scalar,
    /// Acceleration, m/s², and 0.
    pub acceleration: [Scalar; 4],
}

/// The cached accelerations of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct CachedGroupAccelerations {
    /// The bodies: movable ones first, then immovable ones, each in stable-id order.
    pub bodies: Vec<Entity>,
    /// Acceleration of each body, m/s², and 0.
    pub accelerations: Vec<[Scalar; 4]>,
    /// Time of the evaluation, s since the start of the scene.
    pub time: Scalar,
    /// Hash of the forces on its bodies other than called laws.
    pub kinds: u64,
}

/// All cached accelerations of a world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CachedAccelerations {
    /// Bodies with a [`LastAcceleration`]; `None` if no step can use it any more.
    pub bodies: Vec<(Entity, Option<CachedBodyAcceleration>)>,
    /// Groups whose accelerations the next step may use.
    pub groups: Vec<CachedGroupAccelerations>,
}

impl CachedAccelerations {
    /// Reads the caches of `world`, between two ticks.
    pub fn of(world: &mut World) -> Self {
        let epoch = Epoch::of(world);
        let mut bodies = world.query::<(Entity, &LastAcceleration, Option<&OwnLaws>)>();
        let bodies = bodies.iter(world).map(|(body, LastAcceleration(cached), own)| {
            let CachedAcceleration { at, time, laws, acceleration } = *cached;
            let is_finite = time.is_finite() && acceleration.iter().all(|number| number.is_finite());
            let is_current = is_finite && laws == (epoch, own.map_or(0, OwnLaws::version));
            (body, is_current.then_some(CachedBodyAcceleration { at, time, acceleration }))
        });
        let bodies = bodies.collect();
        let attraction = world.get_resource::<MutualGravity>();
        let groups = Groups::caches(world).filter_map(|(bodies, movable, cache)| {
            let time = cache.time()?;
            let (x, w) = rows(world, bodies, movable)?;
            let is_current =
                cache.is_under(epoch, versions(world, &bodies[..movable]), attraction) && cache.is_of(&x, &w);
            let is_finite = cache.accelerations().iter().flatten().all(|number| number.is_finite());
            (is_current && is_finite).then(|| CachedGroupAccelerations {
                bodies: bodies.to_vec(),
                accelerations: cache.accelerations().to_vec(),
                time,
                kinds: cache.kinds(),
            })
        });
        Self { bodies, groups: groups.collect() }
    }

    /// Writes the caches into `world`, which has to have the same laws and bodies, and compiled groups. Skips a group
    /// whose bodies differ, or whose number of accelerations does.
    pub fn restore(self, world: &mut World) {
        let epoch = Epoch::of(world);
        for (body, cache) in self.bodies {
            let Ok(mut body) = world.get_entity_mut(body) else { continue };
            let laws = (epoch, body.get::<OwnLaws>().map_or(0, OwnLaws::version));
            let cached = cache.map(|CachedBodyAcceleration { at, time, acceleration }| CachedAcceleration {
                at,
                time,
                laws,
                acceleration,
            });
            body.insert(LastAcceleration(cached.unwrap_or_default()));
        }
        for group in self.groups {
            restore_group(world, epoch, &group);
        }
        // A change of a law after this gets a later change tick.
        world.increment_change_tick();
    }
}

fn restore_group(world: &mut World, epoch: u64, group: &CachedGroupAccelerations) {
    let CachedGroupAccelerations { bodies, accelerations, time, kinds } = group;
    let is_same = |own: &[Entity]| own == bodies && own.len() == accelerations.len();
    let found = Groups::caches(world).enumerate().find(|(_, (own, ..))| is_same(own));
    let Some((number, (_, movable, _))) = found else { return };
    let Some((x, w)) = rows(world, bodies, movable) else { return };
    let mut cache = GroupCache::of(&x, w, accelerations, *time, *kinds);
    let own = versions(world, &bodies[..movable]);
    cache.under(epoch, own, world.get_resource::<MutualGravity>().copied());
    world.resource_mut::<Groups>().set_cache(number, cache);
}

/// Positions and inverse masses of the rows of a group; the inverse mass of an immovable row is 0.
fn rows(world: &World, bodies: &[Entity], movable: usize) -> Option<(Vec<Row<Scalar>>, Vec<Scalar>)> {
    let row = |(row, body): (usize, &Entity)| {
        let body = world.get_entity(*body).ok()?;
        let [x, y, z] = body.get::<Transform>()?.position.to_array();
        let w = body.get::<PhysicsBody>()?.inverse_mass;
        Some(([x, y, z, 0.0], if row < movable { w } else { 0.0 }))
    };
    bodies.iter().enumerate().map(row).collect::<Option<(Vec<_>, Vec<_>)>>()
}

/// Version of the own laws of a group's rows, computed as in a step.
fn versions(world: &World, bodies: &[Entity]) -> u64 {
    let own = bodies.iter().filter_map(|body| world.get::<OwnLaws>(*body));
    GroupCache::<Scalar>::versions(own.map(OwnLaws::version))
}
