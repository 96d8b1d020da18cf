//! The four systems of a tick, in the tutorial's words, and the schedules that order them.

use std::slice;

use bevy_ecs::entity::Entities;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use bevy_ecs::system::SystemParam;

use crate::components::{AxisLocks, Force, GravityOff, PhysicsBody, Quarantined, SpeedLimit, Transform};
use crate::effects::{Damping, DampingRate, Decay, Gravity};
use crate::forces::{Forces, PushQueue, PushedBodies};
use crate::kernels::{Accelerate, Applied, Move, OnePass};
use crate::quarantine::{Cause, Quarantine, quarantine_bodies};
use crate::units::{Scalar, Vector};

const DENSE: &str = "every component of a body is stored in tables";

/// Length of a tick, s: positive and finite.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct TimeStep(pub Scalar);

/// Integration methods that the schedule offers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// Velocity first, then position with the new velocity: order 1, symplectic (Hairer, Lubich, Wanner 2003).
    #[default]
    SemiImplicitEuler,
    /// Position with the old velocity first, then velocity: order 1, gains energy on every oscillation.
    ExplicitEuler,
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 2] = [Self::SemiImplicitEuler, Self::ExplicitEuler];

    /// The word for it in scene files, flags and panels.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SemiImplicitEuler => "semi_implicit_euler",
            Self::ExplicitEuler => "explicit_euler",
        }
    }

    /// The method of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }
}

/// The schedule of one tick.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Step;

/// How the two middle systems of a tick are run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Passes {
    /// One after the other, each over all bodies, as the tutorial has it.
    #[default]
    Two,
    /// [`integrate_in_one_pass`]: the same arithmetic, half the memory traffic.
    One,
}

impl Passes {
    /// Bodies from which one pass is taken. It measured faster at every size (bench `motion_step`): 1.25 times
    /// at 100,000 bodies, 1.7 times at a million. Below this number the gain is under a tenth of a
    /// microsecond, and the four systems of the tutorial stay separate to be seen and stepped through.
    pub const CROSSOVER: usize = 256;

    /// What the plan takes for a world of `bodies` bodies.
    #[must_use]
    pub const fn for_bodies(bodies: usize) -> Self {
        if bodies < Self::CROSSOVER { Self::Two } else { Self::One }
    }
}

/// Compiles the schedule of one tick. Two systems that touch the same data without a stated order are an error
/// when it is initialized, and it runs on one thread: a multi-threaded executor costs more per system than a
/// thousand bodies do.
#[must_use]
pub fn step_schedule(method: Method, passes: Passes) -> Schedule {
    let mut schedule = Schedule::new(Step);
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.set_build_settings(ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..Default::default()
    });
    let middle = match (passes, method) {
        (Passes::Two, Method::SemiImplicitEuler) => (integrate_acceleration, integrate_velocity).chain(),
        (Passes::Two, Method::ExplicitEuler) => (integrate_velocity, integrate_acceleration).chain(),
        (Passes::One, Method::SemiImplicitEuler) => integrate_in_one_pass::<false>.into_configs(),
        (Passes::One, Method::ExplicitEuler) => integrate_in_one_pass::<true>.into_configs(),
    };
    schedule.add_systems((apply_forces, middle, clear_forces, quarantine_bodies).chain());
    schedule
}

/// Inserts the resources that the systems of a tick need; [`Gravity`] and [`Damping`] are the scene's to add.
pub fn insert_step_resources(world: &mut World, step: TimeStep) {
    world.insert_resource(step);
    world.init_resource::<PushQueue>();
    world.init_resource::<PushedBodies>();
    world.init_resource::<Quarantine>();
}

/// Turns queued pushes into the forces of this tick.
pub fn apply_forces(mut queue: ResMut<PushQueue>, mut forces: Forces) {
    for push in queue.bypass_change_detection().take() {
        forces.add(push.body, push.newtons);
    }
}

/// What acts in a tick besides the applied forces.
#[derive(SystemParam)]
pub struct Laws<'w, 's> {
    step: Res<'w, TimeStep>,
    gravity: Option<Res<'w, Gravity>>,
    damping: Option<Res<'w, Damping>>,
    pushed: Res<'w, PushedBodies>,
    entities: &'w Entities,
    /// Table and row of the pushed bodies, ascending; kept, so that a tick allocates nothing.
    rows: Local<'s, Vec<(usize, usize)>>,
}

