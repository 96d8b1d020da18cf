//! Snapshots: the state of a world between two ticks as plain data, taken out and put back.
//!
//! A restored world continues with the bits of the world that the snapshot was taken of: for rollback in a network game, for
//! saving, for trying something out. Laws, springs (which have to be the same) and options of bodies, such as speed limits, are
//! not in a snapshot, only which effects are off: they stay as the world has them. Nor are cached accelerations: velocity
//! Verlet and Yoshida 4 evaluate them once more.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use motion::prelude::*;
//! use motion::{Transform, snapshot};
//!
//! let mut world = World::new();
//! world.insert_resource(Gravity::EARTH);
//! let ball = |x| (Transform::at(Vector::X * x), PhysicsBody::with_mass(1.0));
//! let ends = [world.spawn(ball(0.0)).id(), world.spawn(ball(2.0)).id()];
//! world.spawn(Spring { ends, elastic: Elastic::new(50.0, 1.0).damped(0.1) });
//! let mut stepper = Stepper::new(&mut world, Method::PositionVerlet, TimeStep(1.0 / 120.0));
//! let second = |world: &mut World, stepper: &mut Stepper| {
//!     (0..120).for_each(|_| stepper.tick(world));
//!     ends.map(|end| world.entity(end).components::<&Transform>().position.to_array().map(f64::to_bits))
//! };
//!
//! second(&mut world, &mut stepper);
//! let saved = snapshot::take(&world, &stepper);
//! let first = second(&mut world, &mut stepper);
//! snapshot::restore(&mut world, &mut stepper, &saved)?;
//! assert_eq!(second(&mut world, &mut stepper), first);
//! # Ok::<(), snapshot::RestoreError>(())
//! ```
//!
//! For a stepper that is [installed](Stepper::installed):
//!
//! ```
//! # use bevy_ecs::prelude::*;
//! # use motion::{Stepper, snapshot};
//! # fn save(world: &mut World) -> snapshot::Snapshot {
//! Stepper::installed(world, |stepper, world| snapshot::take(world, stepper))
//! # }
//! ```

use std::cell::RefCell;
use std::fmt;

use bevy_ecs::component::Mutable;
use bevy_ecs::entity::{EntityHashMap, EntityHashSet, EntityMapper, MapEntities};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::kernels::evaluations::Evaluations;
use crate::laws::Gravity;
use crate::laws::damping::Damping;
#[cfg(feature = "serde")]
use crate::lists::list;
use crate::methods::markers::{OwnMethod, mark_method, own_method};
use crate::methods::table::Method;
use crate::schedule::effects::{self, Effect, EffectState};
use crate::schedule::emission::orphans;
use crate::schedule::requests::{Request, Requests};
use crate::schedule::stepper::Stepper;
use crate::state::archetypes::{collect, values};
use crate::state::clock::{ClockState, StepClock, TimeStep};
use crate::state::components::{PhysicsBody, Quarantined, Transform};
use crate::state::coupling::CouplingChanged;
use crate::state::emitter::{Dormant, Emission, Emissions};
use crate::state::forces::{Push, PushQueue, PushedBodies};
use crate::state::previous_position::PreviousPosition;
use crate::state::springs::{SoftBody, Spring};
use crate::state::substeps::{AutoSubsteps, OwnSubsteps, Substeps};
use crate::tick::columns::NO_STEPPER;
use crate::tick::quarantine::{Quarantine, QuarantineRecord};

pub use crate::state::emitter::EmissionState;
pub use crate::state::method_state::{LastAcceleration, LastStep};
#[doc(hidden)]
pub use crate::state::switched_off::{Off, OffResource, SpringsOff};

