//! Plain arrays of a world.

use std::fmt;

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

use super::Bare;
use super::individuals::{Kind, Own};
use super::joined::Joined;
use crate::groups::{Groups, RowAsks, update_groups};
use crate::laws::damping::DampingRate;
use crate::laws::own::OwnLaws;
use crate::laws::{Gravity, Law};
use crate::methods::markers::own_method;
use crate::methods::table::Method;
use crate::real::Real;
use crate::state::clock::TimeStep;
use crate::state::components::{
    AxisLocks, GravityOff, PhysicsBody, Quarantined, SpeedLimit, StableId, Transform,
};
use crate::state::coupling::Grouped;
use crate::state::emitter::Dormant;
use crate::state::method_state::LastStep;
use crate::state::substeps::{OwnSubsteps, Substeps};
use crate::units::Vector;

/// Why a world cannot go on in plain arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotForArrays {
    /// There is no [`TimeStep`].
    NoTimeStep,
}

impl fmt::Display for NotForArrays {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::NoTimeStep => "the world has no TimeStep: insert one before it is taken into plain arrays",
        })
    }
}

impl std::error::Error for NotForArrays {}

type Columns = (
    Entity,
    &'static Transform,
    &'static PhysicsBody,
    Option<&'static StableId>,
    Option<&'static LastStep>,
    Has<GravityOff>,
    Option<&'static DampingRate>,
    Option<&'static SpeedLimit>,
    Option<&'static AxisLocks>,
    Has<OwnLaws>,
    Option<&'static OwnSubsteps>,
    (Has<Grouped>, Has<Quarantined>, Has<Dormant>),
);

/// Laws of single bodies in the precision of the arrays.
pub type LawsOf<'a, T> = &'a dyn Fn(Entity) -> Vec<Box<dyn Law<T>>>;

impl<T: Real> Bare<T> {
    /// The bodies, what they ask for and what acts on them; `last_steps` are as the world has them, whatever method
    /// their bodies have.
    pub(super) fn gathered(
        world: &mut World,
        method: Method,
        laws: LawsOf<'_, T>,
        shared: Vec<Box<dyn Law<T>>>,
    ) -> Result<Self, NotForArrays> {
        let TimeStep(step) = *world.get_resource().ok_or(NotForArrays::NoTimeStep)?;
        update_groups(world, true);
        let mut bare = Self::new(method, T::ONE);
        bare.step = step;
        bare.substeps = Substeps::parts(world.get_resource());
        bare.clock = world.get_resource().copied().unwrap_or_default();
        let resources = &mut bare.resources;
        resources.gravity = world.get_resource::<Gravity>().copied();
        resources.drag = world.get_resource().copied();
        resources.wells = world.get_resource().cloned();
        resources.laws = shared;
        resources.attraction = world.get_resource().copied();
        resources.damping = world.get_resource().copied();
        resources.solver = world.get_resource().copied().unwrap_or_default();
        resources.range = world.get_resource().copied();
        let rows = bare.add_bodies(world, laws);
        bare.add_sources(world, &rows);
        if let Some(groups) = world.get_resource::<Groups>() {
            bare.join(groups, &rows);
        }
        Ok(bare)
    }

    /// Adds every body with physics; gives their rows.
    fn add_bodies(&mut self, world: &mut World, laws: LawsOf<'_, T>) -> EntityHashMap<usize> {
        let mut bodies = world.query::<Columns>();
        let world = &*world;
        let mut all: Vec<_> = bodies.iter(world).collect();
        all.sort_unstable_by_key(|(entity, _, _, id, ..)| (id.map_or(u32::MAX, |id| id.0), *entity));
        let mut rows = EntityHashMap::default();
        for (entity, transform, body, id, last, gravity_off, rate, limit, locks, lawful, substeps, state) in
            all
        {
            let numbers = |vector: Vector| vector.to_array().map(T::of);
            let (x, v) = (numbers(transform.position), numbers(body.velocity));
            let [a, b, c] = v;
            rows.insert(entity, self.bodies.len());
            self.positions.push(x);
            self.bodies.push([a, b, c, T::of(body.inverse_mass)]);
            self.ids.push(id.copied().unwrap_or(StableId(u32::MAX)));
            self.last_steps.push(T::of(last.map_or(0.0, |last| last.0)));
            let asks = RowAsks {
                gravity_off,
                damping_rate: rate.map(DampingRate::rate),
                limit: limit.map(|limit| limit.0),
                locks: locks.copied(),
            };
            let own = Own {
                asks,
                laws: if lawful { laws(entity) } else { Vec::new() },
                substeps: substeps.map(|substeps| substeps.0.max(1)),
            };
            let (grouped, quarantined, dormant) = state;
            let asks_for_more = asks != RowAsks { gravity_off, ..RowAsks::default() };
            let asks_for_more = asks_for_more || lawful || own.substeps.is_some();
            self.individuals.kinds.push(Kind {
                method: own_method(world.entity(entity)),
                weightless: gravity_off,
                own: asks_for_more.then_some(self.individuals.owns.len()),
                apart: grouped || quarantined || dormant,
                born: None,
            });
            if asks_for_more {
                self.individuals.owns.push(own);
            }
        }
        if self.last_steps.iter().all(|step| *step == T::ZERO) {
            self.last_steps.clear();
        }
        rows
    }

    fn join(&mut self, groups: &Groups, rows: &EntityHashMap<usize>) {
        for (coupling, bodies, substeps) in groups.parts() {
            let rows: Vec<_> = bodies.iter().filter_map(|body| rows.get(body).copied()).collect();
            let movable = || (0..).zip(&rows[..coupling.movable]);
            let asks = |row: usize| {
                let Kind { weightless, own, .. } = self.individuals.kinds[row];
                let asks = own.map_or(RowAsks::default(), |own| self.individuals.owns[own].asks);
                weightless || asks != RowAsks::default()
            };
            let laws = |row: usize| {
                let own = self.individuals.kinds[row].own;
                own.is_some_and(|own| !self.individuals.owns[own].laws.is_empty())
            };
            let asking = movable().filter(|(_, row)| asks(**row)).map(|(own, _)| own).collect();
            let lawful = movable().filter(|(_, row)| laws(**row)).map(|(own, _)| own).collect();
            let method = rows.first().and_then(|row| self.individuals.kinds[*row].method);
            let coupling = coupling.at::<T>();
            self.groups.push(Joined {
                coupling,
                rows,
                asking,
                lawful,
                substeps,
                method,
                ..Joined::default()
            });
        }
    }
}