/// [`Laws`] as plain numbers, taken out once a tick.
struct Tick {
    h: Scalar,
    gravity: Option<Vector>,
    damping: Option<Damping>,
    decay: Decay,
    forced: bool,
}

impl Laws<'_, '_> {
    fn of_tick(&self) -> Tick {
        let TimeStep(h) = *self.step;
        let damping = self.damping.as_deref().copied();
        Tick {
            h,
            gravity: self.gravity.as_deref().and_then(Gravity::acting),
            damping,
            decay: damping.map_or(Decay::none(h), |damping| damping.factors(h)),
            forced: !self.pushed.0.is_empty(),
        }
    }

    /// Looks up where the pushed bodies are.
    fn find_pushed(&mut self) {
        let Self { pushed, entities, rows, .. } = self;
        let place = |body: &Entity| {
            let place = entities.get_spawned(*body).ok()?;
            Some((place.table_id.as_usize(), place.table_row.index()))
        };
        rows.clear();
        rows.extend(pushed.0.iter().filter_map(place));
        rows.sort_unstable();
    }

    /// What was pushed of the table that holds `body`.
    fn applied<'a>(&'a self, body: Entity, forces: &'a [Force]) -> Option<Applied<'a>> {
        if self.rows.is_empty() {
            return None;
        }
        let table = self.entities.get_spawned(body).ok()?.table_id.as_usize();
        let start = self.rows.partition_point(|(other, _)| *other < table);
        let end = self.rows.partition_point(|(other, _)| *other <= table);
        Some(Applied { forces, rows: &self.rows[start..end] })
    }
}

impl Tick {
    fn nothing_accelerates(&self) -> bool {
        !self.forced && self.gravity.is_none() && self.decay.keep.is_none()
    }

    fn acceleration(&self, gravity_off: bool, decay: Decay) -> Accelerate {
        Accelerate::new(if gravity_off { None } else { self.gravity }, decay)
    }

    fn decay_of(&self, rate: Option<&mut DampingRate>) -> Decay {
        match (rate, self.damping) {
            (Some(rate), Some(damping)) => rate.factors(damping.model, self.h),
            _ => self.decay,
        }
    }

    /// One row of [`integrate_acceleration`]; `false`: refused.
    fn accelerate(
        &self,
        gravity_off: bool,
        body: &mut PhysicsBody,
        force: &Force,
        rate: Option<&mut DampingRate>,
    ) -> bool {
        let mut ok = true;
        let update = self.acceleration(gravity_off, self.decay_of(rate));
        let applied = Applied { forces: slice::from_ref(force), rows: &[(0, 0)] };
        update.run(slice::from_mut(body), Some(applied), &mut |_| ok = false);
        ok
    }

    /// One row of [`integrate_velocity`]; `false`: refused.
    fn advance(
        &self,
        transform: &mut Transform,
        body: &mut PhysicsBody,
        rate: Option<&mut DampingRate>,
        limit: Option<&SpeedLimit>,
        locks: Option<&AxisLocks>,
    ) -> bool {
        let update = Move::new(self.h, self.decay_of(rate));
        update.run_asking(transform, body, limit.map(|limit| limit.0), locks)
    }
}

/// `v += (F w + g) h`: forces and gravity become acceleration, acceleration becomes velocity.
///
/// A body of inverse mass 0 is passed by whatever acts on it. With [`DampingModel::Exact`] the decay is part
/// of this update.
///
/// [`DampingModel::Exact`]: crate::DampingModel::Exact
pub fn integrate_acceleration(
    mut laws: Laws,
    mut quarantine: ResMut<Quarantine>,
    mut bodies: Query<
        (Entity, &Transform, &mut PhysicsBody, &Force, Option<&mut DampingRate>, Has<GravityOff>),
        Without<Quarantined>,
    >,
) {
    laws.find_pushed();
    let tick = laws.of_tick();
    if tick.nothing_accelerates() {
        return;
    }
    let tables = bodies.contiguous_iter_mut().expect(DENSE);
    for (entities, transforms, mut bodies, forces, rates, gravity_off) in tables {
        let bodies = bodies.bypass_change_detection();
        let mut refused = Vec::new();
        if let Some(mut rates) = rates {
            let rates = rates.bypass_change_detection();
            for (row, (body, rate)) in bodies.iter_mut().zip(rates).enumerate() {
                if !tick.accelerate(gravity_off, body, &forces[row], Some(rate)) {
                    refused.push(row);
                }
            }
        } else {
            let update = tick.acceleration(gravity_off, tick.decay);
            update.run(bodies, laws.applied(entities[0], forces), &mut |row| refused.push(row));
        }
        for row in refused {
            quarantine.refuse(entities[row], transforms[row], bodies[row], Cause::Velocity);
        }
    }
}