/// The state of a world between two ticks. `B` names bodies and emitters, `Bodies` is a list of bodies, and `Log` is a
/// component of another crate that is saved, too: see [`take_with`].
///
/// To restore it into another world, give it the entities of the other world by [`MapEntities::map_entities`], for example
/// with an `EntityHashMap<Entity>`. Files need names that are the same in every world: see [`Snapshot::rename`]. The feature
/// `serde` writes and reads a snapshot with such names; `lists::within` limits the memory that its lists take.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(default))]
#[cfg_attr(
    feature = "serde",
    serde(bound(serialize = "B: Clone + Serialize, Bodies: Serialize, Log: Serialize"))
)]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        deserialize = "B: Default + Deserialize<'de>, Bodies: Default + Deserialize<'de>, Log: Default + Deserialize<'de>"
    ))
)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Snapshot<B = Entity, Bodies = Vec<B>, Log = NoLog> {
    /// The clock of ticks.
    pub clock: ClockState,
    /// Length of a tick.
    #[cfg_attr(feature = "serde", serde(rename = "step_s"))]
    pub step: TimeStep,
    /// The method of bodies without their own.
    pub method: Method,
    /// The type of the stepper's method, if that is [of your own](Stepper::of).
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub integrator: Option<String>,
    /// A checksum of the springs and of those of soft bodies between `bodies`. `None` is not compared.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub springs: Option<u64>,
    /// What [`roll_back`] puts back beside the state; `None` after [`Snapshot::rename`] and in files.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub membership: Option<Membership>,
    /// Substeps of bodies without their own number.
    pub substeps: Substeps,
    /// Gravity and damping, and which effects are off.
    pub effects: Effects,
    /// Evaluations so far.
    #[cfg_attr(feature = "serde", serde(rename = "counts"))]
    pub evaluations: Evaluations,
    /// All entities, scenery included, for code that makes a world for the snapshot: [`take`] leaves the list empty, and
    /// [`restore`] does not read it.
    pub things: Bodies,
    /// The bodies, in the order of their tables: neighbors share calls of laws, so that counts of evaluations depend on it.
    pub bodies: Bodies,
    /// Position of each of the bodies.
    #[cfg_attr(feature = "serde", serde(rename = "positions", deserialize_with = "list"))]
    pub transforms: Vec<Transform>,
    /// Velocity and inverse mass of each of the bodies.
    #[cfg_attr(feature = "serde", serde(rename = "velocities", deserialize_with = "list"))]
    pub states: Vec<PhysicsBody>,
    /// Previous positions, in worlds that draw between ticks.
    #[cfg_attr(feature = "serde", serde(rename = "drawn_from", deserialize_with = "list"))]
    pub previous_positions: Vec<(B, PreviousPosition)>,
    /// Quarantined bodies.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub quarantined: Vec<B>,
    /// Particles that do not live.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub dormant: Vec<B>,
    /// Bodies with their own method.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub own_methods: Vec<(B, Method)>,
    /// Bodies with their own number of substeps.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub own_substeps: Vec<(B, OwnSubsteps)>,
    /// Bodies that choose their substeps.
    #[cfg_attr(
        feature = "serde",
        serde(deserialize_with = "list", skip_serializing_if = "Vec::is_empty")
    )]
    pub auto_substeps: Vec<(B, AutoSubsteps)>,
    /// Method state of position Verlet.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub last_steps: Vec<(B, LastStep)>,
    /// Why and when bodies were quarantined.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub records: Vec<QuarantineRecord<B>>,
    /// What each emitter has emitted.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub emissions: Vec<(B, EmissionState)>,
    /// What a particle backend logs of each of its emitters.
    #[cfg_attr(
        feature = "serde",
        serde(rename = "swarms", deserialize_with = "list", skip_serializing_if = "Vec::is_empty")
    )]
    pub logs: Vec<(B, Log)>,
    /// Forces that were added for the next tick.
    #[cfg_attr(
        feature = "serde",
        serde(deserialize_with = "list", skip_serializing_if = "Vec::is_empty")
    )]
    pub forces: Vec<Push<B>>,
    /// Pushes that wait for the next tick.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub pushes: Vec<Push<B>>,
    /// Sustained pushes.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub sustained: Vec<Push<B>>,
    /// Requests that wait for the next tick.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub requests: Vec<Request<B>>,
}

/// Which entities of the physics are in a world, besides the bodies and emitters in play.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Membership {
    /// Springs and soft bodies in play.
    pub springs: Vec<Entity>,
    /// What is [disabled](Disabled), and the state of those that are bodies.
    pub disabled: Vec<(Entity, Option<(Transform, PhysicsBody)>)>,
}

impl Membership {
    fn of(world: &World) -> Self {
        let mut springs = marked::<Spring>(world);
        springs.extend(marked::<SoftBody>(world));
        let query = world.try_query_filtered::<EntityRef, With<Disabled>>();
        let disabled = query.iter().flat_map(|query| query.iter_manual(world));
        let disabled = disabled.filter(|entity| is_of_physics(entity));
        let state =
            |entity: EntityRef| Some((*entity.get::<Transform>()?, *entity.get::<PhysicsBody>()?));
        Self { springs, disabled: disabled.map(|entity| (entity.id(), state(entity))).collect() }
    }
}

/// Whether an entity is a body, an emitter, a spring or a soft body.
fn is_of_physics(entity: &EntityRef) -> bool {
    (entity.contains::<Transform>() && entity.contains::<PhysicsBody>())
        || entity.contains::<Emission>()
        || entity.contains::<Spring>()
        || entity.contains::<SoftBody>()
}

/// The log of worlds whose particles are all bodies.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct NoLog;

