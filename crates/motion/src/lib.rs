//! Linear motion on an entity component system: `Transform`, `PhysicsBody` and `Force`, moved by scheduled systems.
//!
//! The goals, in order of importance: motion that can be proven against theory; hard cases that stay finite; a step that
//! costs what its arithmetic costs. The crate reads no file, no device and no clock. It has no rotation dynamics, no
//! collisions and no friction.
//!
//! ```
//! use bevy_ecs::prelude::*;
//! use motion::Transform;
//! use motion::prelude::*;
//!
//! let mut world = World::new();
//! world.insert_resource(Gravity::EARTH);
//! let ball = world.spawn((
//!     Transform::at(Vector::new(0.0, 10.0, 0.0)),
//!     PhysicsBody::with_mass(2.0),
//!     Force::default(),
//! ));
//! let ball = ball.id();
//! let mut stepper = Stepper::new(&mut world, Method::SemiImplicitEuler, TimeStep(1.0 / 120.0));
//! world.resource_mut::<PushQueue>().push_once(ball, Vector::new(30.0, 0.0, 0.0));
//! for _ in 0..120 {
//!     stepper.tick(&mut world);
//! }
//! let body = world.entity(ball).components::<&PhysicsBody>();
//! assert!((body.velocity.x - 30.0 / 2.0 / 120.0).abs() < 1e-12 && (body.velocity.y + 9.8).abs() < 1e-12);
//! ```
//!
//! More examples, one thing each: a law of your own at [`Law`], springs at [`Spring`], ropes, cloths and jelly at [`SoftForm`], fountains
//! at [`Emitter::new`], a method of your own at [`Stepper::of`], bodies that go and come back at [`Stepper`], rollback at
//! [`snapshot::roll_back`], files at [`Snapshot::with_names`](snapshot::Snapshot::with_names), threads at [`Threads`], a ledger at
//! [`Ledger::install`](ledger::Ledger::install), a forecast at [`Margins`](margin::Margins), a quarantine that ends at
//! [`Quarantine::release`].
//!
//! - Bodies are entities with a [`PhysicsBody`], which brings its [`Transform`] and [`Force`]; options such as [`SpeedLimit`]
//!   are components.
//! - Laws are resources ([`Gravity`], [`Drag`], [`Wells`], [`Damping`]), your own are [`Law`]s in [`Laws`] or [`OwnLaws`].
//! - [`Stepper`] compiles the schedule of a [`Method`] and runs ticks; [`Stepper::install`] puts it into your schedule.
//! - [`bevy_ecs`] and [`glam`], whose types are in this interface, are exported as the versions that it was built with.
//! - [`Requests`] change bodies, laws and methods between two ticks; [`PushQueue`] and [`Forces`] push.
//!
//! The folders of the source, each of which uses only those before it:
//!
//! - `simd` and [`units`]: vector instructions of the machine; the scalar and vector of the simulation.
//! - `names` and `lists`, with the feature `serde`: helpers of derives for files.
//! - `state`: components and resources of bodies, forces, springs and emitters, and the [`clock`]s.
//! - `laws`: the trait [`Law`] and one file per law; damping, and the times of a tick.
//! - [`methods`]: the methods, and [`METHODS`], the table of their claims.
//! - `kernels`: one tick of a block of bodies by a method.
//! - `tick`: the systems that integrate single bodies, and [`Quarantine`] of those that fail.
//! - `groups`: bodies joined by springs or mutual gravity, integrated together.
//! - `schedule`: [`Stepper`], [`Requests`], emission and [`effects`]; with the feature `bevy` also the plugin.
//! - [`snapshot`]: the state of a world between two ticks, taken out and put back.
//! - `observe`: [`ledger`], [`margin`], [`forces_on`] and [`totals`](totals()), which read a world and change nothing.

#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(test, allow(clippy::wildcard_enum_match_arm, reason = "a test is of some of them"))]

mod groups;
mod kernels;
mod laws;
#[cfg(feature = "serde")]
#[doc(hidden)]
pub mod lists;
pub mod methods;
#[cfg(feature = "serde")]
mod names;
mod observe;

mod schedule;
mod simd;
pub mod snapshot;
mod state;
mod tick;
pub mod units;