/// `x += v h`, with the damping, speed limit and axis locks that have their place around the move.
pub fn integrate_velocity(
    laws: Laws,
    mut quarantine: ResMut<Quarantine>,
    mut bodies: Query<
        (
            Entity,
            &mut Transform,
            &mut PhysicsBody,
            Option<&mut DampingRate>,
            Option<&SpeedLimit>,
            Option<&AxisLocks>,
        ),
        Without<Quarantined>,
    >,
) {
    let tick = laws.of_tick();
    let tables = bodies.contiguous_iter_mut().expect(DENSE);
    for (entities, mut transforms, mut bodies, mut rates, limits, locks) in tables {
        let (transforms, bodies) = (&mut *transforms, bodies.bypass_change_detection());
        let mut rates = rates.as_mut().map(|rates| rates.bypass_change_detection());
        let mut refused = Vec::new();
        if rates.is_none() && limits.is_none() && locks.is_none() {
            Move::new(tick.h, tick.decay).run(transforms, bodies, &mut |row| refused.push(row));
        } else {
            for (row, (transform, body)) in transforms.iter_mut().zip(&mut *bodies).enumerate() {
                let rate = rates.as_mut().map(|rates| &mut rates[row]);
                let (limit, locks) = (limits.map(|limits| &limits[row]), locks.map(|locks| &locks[row]));
                if !tick.advance(transform, body, rate, limit, locks) {
                    refused.push(row);
                }
            }
        }
        for row in refused {
            quarantine.refuse(entities[row], transforms[row], bodies[row], Cause::Position);
        }
    }
}

/// [`integrate_acceleration`] and [`integrate_velocity`] in one pass over memory, with the same bits;
/// `POSITION_FIRST` is the order of explicit Euler. Bodies that ask for something of their own are done row
/// by row.
pub fn integrate_in_one_pass<const POSITION_FIRST: bool>(
    mut laws: Laws,
    mut quarantine: ResMut<Quarantine>,
    mut bodies: Query<
        (
            Entity,
            &mut Transform,
            &mut PhysicsBody,
            &Force,
            Has<GravityOff>,
            Option<&mut DampingRate>,
            Option<&SpeedLimit>,
            Option<&AxisLocks>,
        ),
        Without<Quarantined>,
    >,
) {
    laws.find_pushed();
    let tick = laws.of_tick();
    let tables = bodies.contiguous_iter_mut().expect(DENSE);
    for (entities, mut transforms, mut bodies, forces, gravity_off, mut rates, limits, locks) in tables {
        let (transforms, bodies) = (&mut *transforms, bodies.bypass_change_detection());
        let mut rates = rates.as_mut().map(|rates| rates.bypass_change_detection());
        let mut row_by_row = Vec::new();
        if rates.is_none() && limits.is_none() && locks.is_none() {
            let update = OnePass {
                accelerate: tick.acceleration(gravity_off, tick.decay),
                advance: Move::new(tick.h, tick.decay),
                position_first: POSITION_FIRST,
            };
            // A refused row is done again, to say which of the two updates it was.
            let applied = laws.applied(entities[0], forces);
            update.run(transforms, bodies, applied, &mut |row| row_by_row.push(row));
        } else {
            row_by_row.extend(0..bodies.len());
        }
        for row in row_by_row {
            let (transform, body) = (&mut transforms[row], &mut bodies[row]);
            let (limit, locks) = (limits.map(|limits| &limits[row]), locks.map(|locks| &locks[row]));
            let order = if POSITION_FIRST {
                [Cause::Position, Cause::Velocity]
            } else {
                [Cause::Velocity, Cause::Position]
            };
            for update in order {
                let rate = rates.as_mut().map(|rates| &mut rates[row]);
                let ok = match update {
                    Cause::Velocity => {
                        tick.nothing_accelerates() && rate.is_none()
                            || tick.accelerate(gravity_off, body, &forces[row], rate)
                    }
                    _ => tick.advance(transform, body, rate, limit, locks),
                };
                if !ok {
                    quarantine.refuse(entities[row], *transform, *body, update);
                    break;
                }
            }
        }
    }
}

/// Forgets the forces of this tick; a push that is to last is added again in the next one.
pub fn clear_forces(mut forces: Forces) {
    forces.clear();
}