/// Gravity and damping of a world, and which effects are off.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(default))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Effects {
    /// Gravity, if it is declared.
    pub gravity: Option<Gravity>,
    /// Damping, on or off, if it is declared.
    pub damping: Option<Damping>,
    /// Effects that are off.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "list"))]
    pub off: Vec<Effect>,
}

/// Why a snapshot was not restored.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum RestoreError {
    /// The world has other bodies or emitters.
    Mismatch(Mismatch),
    /// The world has other springs or soft bodies.
    Springs,
    /// The stepper has another [`Integrator`](crate::methods::Integrator).
    Integrator,
    /// A field of the snapshot has a value that [`take`] cannot have made, or not of this world.
    Invalid {
        /// The field of [`Snapshot`].
        field: &'static str,
        /// What is wrong with it.
        why: &'static str,
    },
}

impl fmt::Display for RestoreError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mismatch(mismatch) => mismatch.fmt(out),
            Self::Springs => out.write_str(
                "the world has other springs or soft bodies than the snapshot; spawn, despawn and change them back",
            ),
            Self::Integrator => out.write_str(
                "a stepper with another `Integrator` took the snapshot; restore it with one that `Stepper::of` makes of the same",
            ),
            Self::Invalid { field, why } => {
                write!(out, "`{field}` of the snapshot: {why}; restore one as `take` made it")
            }
        }
    }
}

impl std::error::Error for RestoreError {}

/// The bodies or emitters in which a world and a snapshot differ.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Mismatch {
    /// Bodies and emitters of the snapshot that the world lacks.
    pub missing: Vec<Entity>,
    /// Bodies and emitters of the world that the snapshot lacks.
    pub unknown: Vec<Entity>,
}

impl fmt::Display for Mismatch {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { missing, unknown } = self;
        write!(
            out,
            "the world lacks {} bodies or emitters of the snapshot and has {} that the snapshot lacks, first {}; spawn, \
             despawn, enable and disable until they are the same",
            missing.len(),
            unknown.len(),
            missing.iter().chain(unknown).next().unwrap_or(&Entity::PLACEHOLDER)
        )
    }
}

impl std::error::Error for Mismatch {}

/// Filter of the bodies of a snapshot.
type IsBody = (With<Transform>, With<PhysicsBody>);

/// Takes the state of `world`, which `stepper` simulates, between two ticks.
///
/// # Panics
/// If no stepper was made for `world`.
#[must_use]
pub fn take(world: &World, stepper: &Stepper) -> Snapshot {
    let state = take_with(world, stepper);
    let springs = Some(checksum_of_springs(world, &state.bodies));
    Snapshot { springs, membership: Some(Membership::of(world)), ..state }
}

/// [`take`], with the `Log` that a particle backend, as the crate `swarm` is one, keeps of emitters, and without the checksum
/// of springs and the [`Membership`]: for programs that make the springs of a world themselves.
///
/// # Panics
/// As [`take`].
#[must_use]
pub fn take_with<Log: Component + Clone>(
    world: &World,
    stepper: &Stepper,
) -> Snapshot<Entity, Vec<Entity>, Log> {
    let mut tables = world
        .try_query::<(Entity, &Transform, &PhysicsBody)>()
        .filter(|_| world.contains_resource::<StepClock>())
        .expect(NO_STEPPER);
    let count = tables.iter(world).len();
    let (mut bodies, mut transforms) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut states = Vec::with_capacity(count);
    for table in tables.contiguous_iter(world).expect("bodies are stored in tables") {
        bodies.extend_from_slice(table.0);
        transforms.extend_from_slice(table.1);
        states.extend_from_slice(table.2);
    }
    let own = marked::<OwnMethod>(world).into_iter();
    let own_methods =
        own.filter_map(|body| Some((body, own_method(world.entity(body))?))).collect();
    let state = |(emitter, emission): (Entity, &Emission)| Some((emitter, emission.state()));
    let emissions = collect(world, state);
    let mut dormant = marked::<Dormant>(world);
    dormant.extend(orphans(world));
    Snapshot {
        clock: (*world.resource::<StepClock>()).into(),
        step: *world.resource(),
        method: stepper.method(),
        integrator: stepper.integrator().map(str::to_owned),
        springs: None,
        membership: None,
        substeps: world.get_resource().copied().unwrap_or_default(),
        effects: Effects::of(world),
        evaluations: world.resource::<Evaluations>().clone(),
        things: Vec::new(),
        bodies,
        transforms,
        states,
        previous_positions: all(world),
        quarantined: marked::<Quarantined>(world),
        dormant,
        own_methods,
        own_substeps: all(world),
        auto_substeps: all(world),
        last_steps: all(world),
        records: world.resource::<Quarantine>().records().to_vec(),
        emissions,
        logs: all(world),
        forces: PushedBodies::forces(world),
        pushes: world.resource::<PushQueue>().edges().to_vec(),
        sustained: world.resource::<PushQueue>().sustained().to_vec(),
        requests: world.resource::<Requests>().pending().collect(),
    }
}