pub use bevy_ecs;
pub use glam;
pub use kernels::evaluations::{Evaluations, Iterations};
pub use laws::damping::{Damping, DampingModel, DampingRate};
pub use laws::own::OwnLaws;
pub use laws::{
    Affine, Air, BodyDrag, BodyState, Curve, Drag, EvaluationTime, Gravity, Jacobians, LAWS, Law,
    Laws, MutualGravity, PrescribedMotion, RidingWell, SourceMass, Thrust, Well, Wells, Wind,
    WorldLaws, laws,
};
pub use methods::markers::{OwnMethod, mark_method, own_method};
pub use methods::table::{Claims, METHODS, Method};
pub use observe::forces_on::{
    ForceCause, LAWS_WITH_POTENTIAL, each_force, each_potential_energy, forces_on,
};
pub use observe::law_texts::LawTexts;
pub use observe::oscillator::BodyOscillator;
pub use observe::totals::{KineticEnergy, Totals, totals};
#[cfg(feature = "bevy")]
pub use schedule::drawing::FloatingOrigin;
#[cfg(feature = "bevy")]
pub use schedule::plugin::InertiaPlugin;
pub use schedule::requests::{Request, Requests};
pub use schedule::stepper::Stepper;
pub use schedule::systems::StepSystems;
pub use state::clock::TimeStep;
pub use state::components::{
    AxisLocks, Force, GravityOff, Orientation, PhysicsBody, Quarantined, SpeedLimit, StableId,
    Transform,
};
pub use state::emitter::{Dormant, Emission, Emitter, Particle, RidesOn};
pub use state::forces::{Forces, Push, PushQueue};
pub use state::previous_position::{PreviousPosition, remember_positions};
pub use state::range::Range;
pub use state::soft_form::SoftForm;
pub use state::springs::{Elastic, Link, SoftBody, Spring};
pub use state::static_bodies::Static;
pub use state::substeps::{AutoSubsteps, OwnSubsteps, Substeps};
pub use state::threads::Threads;
pub use tick::quarantine::{Cause, Fault, Quarantine, QuarantineRecord};

/// The items that most programs with bodies need. [`Transform`] is not among them, so that Bevy's prelude can
/// be used beside this one.
pub mod prelude {
    #[cfg(feature = "bevy")]
    pub use crate::InertiaPlugin;
    pub use crate::units::{Scalar, Vector};
    pub use crate::{
        Damping, DampingModel, Drag, Elastic, Emitter, Force, Forces, Gravity, Law, Laws, Method,
        OwnLaws, PhysicsBody, Push, PushQueue, Request, Requests, Spring, StepSystems, Stepper,
        TimeStep,
    };
}

/// The clock of ticks.
pub mod clock {
    pub use crate::state::clock::{ClockState, StepClock};
}

/// The effects of a scene, such as gravity, drag and springs, and the switch that turns them off and on.
pub mod effects {
    pub use crate::schedule::effects::{
        Effect, EffectState, NeverDeclared, column_bytes, state, switch,
    };
}

/// Margins of stability: how near the parts of a world are to the limit of their method, before a step is taken.
pub mod margin {
    pub use crate::observe::margin::{
        Cure, LimitingPart, Margin, Margins, MarginsInParts, NaturalMode, NaturalModes,
        SpringMargin, as_good_as, natural_modes,
    };
}

/// The ledger of energy, momentum and angular momentum: the amount that each cause added, and the residual, which is the error
/// of the method.
pub mod ledger {
    #[cfg(feature = "bevy")]
    pub use crate::observe::ledger::LedgerPlugin;
    pub use crate::observe::ledger::{Energies, Ledger, LedgerLines, LedgerTotals};
}

/// The inside of the crate, as its tests, its benchmarks and the other crates of its family use it. Any release may change it.
#[doc(hidden)]
pub mod internals {
    pub use crate::groups::{Grouped, Groups, Sets, Solver, compile_groups};
    pub use crate::laws::{Axes, BLOCK_BODIES, BodyBlock, DeviceForm, device_forms};
    pub use crate::schedule::backend::ParticleBackend;
    pub use crate::schedule::emission::{DueParticles, due_particles, emit_particles};
    pub use crate::schedule::plan::{Passes, StepPlan};
    pub use crate::schedule::systems::{
        apply_forces, clear_forces, insert_step_resources, step_schedule, step_systems,
    };
    pub use crate::state::archetypes::values;
    pub use crate::state::emitter::emitters_changed;
    pub use crate::tick::environment::{EnvironmentParam, TickOutput};
    pub use crate::tick::integrate::{
        Bodies, Unmarked, integrate_acceleration, integrate_in_one_pass, integrate_velocity,
    };
    pub use crate::tick::quarantine::quarantine_bodies;
}

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
