//! The quarantine of bodies that would turn non-finite or leave the range: each stays in its last finite state, is
//! marked, and is recorded with the cause.

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;

#[cfg(feature = "serde")]
use crate::laws::law_name;
use crate::laws::{LawName, WorldLaws};
use crate::state::clock::StepClock;
use crate::state::components::{PhysicsBody, Quarantined, StableId, Transform};
use crate::state::coupling::CouplingChanged;
use crate::state::method_state::LastStep;
use crate::state::previous_position::PreviousPosition;
use crate::units::{Scalar, Vector};

/// Why a body was quarantined: which system noticed, which component or resource was at fault, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Cause<B = Entity> {
    /// The system that noticed. For an Euler step in one pass, the half that failed.
    pub system: &'static str,
    /// The component or resource at fault, with its field where it has several.
    pub component: &'static str,
    /// The fault.
    pub fault: Fault<B>,
}

/// The fault of a component or a resource.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum Fault<B = Entity> {
    /// It was not finite before the tick: something else wrote it.
    Found,
    /// This law gave a non-finite acceleration for a finite state.
    Law(#[cfg_attr(feature = "serde", serde(with = "law_name"))] LawName),
    /// The spring to this body pulled with a non-finite force between finite states.
    Spring(B),
    /// It would have overflowed: finite numbers grew beyond the largest one.
    Overflow,
    /// It would have left the range, whose bound is this, m or m/s.
    Range(Scalar),
    /// A request set it to a value that is not finite, or to an inverse mass below 0.
    Request,
}

impl Fault {
    /// Its name: `found`, `law`, `spring`, `overflow`, `range` or `request`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Found => "found",
            Self::Law(_) => "law",
            Self::Spring(_) => "spring",
            Self::Overflow => "overflow",
            Self::Range(_) => "range",
            Self::Request => "request",
        }
    }
}

impl Cause {
    pub(crate) const REQUESTS: &'static str = "requests";
    pub(crate) const FOLLOW_MOTION: &'static str = "follow_motion";

    /// Every system, component and resource that a cause may name.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let names = [
            "integrate_acceleration",
            "integrate_velocity",
            "integrate",
            "integrate_groups",
            Self::FOLLOW_MOTION,
            Self::REQUESTS,
            place::POSITION,
            place::VELOCITY,
            place::INVERSE_MASS,
            place::FORCE,
            place::DAMPING_RATE,
            place::SPEED_LIMIT,
            place::LAST_STEP,
            place::OWN_LAWS,
            place::SOURCE_MASS,
            place::SPRING,
            place::GRAVITY,
            place::DAMPING,
            place::LAWS,
            place::MUTUAL_GRAVITY,
            place::RANGE,
        ];
        names.into_iter().chain(WorldLaws::RESOURCES.iter().copied())
    }

    /// The cause as a sentence, for summaries and panels.
    #[must_use]
    pub fn what(self) -> String {
        let Self { system, component, fault } = self;
        let (part, unit) = match component {
            place::POSITION => ("position", "m"),
            place::VELOCITY => ("velocity", "m/s"),
            place::INVERSE_MASS => ("inverse mass", "1/kg"),
            other => (other, ""),
        };
        match fault {
            Fault::Found => format!("{component} was not finite when {system} looked"),
            Fault::Law(name) => {
                format!("the law {name} gave a non-finite acceleration in {system}")
            }
            Fault::Spring(_) => format!("a spring pulled with a non-finite force in {system}"),
            Fault::Overflow => format!("{part} would turn non-finite in {system}"),
            Fault::Range(bound) => {
                format!("{part} would leave the range of {bound:e} {unit} in {system}")
            }
            Fault::Request => format!("a request set an invalid {part}"),
        }
    }
}

/// Names of the components and resources that may be at fault. A law that is a resource has the name of its type.
pub(crate) mod place {
    pub const POSITION: &str = "Transform.position";
    pub const VELOCITY: &str = "PhysicsBody.velocity";
    pub const INVERSE_MASS: &str = "PhysicsBody.inverse_mass";
    pub const FORCE: &str = "Force";
    pub const DAMPING_RATE: &str = "DampingRate";
    pub const SPEED_LIMIT: &str = "SpeedLimit";
    pub const LAST_STEP: &str = "LastStep";
    pub const OWN_LAWS: &str = "OwnLaws";
    pub const SOURCE_MASS: &str = "SourceMass";
    pub const SPRING: &str = "Spring";
    pub const GRAVITY: &str = "Gravity";
    pub const DAMPING: &str = "Damping";
    pub const LAWS: &str = "Laws";
    pub const MUTUAL_GRAVITY: &str = "MutualGravity";
    pub const RANGE: &str = "Range";
}