/// A checksum of the springs between these bodies, in any order. It names a body by its place in the list, which is the same in
/// every world and file.
fn checksum_of_springs(world: &World, bodies: &[Entity]) -> u64 {
    let springs = values::<Spring>(world).map(|spring| (spring.ends, spring.elastic));
    let links = values::<SoftBody>(world).flat_map(|soft| {
        let point = |end: u32| soft.points.get(end as usize).copied();
        let ends = move |[a, b]: [u32; 2]| Some([point(a)?, point(b)?]);
        soft.springs.iter().filter_map(move |link| Some((ends(link.ends)?, link.elastic)))
    });
    let mut all = springs.chain(links).peekable();
    if all.peek().is_none() {
        return 0;
    }
    let place: EntityHashMap<u64> = bodies.iter().copied().zip(0..).collect();
    let sums = all.filter_map(|(ends, elastic)| {
        let [a, b] = [*place.get(&ends[0])?, *place.get(&ends[1])?];
        let (numbers, pull_only) = elastic.bits();
        let words = [a, b, u64::from(pull_only)].into_iter().chain(numbers);
        let mix = |sum: u64, word: u64| (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        // The bits in which small numbers differ are the high ones, which a product does not carry down.
        Some(words.fold(1, |sum, word| mix(sum ^ sum >> 32, word ^ word >> 32)))
    });
    sums.fold(0, u64::wrapping_add)
}

/// [`restore`] across spawns, as a network game rolls back: despawns the bodies, emitters, springs and soft bodies that were spawned
/// since, and enables and [disables](Disabled) the others as they were.
///
/// So a game disables what it takes out of play, springs too, and despawns it when no snapshot is left that has it: an entity that is
/// despawned cannot come back under its name. A spring that was changed is refused, as by [`restore`], and so are springs that were
/// spawned since a snapshot that was read from a file, which does not say which there were.
///
/// ```
/// use bevy_ecs::entity_disabling::Disabled;
/// use bevy_ecs::prelude::*;
/// use motion::{Gravity, Method, PhysicsBody, Stepper, TimeStep, snapshot};
///
/// let mut world = World::new();
/// world.insert_resource(Gravity::EARTH);
/// let [ship, shot] = [5.0, 0.1].map(|mass| world.spawn(PhysicsBody::with_mass(mass)).id());
/// let mut stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(1.0 / 60.0));
/// let saved = snapshot::take(&world, &stepper);
///
/// world.entity_mut(shot).insert(Disabled); // It hit something.
/// let debris = world.spawn(PhysicsBody::with_mass(1.0)).id();
/// (0..10).for_each(|_| stepper.tick(&mut world));
/// // Another player's input of ten ticks ago arrives.
/// snapshot::roll_back(&mut world, &mut stepper, &saved)?;
/// assert!(world.get_entity(debris).is_err() && !world.entity(shot).contains::<Disabled>());
/// assert_eq!(snapshot::take(&world, &stepper), saved);
/// # let _ = ship;
/// # Ok::<(), snapshot::RestoreError>(())
/// ```
///
/// # Errors
/// As [`restore`]; spawned entities are gone and disabled ones enabled then.
///
/// # Panics
/// As [`restore`].
pub fn roll_back(
    world: &mut World,
    stepper: &mut Stepper,
    snapshot: &Snapshot,
) -> Result<(), RestoreError> {
    let Snapshot { bodies, emissions, membership, .. } = snapshot;
    let in_play = bodies.iter().copied().chain(entities(emissions));
    let Membership { springs, disabled } = membership.clone().unwrap_or_default();
    let in_play: EntityHashSet = in_play.chain(springs).collect();
    let out: EntityHashSet = entities(&disabled).collect();
    let mut all = world.query_filtered::<EntityRef, Allow<Disabled>>();
    let all: Vec<_> = all.iter(world).filter(is_of_physics).map(|entity| entity.id()).collect();
    for entity in all {
        let Ok(mut entity) = world.get_entity_mut(entity) else { continue };
        let is_spring = entity.contains::<Spring>() || entity.contains::<SoftBody>();
        if in_play.contains(&entity.id()) {
            entity.remove::<Disabled>();
        } else if out.contains(&entity.id()) {
            entity.insert(Disabled);
        } else if membership.is_some() || !is_spring {
            entity.despawn();
        }
    }
    for (entity, state) in disabled {
        if let Some((then, body)) = state
            && let Ok(mut entity) = world.get_entity_mut(entity)
            && let Ok((mut transform, mut now)) =
                entity.get_components_mut::<(&mut Transform, &mut PhysicsBody)>()
        {
            (*transform, *now) = (then, body);
        }
    }
    restore(world, stepper, snapshot)
}

/// Puts `world` and its `stepper` into the state of `snapshot`, with its method and its length of a tick.
///
/// # Errors
/// If the bodies, emitters or springs of `world` or the [`Integrator`](crate::methods::Integrator) of `stepper` are not those
/// of `snapshot`, or if its lists do not fit each other or a number is out of its range; nothing is changed then.
///
/// # Panics
/// If no stepper was made for `world`.
pub fn restore<Log: Component<Mutability = Mutable> + Clone + PartialEq>(
    world: &mut World,
    stepper: &mut Stepper,
    snapshot: &Snapshot<Entity, Vec<Entity>, Log>,
) -> Result<(), RestoreError> {
    snapshot.check_bodies(world)?;
    let clock = snapshot.check_fields(world)?;
    if snapshot.integrator.as_deref() != stepper.integrator() {
        return Err(RestoreError::Integrator);
    }
    // Every field is named, so that a new one is not forgotten.
    let Snapshot {
        clock: _,
        step,
        method,
        integrator: _,
        springs: _,
        membership: _,
        substeps,
        effects,
        evaluations,
        things: _,
        bodies: _,
        transforms: _,
        states: _,
        previous_positions,
        quarantined,
        dormant,
        own_methods: _,
        own_substeps,
        auto_substeps,
        last_steps,
        records,
        emissions,
        logs,
        forces,
        pushes,
        sustained,
        requests,
    } = snapshot;
    effects.put(world);
    world.insert_resource(clock);
    world.insert_resource(*step);
    if world.get_resource::<Substeps>().copied().unwrap_or_default() != *substeps {
        world.insert_resource(*substeps);
    }
    snapshot.put_methods(world, stepper.method());
    let mass_changed = snapshot.put_rows(world);
    give(world, previous_positions);
    give(world, last_steps);
    give(world, &with(dormant, Dormant));
    give(world, auto_substeps);
    let regrouped =
        [give(world, &with(quarantined, Quarantined)), give(world, own_substeps), mass_changed];
    if regrouped.contains(&true) {
        CouplingChanged::set(world);
    }
    for (emitter, state) in emissions {
        if let Some(mut emission) = world.get_mut::<Emission>(*emitter) {
            *emission = Emission::from_state(state.clone());
        }
    }
    give(world, logs);
    // The births of a tick in which a law panicked.
    if let Some(mut emissions) = world.get_resource_mut::<Emissions>() {
        emissions.births.clear();
    }
    stepper.resume(world, *method);
    // Compiling groups and preparing pools moves bodies to other tables.
    snapshot.put_in_order(world);
    world.insert_resource(evaluations.clone());
    world.insert_resource(Quarantine::from_records(records.clone()));
    PushedBodies::replace(world, forces);
    let mut queue = PushQueue::default();
    pushes.iter().for_each(|push| queue.push_once(push.body, push.newtons));
    queue.sustain(sustained.iter().copied());
    world.insert_resource(queue);
    let mut waiting = Requests::default();
    requests.iter().for_each(|request| waiting.ask(*request));
    world.insert_resource(waiting);
    Ok(())
}

impl Effects {
    /// The effects of `world`.
    pub fn of(world: &World) -> Self {
        let off = world.get_resource::<OffResource<Damping>>().map(|OffResource(damping)| *damping);
        Self {
            gravity: world.get_resource().copied(),
            damping: world.get_resource().copied().or(off),
            off: Effect::ALL
                .into_iter()
                .filter(|effect| effects::state(world, *effect) == EffectState::Off)
                .collect(),
        }
    }

    /// Applies these effects to `world`, as far as it declares them.
    pub fn put(&self, world: &mut World) {
        let switch = |world: &mut World, to_off: bool| {
            for effect in
                Effect::ALL.into_iter().filter(|effect| self.off.contains(effect) == to_off)
            {
                // An effect that was never declared is off anyway.
                let _ = effects::switch(world, effect, !to_off);
            }
        };
        switch(world, false);
        match self.gravity {
            Some(gravity) => world.insert_resource(gravity),
            None => drop(world.remove_resource::<Gravity>()),
        }
        match self.damping {
            Some(damping) => world.insert_resource(damping),
            None => drop(world.remove_resource::<Damping>()),
        }
        switch(world, true);
    }
}

impl<Log: Clone> MapEntities for Snapshot<Entity, Vec<Entity>, Log> {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        let mapper = RefCell::new(mapper);
        *self = self.clone().with_names(|entity| mapper.borrow_mut().get_mapped(entity));
    }
}

