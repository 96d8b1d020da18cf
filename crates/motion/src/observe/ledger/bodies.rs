//! What the books read of the world: every body at both ends of a tick.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;

use crate::laws::BodyState;
use crate::laws::damping::DampingRate;
use crate::laws::own::OwnLaws;
use crate::methods::markers::{OwnMethod, own_method};
use crate::methods::table::Method;
use crate::methods::{Integrator, with_method};
use crate::state::clock::StepClock;
use crate::state::components::{
    AxisLocks, Force, GravityOff, PhysicsBody, Quarantined, SpeedLimit, StableId, Transform,
};
use crate::state::emitter::{Dormant, Emissions};
use crate::state::forces::PushQueue;
use crate::units::{Scalar, Vector};

/// Position, m, and velocity, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct State {
    pub position: Vector,
    pub velocity: Vector,
}

impl State {
    fn of(transform: &Transform, body: &PhysicsBody) -> Self {
        Self { position: transform.position, velocity: body.velocity }
    }
}

/// Stable id, and the entity where there is none.
type Key = (u32, Entity);

fn key(id: Option<&StableId>, entity: Entity) -> Key {
    (id.map_or(u32::MAX, |id| id.0), entity)
}

/// The bodies at the start of a tick and what they are pushed with, in stable-id order.
#[derive(Debug, Default)]
pub(super) struct Opening {
    rows: Vec<(Key, State, Vector)>,
    /// Bodies that are born in the tick, and when, s since the scene's start.
    births: EntityHashMap<Scalar>,
}

impl Opening {
    pub fn of(world: &mut World) -> Self {
        type Row =
            (Entity, Option<&'static StableId>, &'static Transform, &'static PhysicsBody, &'static Force);
        let mut bodies = world.query_filtered::<Row, Without<Dormant>>();
        let mut pushes = EntityHashMap::<Vector>::default();
        for push in world.get_resource::<PushQueue>().into_iter().flat_map(PushQueue::pending) {
            *pushes.entry(push.body).or_default() += push.newtons;
        }
        let row = |(entity, id, transform, body, force): (
            Entity,
            Option<&StableId>,
            &Transform,
            &PhysicsBody,
            &Force,
        )| {
            let queued = pushes.get(&entity).copied().unwrap_or_default();
            (key(id, entity), State::of(transform, body), force.newtons() + queued)
        };
        let mut rows: Vec<_> = bodies.iter(world).map(row).collect();
        rows.sort_unstable_by_key(|(key, ..)| *key);
        let tick = world.get_resource().map_or(0, StepClock::ticks);
        let births = world.get_resource::<Emissions>().map_or(&[][..], |emissions| emissions.births_in(tick));
        Self { rows, births: births.iter().copied().collect() }
    }

    /// One body; `None`: it was not there.
    fn find(&self, key: Key, near: usize) -> Option<(State, Vector)> {
        // Nothing comes or goes in a tick: it stands where it is looked for.
        let row = self.rows.get(near).filter(|(found, ..)| *found == key).or_else(|| {
            let row = self.rows.binary_search_by_key(&key, |(key, ..)| *key).ok()?;
            self.rows.get(row)
        });
        row.map(|(_, state, push)| (*state, *push))
    }
}

/// A body and its tick.
#[derive(Debug)]
pub(super) struct Body<'w> {
    pub entity: Entity,
    /// At the start and at the end of the tick.
    pub ends: [State; 2],
    /// When it is born, s since the scene's start, if it is in the tick: its tick starts then.
    pub born: Option<Scalar>,
    /// 1/kg; 0 is immovable.
    pub inverse_mass: Scalar,
    /// Applied force, N.
    pub push: Vector,
    /// Whether it is in quarantine.
    pub frozen: bool,
    pub gravity_off: bool,
    /// Its own damping rate, 1/s.
    pub rate: Option<Scalar>,
    /// Axes along which nothing accelerates it.
    pub closed: Option<AxisLocks>,
    /// Its own method.
    pub method: Option<Method>,
    pub laws: Option<&'w OwnLaws>,
    /// Whether drag acts on its triangles and not on it.
    pub in_sheet: bool,
}

impl Body<'_> {
    pub fn is_movable(&self) -> bool {
        self.inverse_mass > 0.0
    }

    /// Whether forces move it.
    pub fn acts(&self) -> bool {
        self.is_movable() && !self.frozen
    }

    /// kg.
    pub fn mass(&self) -> Scalar {
        1.0 / self.inverse_mass
    }

    /// For laws.
    pub fn state(&self, State { position, velocity }: State) -> BodyState<Scalar> {
        BodyState { position, velocity, inverse_mass: self.inverse_mass }
    }

    /// What is left of a force or an acceleration where the body is not accelerated along every axis.
    pub fn open(&self, v: Vector) -> Vector {
        self.closed.map_or(v, |closed| closed.open(v))
    }
}

type Columns = (
    Entity,
    Option<&'static StableId>,
    &'static Transform,
    &'static PhysicsBody,
    Has<Quarantined>,
    Has<GravityOff>,
    Option<&'static DampingRate>,
    Option<&'static SpeedLimit>,
    Option<&'static AxisLocks>,
    Has<OwnMethod>,
    Option<&'static OwnLaws>,
);

/// Looks bodies up.
pub(super) type Bodies = QueryState<Columns, Without<Dormant>>;

/// Every body that is there at the end of a tick, in stable-id order. One that was not there at its start, or was
/// frozen in it, has the end for a start: what happened to it is no work.
pub(super) fn bodies<'w>(
    world: &'w World,
    query: &mut Bodies,
    world_method: Method,
    opening: &Opening,
) -> Vec<Body<'w>> {
    let mut rows: Vec<_> = query
        .iter(world)
        .map(|(entity, id, transform, body, frozen, gravity_off, rate, limit, locks, marked, laws)| {
            let end = State::of(transform, body);
            let method = if marked { world.get_entity(entity).ok().and_then(own_method) } else { None };
            let limits_after_kick = with_method!(method.unwrap_or(world_method), M => M::LIMITS_AFTER_KICK);
            let closed = locks.copied().filter(|_| !(limit.is_some() && limits_after_kick));
            let body = Body {
                entity,
                ends: [end; 2],
                born: opening.births.get(&entity).copied(),
                inverse_mass: body.inverse_mass,
                push: Vector::ZERO,
                frozen,
                gravity_off,
                rate: rate.map(DampingRate::rate),
                closed,
                method,
                laws,
                in_sheet: false,
            };
            (key(id, entity), body)
        })
        .collect();
    rows.sort_unstable_by_key(|(key, _)| *key);
    for (number, (key, body)) in rows.iter_mut().enumerate() {
        if let Some((start, push)) = opening.find(*key, number).filter(|_| !body.frozen) {
            (body.ends[0], body.push) = (start, push);
        }
    }
    rows.into_iter().map(|(_, body)| body).collect()
}
