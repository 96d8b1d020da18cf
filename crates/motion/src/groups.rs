//! Groups: bodies that act on each other, integrated together.
//!
//! A group is a connected component of the graph whose edges are springs and mutual gravity between movable bodies.
//! Immovable bodies are anchors and connect nothing. A group has one method and one number of substeps: those of its
//! member with the lowest id. Its rows are copied out of the tables, integrated, and copied back, all or none.

mod combination;
mod compile;
mod coupling;
mod direct_sum;
mod field;
mod lanes;
mod linear;
mod members;
mod places;
mod pull;
mod rescue;
mod rows;
mod solver;
mod split;
mod suspects;
mod system;

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;

pub use compile::compile_groups;
pub(crate) use compile::{
    Coupled, coming_couplings, couplings, is_outdated, members, update_groups,
};
pub(crate) use coupling::Coupling;
pub(crate) use field::{GroupCache, GroupKernel, Scratch, bisect_end, equal_parts};
use lanes::Bundles;
pub(crate) use linear::{Contributor, LinearGroup, Terms};
use places::{Place, TableRun, Unit};
use pull::Share;
pub(crate) use pull::{SpringRow, pulls};
pub(crate) use rows::{Row, RowArray, row_of};
pub use solver::Solver;
pub use split::Sets;
pub(crate) use system::integrate_groups;

pub use crate::state::coupling::Grouped;

use crate::laws::{BodyState, MutualGravity};
use crate::state::components::{PhysicsBody, Transform};
use crate::units::Scalar;

/// The groups of a world, compiled from its springs, soft bodies and mutual gravity; absent in a world without them.
#[derive(Resource, Debug, Default)]
pub struct Groups {
    /// Whether the world had springs, bodies that choose their substeps, and mutual gravity, at the last check.
    reasons: (bool, bool, bool),
    pub(crate) list: Vec<Group>,
    /// The tables that hold rows of groups, ascending.
    places: Vec<Place>,
    /// The places of the movable rows of groups that are integrated alone, by table and row.
    runs: Vec<TableRun>,
    /// Groups and bundles in the order in which they are integrated: by group number, a bundle at its first group.
    units: Vec<Unit>,
    /// Groups that are integrated side by side.
    bundles: Bundles,
    /// The number of rows of groups that are in no bundle.
    alone: usize,
    /// The rows of groups that are integrated alone, one group after the other.
    x: RowArray,
    v: RowArray,
    w: Vec<Scalar>,
    last: Vec<Scalar>,
    /// `x`, `v` and `last` of a group that chooses its substeps, at the start of the tick.
    start: (RowArray, RowArray, Vec<Scalar>),
    /// Number of movable rows that the running system has found, per group outside bundles.
    seen: Vec<usize>,
    /// Group, row and force, N, of every pushed row.
    pushes: Vec<(usize, usize, Row)>,
    scratch: Scratch,
}

/// One group.
#[derive(Debug, Default)]
pub(crate) struct Group {
    /// Its first row among the rows of groups that are integrated alone.
    first: usize,
    pub coupling: Coupling,
    /// Its bodies by row, movable ones first, then anchors, each in the order of stable ids.
    pub bodies: Vec<Entity>,
    /// Rows with options other than own laws and substeps.
    with_options: Vec<u32>,
    /// Rows with own laws.
    with_laws: Vec<u32>,
    /// Its own number of substeps.
    pub substeps: Option<u32>,
    /// Whether it chooses the number in every tick.
    chooses_substeps: bool,
    cache: GroupCache,
    /// How many threads share its springs, if it is large, and their shares; made in the first tick.
    shares: (usize, Vec<Share>),
}

impl Groups {
    /// The number of groups.
    #[must_use]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether the world has no groups.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The number of springs in all groups, without inert ones.
    #[must_use]
    pub fn springs(&self) -> usize {
        self.list.iter().map(|group| group.coupling.springs.len()).sum()
    }

    /// The number of bodies that move in groups.
    #[must_use]
    pub fn bodies(&self) -> usize {
        self.list.iter().map(|group| group.coupling.movable).sum()
    }

    /// The number of groups that are in a bundle with others of the same shape.
    #[must_use]
    pub fn side_by_side(&self) -> usize {
        self.bundles.list.iter().map(|bundle| bundle.groups.len()).sum()
    }

    /// Allocated bytes of the lists of springs and of the arrays of rows.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let lists: usize = self.list.iter().map(|group| group.coupling.bytes()).sum();
        let arrays = size_of_val(&*self.x) + size_of_val(&*self.v);
        lists
            + arrays
            + (self.w.capacity() + self.last.capacity()) * size_of::<Scalar>()
            + self.scratch.bytes()
            + self.bundles.bytes()
    }

    /// `bodies` and all members of their groups, each once.
    pub(crate) fn with_members(world: &World, bodies: &[Entity]) -> Vec<Entity> {
        let mut alone: EntityHashSet = bodies.iter().copied().collect();
        let mut all = Vec::new();
        for Group { bodies, coupling, .. } in
            world.get_resource::<Self>().into_iter().flat_map(|all| &all.list)
        {
            if alone.is_empty() {
                break;
            }
            let members = &bodies[..coupling.movable];
            // `count` instead of `any`, which would stop before every member is removed from `alone`.
            if members.iter().filter(|member| alone.remove(*member)).count() > 0 {
                all.extend(members);
            }
        }
        all.extend(bodies.iter().filter(|body| alone.remove(*body)));
        all
    }
}

/// Potential energy of springs and mutual gravity, J.
pub(crate) fn potential_energy(world: &World) -> Scalar {
    let gravity = world.get_resource::<MutualGravity>();
    let coming = coming_couplings(world);
    let energy = |(coupling, bodies): (&Coupling, &[Entity])| {
        let states = states_of(world, bodies).into_iter();
        let (x, w): (Vec<_>, Vec<_>) =
            states.map(|state| (row_of(state.position), state.inverse_mass)).unzip();
        coupling.potential_energy(gravity, &x, &w)
    };
    // A sum without terms is -0.
    couplings(world, coming.as_deref()).map(energy).fold(0.0, |sum, energy| sum + energy)
}

/// The states of bodies; a removed body counts as immovable at the origin.
pub(crate) fn states_of(world: &World, bodies: &[Entity]) -> Vec<BodyState> {
    let state = |body: &Entity| {
        let PhysicsBody { velocity, inverse_mass } =
            world.get(*body).copied().unwrap_or(PhysicsBody::IMMOVABLE);
        let position = world.get::<Transform>(*body).copied().unwrap_or_default().position;
        BodyState { position, velocity, inverse_mass }
    };
    bodies.iter().map(state).collect()
}