impl<B, Log> Snapshot<B, Vec<B>, Log> {
    /// The same state with other names of bodies and emitters, for files and other worlds. See [`Snapshot::rename`] for names
    /// that some do not have. A file has to keep every bit of a number: `serde_json` reads them only with its feature
    /// `float_roundtrip`.
    ///
    /// ```
    /// # #[cfg(feature = "serde")] {
    /// use std::collections::HashMap;
    ///
    /// use bevy_ecs::prelude::*;
    /// use motion::snapshot::{self, Snapshot};
    /// use motion::{Method, PhysicsBody, StableId, Stepper, TimeStep, units::Vector};
    ///
    /// let mut world = World::new();
    /// let body = PhysicsBody::with_mass(2.0).moving_at(Vector::X);
    /// let ids: HashMap<u32, Entity> =
    ///     (0..3).map(|id| (id, world.spawn((StableId(id), body)).id())).collect();
    /// let mut stepper = Stepper::new(&mut world, Method::PositionVerlet, TimeStep(0.01));
    /// stepper.tick(&mut world);
    ///
    /// let saved = snapshot::take(&world, &stepper);
    /// let file = saved.with_names(|body| world.entity(body).components::<&StableId>().0);
    /// let file = serde_json::to_string(&file).unwrap();
    /// let before = snapshot::take(&world, &stepper).transforms;
    /// (0..10).for_each(|_| stepper.tick(&mut world));
    ///
    /// let read: Snapshot<u32> = serde_json::from_str(&file).unwrap();
    /// snapshot::restore(&mut world, &mut stepper, &read.with_names(|id| ids[&id])).unwrap();
    /// assert_eq!(snapshot::take(&world, &stepper).transforms, before);
    /// # }
    /// ```
    pub fn with_names<Other>(self, name: impl Fn(B) -> Other) -> Snapshot<Other, Vec<Other>, Log> {
        let list = |all: Vec<_>| all.into_iter().map(&name).collect();
        let some = |body| Some(name(body));
        self.rename(list, some, some, |record| Some(record.rename(&name)))
    }
}

