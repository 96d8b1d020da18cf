//! Accelerations that methods keep from tick to tick, out of one world and into another one of the same bodies.
//!
//! What is kept only saves evaluations: without it the next step evaluates them again, to the same bits.

use bevy_ecs::prelude::*;

use crate::groups::{Groups, Kept, Row};
use crate::laws::MutualGravity;
use crate::laws::epoch::Epoch;
use crate::laws::own::OwnLaws;
use crate::state::components::{PhysicsBody, Transform};
use crate::state::method_state::{Known, LastAcceleration};
use crate::units::Scalar;

/// The acceleration of a single body by the laws that are called, as [`LastAcceleration`] has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptAcceleration {
    /// Position, m, and inverse mass, 1/kg, that it was evaluated at.
    pub at: [Scalar; 4],
    /// Scene's time that it was evaluated at, s.
    pub time: Scalar,
    /// The acceleration, m/s², and 0.
    pub called: [Scalar; 4],
}

/// The accelerations of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptOfGroup {
    /// Its bodies, those that move first, each kind in the order of the stable id.
    pub bodies: Vec<Entity>,
    /// The acceleration of each of them, m/s², and 0.
    pub accelerations: Vec<[Scalar; 4]>,
    /// Scene's time that they were evaluated at, s.
    pub time: Scalar,
    /// A number for what acts on its bodies beside called laws.
    pub kinds: u64,
}

/// Everything of the kind in a world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeptAccelerations {
    /// Bodies with a [`LastAcceleration`]; `None` is one that no step can use any more.
    pub bodies: Vec<(Entity, Option<KeptAcceleration>)>,
    /// Groups whose accelerations the next step may use.
    pub groups: Vec<KeptOfGroup>,
}

impl KeptAccelerations {
    /// What is kept in `world`, between two ticks.
    pub fn of(world: &mut World) -> Self {
        let epoch = Epoch::of(world);
        let mut bodies = world.query::<(Entity, &LastAcceleration, Option<&OwnLaws>)>();
        let bodies = bodies.iter(world).map(|(body, LastAcceleration(known), own)| {
            let Known { at, time, laws, called } = *known;
            let is_number = time.is_finite() && called.iter().all(|part| part.is_finite());
            let is_current = is_number && laws == (epoch, own.map_or(0, OwnLaws::version));
            (body, is_current.then_some(KeptAcceleration { at, time, called }))
        });
        let bodies = bodies.collect();
        let attraction = world.get_resource::<MutualGravity>();
        let groups = Groups::kept(world).filter_map(|(bodies, movable, kept)| {
            let time = kept.time()?;
            let (x, w) = rows(world, bodies, movable)?;
            let is_current =
                kept.is_under(epoch, versions(world, &bodies[..movable]), attraction) && kept.is_of(&x, &w);
            let is_number = kept.accelerations().iter().flatten().all(|part| part.is_finite());
            (is_current && is_number).then(|| KeptOfGroup {
                bodies: bodies.to_vec(),
                accelerations: kept.accelerations().to_vec(),
                time,
                kinds: kept.kinds(),
            })
        });
        Self { bodies, groups: groups.collect() }
    }

    /// Puts it into `world`, whose laws and bodies are as they were, with its groups compiled. A group of other
    /// bodies, or one of as many accelerations as it has not, is left out.
    pub fn put(self, world: &mut World) {
        let epoch = Epoch::of(world);
        for (body, kept) in self.bodies {
            let Ok(mut body) = world.get_entity_mut(body) else { continue };
            let version = body.get::<OwnLaws>().map_or(0, OwnLaws::version);
            let known = kept.map_or_else(Known::default, |KeptAcceleration { at, time, called }| Known {
                at,
                time,
                laws: (epoch, version),
                called,
            });
            body.insert(LastAcceleration(known));
        }
        for group in self.groups {
            put_group(world, epoch, &group);
        }
        // What changes a law from here on does so at another time.
        world.increment_change_tick();
    }
}

fn put_group(world: &mut World, epoch: u64, given: &KeptOfGroup) {
    let KeptOfGroup { bodies, accelerations, time, kinds } = given;
    let found = Groups::kept(world).map(|(bodies, movable, _)| (bodies, movable)).enumerate();
    let Some((number, movable)) = found
        .filter(|(_, (own, _))| *own == bodies && own.len() == accelerations.len())
        .map(|(number, (_, movable))| (number, movable))
        .next()
    else {
        return;
    };
    let Some((x, w)) = rows(world, bodies, movable) else { return };
    let mut kept = Kept::of(&x, w, accelerations, *time, *kinds);
    let own = versions(world, &bodies[..movable]);
    kept.under(epoch, own, world.get_resource::<MutualGravity>().copied());
    world.resource_mut::<Groups>().keep(number, kept);
}

/// Positions and inverse masses of the rows of a group; what is held has none.
fn rows(world: &World, bodies: &[Entity], movable: usize) -> Option<(Vec<Row<Scalar>>, Vec<Scalar>)> {
    let row = |(row, body): (usize, &Entity)| {
        let body = world.get_entity(*body).ok()?;
        let [x, y, z] = body.get::<Transform>()?.position.to_array();
        let w = body.get::<PhysicsBody>()?.inverse_mass;
        Some(([x, y, z, 0.0], if row < movable { w } else { 0.0 }))
    };
    bodies.iter().enumerate().map(row).collect::<Option<(Vec<_>, Vec<_>)>>()
}

/// A number that is another one whenever laws of single rows are, as a step reckons it.
fn versions(world: &World, bodies: &[Entity]) -> u64 {
    let own = bodies.iter().filter_map(|body| world.get::<OwnLaws>(*body));
    Kept::<Scalar>::versions(own.map(OwnLaws::version))
}