/// The record of a body that was quarantined.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "in_files::Record<B>", into = "in_files::Record<B>"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "B: serde::Serialize + Clone",
        deserialize = "B: serde::Deserialize<'de>"
    ))
)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct QuarantineRecord<B = Entity> {
    /// The body.
    pub body: B,
    /// Its stable id, if it had one: it still names the body when the entity is gone. Files have `body` alone.
    pub id: Option<StableId>,
    /// The stable id of the other end of the spring at fault, if there is one. Files have the cause alone.
    pub other_end: Option<StableId>,
    /// The tick in which it failed, counted from 1.
    pub tick: u64,
    /// The cause.
    pub cause: Cause<B>,
}

impl<B> QuarantineRecord<B> {
    /// The same record with other names of its body and of the other end of its spring.
    pub fn rename<Other>(self, mut renamed: impl FnMut(B) -> Other) -> QuarantineRecord<Other> {
        let Self { body, id, other_end, tick, cause: Cause { system, component, fault } } = self;
        let fault = match fault {
            Fault::Found => Fault::Found,
            Fault::Law(name) => Fault::Law(name),
            Fault::Spring(end) => Fault::Spring(renamed(end)),
            Fault::Overflow => Fault::Overflow,
            Fault::Range(bound) => Fault::Range(bound),
            Fault::Request => Fault::Request,
        };
        QuarantineRecord {
            body: renamed(body),
            id,
            other_end,
            tick,
            cause: Cause { system, component, fault },
        }
    }
}

#[cfg(feature = "serde")]
mod in_files {
    //! Records as files have them.

    use serde::{Deserialize, Serialize};

    use super::{Cause, Fault, QuarantineRecord, place_name};

    /// A name. An alias, because derives would borrow a reference from the file that they read.
    type Name = &'static str;

    #[derive(Serialize, Deserialize)]
    pub struct Record<B> {
        body: B,
        tick: u64,
        #[serde(with = "place_name")]
        system: Name,
        #[serde(with = "place_name")]
        component: Name,
        fault: Fault<B>,
    }

    impl<B> From<QuarantineRecord<B>> for Record<B> {
        fn from(
            QuarantineRecord { body, id: _, other_end: _, tick, cause }: QuarantineRecord<B>,
        ) -> Self {
            let Cause { system, component, fault } = cause;
            Self { body, tick, system, component, fault }
        }
    }

    impl<B> From<Record<B>> for QuarantineRecord<B> {
        fn from(Record { body, tick, system, component, fault }: Record<B>) -> Self {
            Self {
                body,
                id: None,
                other_end: None,
                tick,
                cause: Cause { system, component, fault },
            }
        }
    }
}

#[cfg(feature = "serde")]
crate::names::one_of!(
    /// The name of a system, a component or a resource in files.
    place_name,
    super::Cause::names()
);

/// A body refused in the running tick, with the state in which it is quarantined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refused {
    pub body: Entity,
    pub transform: Transform,
    pub state: PhysicsBody,
    pub cause: Cause,
}

/// All bodies that were quarantined so far, in the order of ticks, and of stable ids within a tick.
#[derive(Resource, Debug, Default)]
pub struct Quarantine {
    refused: Vec<Refused>,
    records: Vec<QuarantineRecord>,
}

impl Quarantine {
    /// A quarantine that continues from these records.
    #[must_use]
    pub const fn from_records(records: Vec<QuarantineRecord>) -> Self {
        Self { refused: Vec::new(), records }
    }

    /// The records of all quarantined bodies, in order.
    #[must_use]
    pub fn records(&self) -> &[QuarantineRecord] {
        &self.records
    }