impl<B, Bodies, Log> Snapshot<B, Bodies, Log> {
    /// The same state with other names: the functions return a list of bodies, a body, an emitter and a record with the new
    /// names. Entries for which they return `None` are left out; [`Snapshot::springs`] holds only if no body is.
    pub fn rename<Other, OtherBodies>(
        self,
        list: impl Fn(Bodies) -> OtherBodies,
        body: impl Fn(B) -> Option<Other>,
        emitter: impl Fn(B) -> Option<Other>,
        record: impl Fn(QuarantineRecord<B>) -> Option<QuarantineRecord<Other>>,
    ) -> Snapshot<Other, OtherBodies, Log> {
        fn keys<B, Other, T>(
            all: Vec<(B, T)>,
            name: impl Fn(B) -> Option<Other>,
        ) -> Vec<(Other, T)> {
            all.into_iter().filter_map(|(key, value)| Some((name(key)?, value))).collect()
        }
        let bodies_of = |all: Vec<B>| all.into_iter().filter_map(&body).collect();
        let push = |Push { body: pushed, newtons }| Some(Push { body: body(pushed)?, newtons });
        let pushes_of = |all: Vec<_>| all.into_iter().filter_map(push).collect();
        let Self {
            clock,
            step,
            method,
            integrator,
            springs,
            membership: _,
            substeps,
            effects,
            evaluations,
            things,
            bodies,
            transforms,
            states,
            previous_positions,
            quarantined,
            dormant,
            own_methods,
            own_substeps,
            auto_substeps,
            last_steps,
            records,
            emissions,
            logs,
            forces,
            pushes,
            sustained,
            requests,
        } = self;
        Snapshot {
            clock,
            step,
            method,
            integrator,
            springs,
            membership: None,
            substeps,
            effects,
            evaluations,
            things: list(things),
            bodies: list(bodies),
            transforms,
            states,
            previous_positions: keys(previous_positions, &body),
            quarantined: bodies_of(quarantined),
            dormant: bodies_of(dormant),
            own_methods: keys(own_methods, &body),
            own_substeps: keys(own_substeps, &body),
            auto_substeps: keys(auto_substeps, &body),
            last_steps: keys(last_steps, &body),
            records: records.into_iter().filter_map(record).collect(),
            emissions: keys(emissions, &emitter),
            logs: keys(logs, &emitter),
            forces: pushes_of(forces),
            pushes: pushes_of(pushes),
            sustained: pushes_of(sustained),
            requests: requests.into_iter().filter_map(|request| request.rename(&body)).collect(),
        }
    }
}

