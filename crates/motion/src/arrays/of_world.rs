//! Plain arrays copied from a world.

use std::fmt;

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

use super::Bare;
use super::bodies::{Kind, OwnOptions};
use super::groups::ArrayGroup;
use crate::groups::{Group, Groups, update_groups};
use crate::kernels::{BodyOptions, RowOptions as _};
use crate::laws::{Gravity, Law, RidingWells, WorldLaws};
use crate::methods::table::Method;
use crate::state::clock::TimeStep;
use crate::state::components::StableId;
use crate::state::substeps::Substeps;
use crate::tick::columns::{ObservedColumns, ObservedColumnsItem};

/// Why a world cannot be copied into plain arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotForArrays {
    /// There is no [`TimeStep`].
    NoTimeStep,
    /// There are [`RidingWells`]: arrays have no carriers.
    RidingWells,
}

impl fmt::Display for NotForArrays {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::NoTimeStep => "the world has no TimeStep: insert one before it is taken into plain arrays",
            Self::RidingWells => {
                "the world has wells that ride on bodies, which plain arrays cannot carry: use a world"
            }
        })
    }
}

impl std::error::Error for NotForArrays {}

/// Laws of single bodies.
pub type LawsOf<'a> = &'a dyn Fn(Entity) -> Vec<Box<dyn Law>>;

impl Bare {
    /// Copies the bodies, their options, and the forces and laws on them; `last_steps` are those of the world, even
    /// of methods that do not use them.
    pub(super) fn gathered(
        world: &mut World,
        method: Method,
        laws: LawsOf<'_>,
        shared: Vec<Box<dyn Law>>,
    ) -> Result<Self, NotForArrays> {
        let TimeStep(step) = *world.get_resource().ok_or(NotForArrays::NoTimeStep)?;
        if world.contains_resource::<RidingWells>() {
            return Err(NotForArrays::RidingWells);
        }
        update_groups(world, true);
        let mut bare = Self::new(method, 1.0);
        bare.step = step;
        bare.substeps = Substeps::count(world.get_resource());
        bare.clock = world.get_resource().copied().unwrap_or_default();
        let resources = &mut bare.resources;
        resources.gravity = world.get_resource::<Gravity>().copied();
        resources.world_laws = WorldLaws::of(world);
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

    /// Adds every body; returns their rows.
    fn add_bodies(&mut self, world: &mut World, laws: LawsOf<'_>) -> EntityHashMap<usize> {
        let mut bodies = world.query::<ObservedColumns>();
        let world = &*world;
        let mut all: Vec<_> = bodies.iter(world).collect();
        all.sort_unstable_by_key(ObservedColumnsItem::key);
        let mut rows = EntityHashMap::default();
        for row in &all {
            let [a, b, c] = row.body.velocity.to_array();
            rows.insert(row.entity, self.bodies.len());
            self.positions.push(row.transform.position.to_array());
            self.bodies.push([a, b, c, row.body.inverse_mass]);
            self.ids.push(StableId(row.key().0));
            self.last_steps.push(row.last_step.map_or(0.0, |last| last.0));
            let options = row.options.options();
            let BodyOptions { gravity_off, substeps, .. } = options;
            let has_laws = row.options.laws.is_some();
            let is_more = BodyOptions { gravity_off: false, ..options }.changes_row();
            let own = (is_more || has_laws || substeps.is_some())
                .then_some(self.individuals.own_options.len());
            if own.is_some() {
                let laws = if has_laws { laws(row.entity) } else { Vec::new() };
                self.individuals
                    .own_options
                    .push(OwnOptions { options: options.without_laws(), laws });
            }
            self.individuals.kinds.push(Kind {
                method: row.method(world),
                gravity_off,
                own,
                apart: row.grouped || row.quarantined || row.dormant,
                born: None,
            });
        }
        if self.last_steps.iter().all(|step| *step == 0.0) {
            self.last_steps.clear();
        }
        rows
    }

    fn join(&mut self, groups: &Groups, rows: &EntityHashMap<usize>) {
        for Group { coupling, bodies, substeps, .. } in &groups.list {
            let rows: Vec<_> = bodies.iter().filter_map(|body| rows.get(body).copied()).collect();
            let movable = || (0..).zip(&rows[..coupling.movable]);
            let rows_that = |has: &dyn Fn(BodyOptions<'_>) -> bool| {
                let such = movable().filter(|(_, row)| has(self.individuals.row(**row)));
                such.map(|(own, _)| own).collect()
            };
            let with_options = rows_that(&|options| options.changes_row());
            let with_laws = rows_that(&|options| !options.laws.is_empty());
            let method = rows.first().and_then(|row| self.individuals.kinds[*row].method);
            let coupling = coupling.clone();
            self.groups.push(ArrayGroup {
                coupling,
                rows,
                with_options,
                with_laws,
                substeps: *substeps,
                method,
                ..ArrayGroup::default()
            });
        }
    }
}
