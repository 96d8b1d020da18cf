//! The columns of bodies that a tick reads and writes.

use bevy_ecs::prelude::*;
use bevy_ecs::query::{QueryData, QueryFilter};

use crate::kernels::{BodyOptions, RowOptions};
use crate::laws::BodyState;
use crate::laws::damping::DampingRate;
use crate::laws::own::OwnLaws;
use crate::methods::markers::{OwnMethod, own_method};
use crate::methods::table::Method;
use crate::state::components::{
    AxisLocks, Force, GravityOff, PhysicsBody, Quarantined, SpeedLimit, StableId, Transform,
};
use crate::state::coupling::Grouped;
use crate::state::emitter::Dormant;
use crate::state::method_state::{LastAcceleration, LastStep};
use crate::state::static_bodies::Static;
use crate::state::substeps::OwnSubsteps;

/// The columns of a body's options, which most bodies lack.
#[derive(QueryData)]
#[query_data(contiguous(all))]
pub struct OptionColumns {
    gravity_off: Has<GravityOff>,
    damping_rate: Option<&'static DampingRate>,
    speed_limit: Option<&'static SpeedLimit>,
    locks: Option<&'static AxisLocks>,
    pub(crate) laws: Option<&'static OwnLaws>,
    substeps: Option<&'static OwnSubsteps>,
}

/// The columns of a body that a tick may need.
#[derive(QueryData)]
#[query_data(mutable, contiguous(mutable))]
pub struct BodyColumns {
    /// The body.
    pub entity: Entity,
    pub(super) transform: &'static mut Transform,
    pub(super) body: &'static mut PhysicsBody,
    pub(super) force: &'static Force,
    pub(super) options: OptionColumns,
    pub(super) last_step: Option<&'static mut LastStep>,
    pub(super) last_acceleration: Option<&'static mut LastAcceleration>,
}

/// The columns of a body that observers read.
#[derive(QueryData)]
pub(crate) struct ObservedColumns {
    pub entity: Entity,
    pub id: Option<&'static StableId>,
    pub transform: &'static Transform,
    pub body: &'static PhysicsBody,
    pub options: OptionColumns,
    pub last_step: Option<&'static LastStep>,
    marked: Has<OwnMethod>,
    pub grouped: Has<Grouped>,
    pub quarantined: Has<Quarantined>,
    pub dormant: Has<Dormant>,
}

/// Registers the components that queries of observers name: a query over one that is not registered finds nothing.
pub(crate) fn register_observed(world: &mut World) {
    drop(world.query_filtered::<(ObservedColumns, &Force), Without<Static>>());
}

/// Why a query for observers cannot be made.
pub(crate) const NO_STEPPER: &str =
    "nothing can be observed in a world without a stepper; make a `Stepper` for it first";

/// The bodies of `world` that pass the filter, for observers, which change nothing.
///
/// # Panics
/// If no stepper was made for `world`.
pub(crate) fn observed<F: QueryFilter>(world: &World) -> QueryState<ObservedColumns, F> {
    world.try_query_filtered().expect(NO_STEPPER)
}

impl ObservedColumnsItem<'_, '_> {
    /// The state of the body.
    pub fn state(&self) -> BodyState {
        let PhysicsBody { velocity, inverse_mass } = *self.body;
        BodyState { position: self.transform.position, velocity, inverse_mass }
    }

    /// The own method of the body, if it has one.
    pub fn method(&self, world: &World) -> Option<Method> {
        if self.marked { own_method(world.entity(self.entity)) } else { None }
    }

    /// Key of the order of sums: the stable id, then the entity.
    pub fn key(&self) -> (u32, Entity) {
        (self.id.map_or(u32::MAX, |id| id.0), self.entity)
    }
}

/// The options of one body.
pub(crate) fn options_of(body: EntityRef<'_>) -> BodyOptions<'_> {
    let columns = OptionColumnsItem {
        gravity_off: body.contains::<GravityOff>(),
        damping_rate: body.get(),
        speed_limit: body.get(),
        locks: body.get(),
        laws: body.get(),
        substeps: body.get(),
    };
    columns.options()
}

impl<'w> OptionColumnsItem<'w, '_> {
    pub(crate) fn options(&self) -> BodyOptions<'w> {
        BodyOptions {
            gravity_off: self.gravity_off,
            damping_rate: self.damping_rate.map(DampingRate::rate),
            speed_limit: self.speed_limit.map(|limit| limit.0),
            locks: self.locks.copied(),
            laws: self.laws.map_or(&[], OwnLaws::laws),
            laws_version: self.laws.map_or(0, OwnLaws::version),
            substeps: self.substeps.map(|substeps| substeps.0.max(1)),
        }
    }
}

impl OptionColumnsContiguousItem<'_, '_> {
    /// Whether gravity does not act on the bodies of the table.
    pub(super) const fn gravity_off(&self) -> bool {
        self.gravity_off
    }

    /// Whether the table has a column of any other option.
    pub(super) const fn is_more(&self) -> bool {
        self.damping_rate.is_some()
            || self.speed_limit.is_some()
            || self.locks.is_some()
            || self.laws.is_some()
            || self.substeps.is_some()
    }
}

impl RowOptions for OptionColumnsContiguousItem<'_, '_> {
    fn row(&self, row: usize) -> BodyOptions<'_> {
        let row = OptionColumnsItem {
            gravity_off: self.gravity_off,
            damping_rate: self.damping_rate.map(|rates| &rates[row]),
            speed_limit: self.speed_limit.map(|limits| &limits[row]),
            locks: self.locks.map(|locks| &locks[row]),
            laws: self.laws.map(|laws| &laws[row]),
            substeps: self.substeps.map(|substeps| &substeps[row]),
        };
        row.options()
    }
}