impl<Log> Snapshot<Entity, Vec<Entity>, Log> {
    /// Checks the numbers, the lengths of the lists and that `world` has the entities of the lists. Returns the clock.
    fn check_fields(&self, world: &World) -> Result<StepClock, RestoreError> {
        let Self { step: TimeStep(step), substeps, effects, bodies, transforms, states, .. } = self;
        let ensure = |holds, field, why| {
            if holds { Ok(()) } else { Err(RestoreError::Invalid { field, why }) }
        };
        ensure(*step >= 0.0 && step.is_finite(), "step", "a tick is finite and at least 0 s long")?;
        let clock = StepClock::from_state(self.clock);
        let clock =
            clock.ok_or(RestoreError::Invalid { field: "clock", why: "no clock can show this" })?;
        ensure(
            (1..=Substeps::MOST).contains(&substeps.0),
            "substeps",
            "their number is out of its range",
        )?;
        ensure(
            effects.damping.is_none_or(|damping| damping.rate >= 0.0 || damping.rate.is_nan()),
            "effects",
            "damping is below 0",
        )?;
        let own = self.own_substeps.iter().map(|(_, own)| own.0);
        ensure(
            { own }.all(|own| (1..=Substeps::MOST).contains(&own)),
            "own_substeps",
            "their number is out of its range",
        )?;
        ensure(
            self.auto_substeps.iter().all(|(_, auto)| auto.is_valid()),
            "auto_substeps",
            "a number is out of its range",
        )?;
        if self.springs.is_some_and(|springs| springs != checksum_of_springs(world, &self.bodies)) {
            return Err(RestoreError::Springs);
        }
        ensure(
            transforms.len() == bodies.len(),
            "transforms",
            "there is not one for each of `bodies`",
        )?;
        ensure(states.len() == bodies.len(), "states", "there is not one for each of `bodies`")?;
        let each = |field, why: Option<&'static str>| {
            ensure(why.is_none(), field, why.unwrap_or_default())
        };
        each("previous_positions", fault_of(world, entities(&self.previous_positions)))?;
        each("last_steps", fault_of(world, entities(&self.last_steps)))?;
        each("own_methods", fault_of(world, entities(&self.own_methods)))?;
        each("own_substeps", fault_of(world, entities(&self.own_substeps)))?;
        each("auto_substeps", fault_of(world, entities(&self.auto_substeps)))?;
        each("quarantined", fault_of(world, self.quarantined.iter().copied()))?;
        each("logs", fault_of(world, entities(&self.logs)))?;
        each("dormant", fault_of(world, self.dormant.iter().copied()))?;
        Ok(clock)
    }

    /// Checks that the world has exactly the bodies and emitters of the snapshot, each of which is listed once.
    fn check_bodies(&self, world: &mut World) -> Result<(), RestoreError> {
        let same =
            world.query_filtered::<Entity, IsBody>().iter(world).eq(self.bodies.iter().copied())
                && marked::<Emission>(world)
                    .into_iter()
                    .eq(self.emissions.iter().map(|(emitter, _)| *emitter));
        if same {
            return Ok(());
        }
        let (mut missing, mut unknown) = (Vec::new(), Vec::new());
        let mut compare = |then: EntityHashSet, now: EntityHashSet| {
            missing.extend(then.difference(&now).copied());
            unknown.extend(now.difference(&then).copied());
        };
        let bodies = world.query_filtered::<Entity, IsBody>().iter(world).collect();
        compare(self.bodies.iter().copied().collect(), bodies);
        compare(
            entities(&self.emissions).collect(),
            marked::<Emission>(world).into_iter().collect(),
        );
        missing.sort_unstable();
        unknown.sort_unstable();
        if !(missing.is_empty() && unknown.is_empty()) {
            return Err(RestoreError::Mismatch(Mismatch { missing, unknown }));
        }
        for (field, why) in [
            ("bodies", fault_of(world, self.bodies.iter().copied())),
            ("emissions", fault_of(world, entities(&self.emissions))),
        ] {
            if let Some(why) = why {
                return Err(RestoreError::Invalid { field, why });
            }
        }
        Ok(())
    }

    /// Gives the bodies their methods. Drops cached accelerations if a method changes.
    fn put_methods(&self, world: &mut World, present: Method) {
        let then: EntityHashMap<Method> = self.own_methods.iter().copied().collect();
        let mut own = world.query_filtered::<EntityRef, With<OwnMethod>>();
        let gone = own.iter(world).map(|body| body.id()).filter(|body| !then.contains_key(body));
        let gone: Vec<_> = gone.map(|body| (body, None)).collect();
        let given = self.own_methods.iter().map(|(body, method)| (*body, Some(*method)));
        let mut changed = present != self.method;
        for (body, method) in gone.into_iter().chain(given) {
            let Ok(mut body) = world.get_entity_mut(body) else { continue };
            if own_method(body.as_readonly()) != method {
                mark_method(&mut body, method);
                changed = true;
            }
        }
        if changed {
            for body in marked::<LastAcceleration>(world) {
                world.entity_mut(body).remove::<LastAcceleration>();
            }
        }
    }

    /// Puts the rows of the bodies into the world. Returns whether a mass changed.
    fn put_rows(&self, world: &mut World) -> bool {
        let mut bodies = world.query::<(Entity, &mut Transform, &mut PhysicsBody)>();
        let rows = self.transforms.iter().zip(&self.states);
        let mut mass_changed = false;
        let mut put = |mut transform: Mut<Transform>,
                       mut state: Mut<PhysicsBody>,
                       then: (&Transform, &PhysicsBody)| {
            mass_changed |= state.inverse_mass.to_bits() != then.1.inverse_mass.to_bits();
            (*transform, *state) = (*then.0, *then.1);
        };
        let is_in_order = bodies.iter(world).map(|(body, ..)| body).eq(self.bodies.iter().copied());
        if is_in_order {
            for ((_, transform, state), then) in bodies.iter_mut(world).zip(rows) {
                put(transform, state, then);
            }
        } else {
            for (body, then) in self.bodies.iter().zip(rows) {
                if let Ok((_, transform, state)) = bodies.get_mut(world, *body) {
                    put(transform, state, then);
                }
            }
        }
        mass_changed
    }

    /// Brings the rows of every table into the order of the bodies.
    fn put_in_order(&self, world: &mut World) {
        /// Marks a body while its row is moved to the end of its table.
        #[derive(Component)]
        struct Moved;

        let mut bodies = world.query_filtered::<Entity, IsBody>();
        if bodies.iter(world).eq(self.bodies.iter().copied()) {
            return;
        }
        let place: EntityHashMap<usize> = self.bodies.iter().copied().zip(0..).collect();
        let tables = bodies.contiguous_iter(world).expect("entities are stored in tables");
        let tables: Vec<_> = tables.map(<[Entity]>::to_vec).collect();
        for mut table in tables {
            if !table.is_sorted_by_key(|body| place[body]) {
                table.sort_unstable_by_key(|body| place[body]);
                for body in &table {
                    world.entity_mut(*body).insert(Moved);
                }
                for body in &table {
                    world.entity_mut(*body).remove::<Moved>();
                }
            }
        }
    }
}

