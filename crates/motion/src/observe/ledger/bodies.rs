//! The bodies of a ledger: their states at both ends of a tick.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

use crate::kernels::BodyOptions;
use crate::laws::BodyState;
use crate::methods::table::Method;
use crate::state::clock::StepClock;
use crate::state::components::{AxisLocks, Force};
use crate::state::emitter::{Dormant, Emissions};
use crate::state::forces::{PushQueue, sum_by_body};
use crate::tick::columns::{NO_STEPPER, ObservedColumns, observed};
use crate::units::{Scalar, Vector};

/// A point of phase space: position, m, and velocity, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PhasePoint {
    pub position: Vector,
    pub velocity: Vector,
}

impl From<BodyState> for PhasePoint {
    fn from(BodyState { position, velocity, .. }: BodyState) -> Self {
        Self { position, velocity }
    }
}

/// Key of the order of sums: the stable id, then the entity.
type Key = (u32, Entity);

/// The bodies at the start of a tick and the applied forces on them, in stable-id order.
#[derive(Debug, Default)]
pub(super) struct Opening {
    rows: Vec<(Key, PhasePoint, Vector)>,
    /// Times of birth of the bodies that are born in the tick, s since the start of the scene.
    births: EntityHashMap<Scalar>,
}

impl Opening {
    pub fn of(world: &World) -> Self {
        let mut bodies = world
            .try_query_filtered::<(ObservedColumns, &Force), Without<Dormant>>()
            .expect(NO_STEPPER);
        let queued = world.get_resource::<PushQueue>().into_iter().flat_map(PushQueue::pending);
        let queued = sum_by_body(queued);
        let mut rows: Vec<_> = bodies
            .iter(world)
            .map(|(row, force)| {
                let push = force.newtons() + queued.get(&row.entity).copied().unwrap_or_default();
                (row.key(), row.state().into(), push)
            })
            .collect();
        rows.sort_unstable_by_key(|(key, ..)| *key);
        let tick = world.get_resource().map_or(0, StepClock::ticks);
        let births = world
            .get_resource::<Emissions>()
            .map_or(&[][..], |emissions| emissions.births_in(tick));
        Self { rows, births: births.iter().copied().collect() }
    }

    /// One body, or `None` if it did not exist. `near` is its probable index.
    fn find(&self, key: Key, near: usize) -> Option<(PhasePoint, Vector)> {
        // Bodies seldom come or go within a tick, so that the probable index is usually right.
        let row = self.rows.get(near).filter(|(found, ..)| *found == key).or_else(|| {
            let row = self.rows.binary_search_by_key(&key, |(key, ..)| *key).ok()?;
            self.rows.get(row)
        });
        row.map(|(_, state, push)| (*state, *push))
    }
}

/// A body over one tick.
#[derive(Debug)]
pub(super) struct BodyTick<'w> {
    pub entity: Entity,
    /// State at the start and at the end of the tick.
    pub ends: [PhasePoint; 2],
    /// Time of birth, s since the start of the scene, if it is within the tick: the tick of the body starts then.
    pub born: Option<Scalar>,
    /// Reciprocal of the mass, 1/kg; 0 is immovable.
    pub inverse_mass: Scalar,
    /// Applied force, N.
    pub push: Vector,
    pub quarantined: bool,
    pub options: BodyOptions<'w>,
    /// Locked axes, unless the speed limit sees the velocity along them first.
    pub locks: Option<AxisLocks>,
    /// Its own method.
    pub method: Option<Method>,
    /// Whether drag acts on the triangles of its sheet instead of on it.
    pub in_sheet: bool,
}

impl BodyTick<'_> {
    pub fn is_movable(&self) -> bool {
        self.inverse_mass > 0.0
    }

    /// Mass, kg.
    pub fn mass(&self) -> Scalar {
        1.0 / self.inverse_mass
    }

    /// The state at which laws are evaluated.
    pub fn state(&self, PhasePoint { position, velocity }: PhasePoint) -> BodyState {
        BodyState { position, velocity, inverse_mass: self.inverse_mass }
    }

    /// Returns a force or an acceleration without its components along locked axes.
    pub fn along_open_axes(&self, v: Vector) -> Vector {
        self.locks.map_or(v, |locks| locks.along_open_axes(v))
    }
}

/// Every body that exists at the end of a tick, in stable-id order. For a body that did not exist at the start, or is
/// quarantined, the start equals the end: its change is an intervention and not work.
pub(super) fn bodies<'w>(
    world: &'w World,
    world_method: Method,
    opening: &Opening,
) -> Vec<BodyTick<'w>> {
    let mut rows: Vec<_> = observed::<Without<Dormant>>(world)
        .iter(world)
        .map(|row| {
            let (options, method) = (row.options.options(), row.method(world));
            let limits_after_kick = method.unwrap_or(world_method).traits().limits_after_kick;
            let body = BodyTick {
                entity: row.entity,
                ends: [row.state().into(); 2],
                born: opening.births.get(&row.entity).copied(),
                inverse_mass: row.body.inverse_mass,
                push: Vector::ZERO,
                quarantined: row.quarantined,
                options,
                locks: options.closed_axes(limits_after_kick),
                method,
                in_sheet: false,
            };
            (row.key(), body)
        })
        .collect();
    rows.sort_unstable_by_key(|(key, _)| *key);
    for (number, (key, body)) in rows.iter_mut().enumerate() {
        if let Some((start, push)) = opening.find(*key, number).filter(|_| !body.quarantined) {
            (body.ends[0], body.push) = (start, push);
        }
    }
    rows.into_iter().map(|(_, body)| body).collect()
}