    /// Ends the quarantine of `body` and removes its records. It continues from the state that it has, so insert another
    /// [`PhysicsBody`] or [`Transform`] first. Returns whether it was quarantined.
    ///
    /// ```
    /// use bevy_ecs::prelude::*;
    /// use motion::{Method, PhysicsBody, Quarantine, Quarantined, Stepper, TimeStep, Transform, units::Vector};
    ///
    /// let mut world = World::new();
    /// let body = PhysicsBody::with_mass(1.0).moving_at(Vector::X * f64::NAN);
    /// let body = world.spawn(body).id();
    /// let mut stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(1.0));
    /// stepper.tick(&mut world);
    /// assert!(world.entity(body).contains::<Quarantined>());
    /// println!("{:?}", world.resource::<Quarantine>().records()); // its velocity was not finite before the tick
    ///
    /// world.entity_mut(body).insert(PhysicsBody::with_mass(1.0).moving_at(Vector::X));
    /// assert!(Quarantine::release(&mut world, body));
    /// stepper.tick(&mut world);
    /// assert_eq!(world.get::<Transform>(body).unwrap().position, Vector::X);
    /// ```
    pub fn release(world: &mut World, body: Entity) -> bool {
        let was =
            world.get_entity_mut(body).is_ok_and(|mut body| body.take::<Quarantined>().is_some());
        if was {
            world.resource_mut::<Self>().records.retain(|record| record.body != body);
            CouplingChanged::set(world);
        }
        was
    }

    /// Notes a row that a kernel refused; it is quarantined at the end of the tick.
    #[cold]
    pub(crate) fn refuse(&mut self, refused: Refused) {
        self.refused.push(refused);
    }
}

/// Quarantines the bodies that the tick refused and marks them [`Quarantined`].
///
/// If other code has written a state that is not finite, the position becomes the [`PreviousPosition`], or the origin without
/// one, the velocity 0 and the inverse mass 0, each only if it is not finite.
pub fn quarantine_bodies(
    mut commands: Commands,
    mut quarantine: ResMut<Quarantine>,
    changed: Option<ResMut<CouplingChanged>>,
    clock: Option<Res<StepClock>>,
    kept: Query<(Option<&PreviousPosition>, Option<&LastStep>)>,
    ids: Query<&StableId>,
) {
    if quarantine.refused.is_empty() {
        return;
    }
    if let Some(mut changed) = changed {
        // Springs of a quarantined body are inert.
        changed.0 = true;
    }
    let tick = clock.map_or(0, |clock| clock.ticks() + 1);
    let Quarantine { refused, records } = &mut *quarantine;
    let mut seen = EntityHashSet::default();
    let before = records.len();
    for Refused { body, transform, state, cause } in refused.drain(..) {
        // The first refusal of a tick has the state before the failure; a later one has not.
        if !seen.insert(body) {
            continue;
        }
        let (previous, last) = kept.get(body).unwrap_or_default();
        let previous = previous.map(|previous| previous.0);
        let mut entity = commands.entity(body);
        // Later systems of the tick may have moved the row: the state is restored with the mark.
        let (transform, state) = (finite_position(transform, previous), finite_state(state));
        entity.try_insert((transform, state, Quarantined));
        if previous.is_some_and(|previous| !previous.is_finite()) {
            // Drawing cannot interpolate from a position that is not finite.
            entity.try_insert(PreviousPosition(transform.position));
        }
        if last.is_some_and(|last| !last.0.is_finite()) {
            entity.try_insert(LastStep::default());
        }
        let id = |body| ids.get(body).ok().copied();
        let other_end = if let Fault::Spring(end) = cause.fault { id(end) } else { None };
        records.push(QuarantineRecord { body, id: id(body), other_end, tick, cause });
    }
    // Systems refuse bodies in the order of tables, which differs in a restored world.
    records[before..].sort_by_key(|record| record.id.map_or(u32::MAX, |id| id.0));
}

/// Runs [`quarantine_bodies`] between two ticks.
pub(crate) fn quarantine_refused(world: &mut World) {
    world.run_system_cached(quarantine_bodies).expect("its resources are inserted with the step's");
}

fn finite_position(transform: Transform, previous: Option<Vector>) -> Transform {
    if transform.position.is_finite() {
        return transform;
    }
    Transform::at(previous.filter(|previous| previous.is_finite()).unwrap_or(Vector::ZERO))
}

fn finite_state(state: PhysicsBody) -> PhysicsBody {
    PhysicsBody {
        velocity: if state.velocity.is_finite() { state.velocity } else { Vector::ZERO },
        inverse_mass: if state.inverse_mass.is_finite() { state.inverse_mass } else { 0.0 },
    }
}