/// Every entity with that component, and its value.
fn all<C: Component + Clone>(world: &World) -> Vec<(Entity, C)> {
    collect(world, |(entity, value): (Entity, &C)| Some((entity, value.clone())))
}

fn entities<T>(list: &[(Entity, T)]) -> impl Iterator<Item = Entity> {
    list.iter().map(|(entity, _)| *entity)
}

/// Why `world` cannot have this list of entities; `None` if it can.
fn fault_of(world: &World, entities: impl Iterator<Item = Entity>) -> Option<&'static str> {
    // A bit for each entity by its index, which two that exist do not share.
    let mut seen: Vec<u64> = Vec::new();
    for entity in entities {
        if world.get_entity(entity).is_err() {
            return Some("the world lacks an entity of it");
        }
        let (word, bit) = (entity.index_u32() as usize / 64, 1 << (entity.index_u32() % 64));
        if seen.len() <= word {
            seen.resize(word + 1, 0);
        }
        if seen[word] & bit != 0 {
            return Some("an entity is in it twice");
        }
        seen[word] |= bit;
    }
    None
}

fn marked<C: Component>(world: &World) -> Vec<Entity> {
    collect::<C, _>(world, |(entity, _)| Some(entity))
}

fn with<C: Copy>(bodies: &[Entity], value: C) -> Vec<(Entity, C)> {
    bodies.iter().map(|body| (*body, value)).collect()
}

/// Gives exactly these entities the component. Returns whether one was added, removed or changed.
fn give<C: Component<Mutability = Mutable> + Clone + PartialEq>(
    world: &mut World,
    then: &[(Entity, C)],
) -> bool {
    let mut now = world.query::<(Entity, &mut C)>();
    let mut changed = false;
    if now.iter(world).map(|(entity, _)| entity).eq(then.iter().map(|(entity, _)| *entity)) {
        for ((_, mut value), (_, then)) in now.iter_mut(world).zip(then) {
            changed |= *value != *then;
            *value = then.clone();
        }
        return changed;
    }
    let wanted: EntityHashSet = then.iter().map(|(entity, _)| *entity).collect();
    for entity in marked::<C>(world).into_iter().filter(|entity| !wanted.contains(entity)) {
        world.entity_mut(entity).remove::<C>();
    }
    for (entity, then) in then {
        if let Some(mut value) = world.get_mut::<C>(*entity) {
            *value = then.clone();
        } else if let Ok(mut entity) = world.get_entity_mut(*entity) {
            entity.insert(then.clone());
        }
    }
    true
}
