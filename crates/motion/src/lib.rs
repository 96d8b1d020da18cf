//! Linear motion on an entity component system: `Transform`, `PhysicsBody` and `Force`, moved by scheduled
//! systems.
//!
//! In order of importance, this crate is for: motion that can be proven against theory; hard cases that stay
//! finite; a step that costs what the arithmetic costs. It reads no file, no device and no clock.
//!
//! Does not include: rotation dynamics, collisions, friction, contact of any kind.

mod arrays;
mod groups;
mod kernels;
mod laws;
pub mod methods;
mod observe;
pub mod real;
mod schedule;
mod state;
mod tick;
pub mod units;

pub use arrays::{Bare, BareState, LawsOf, NotForArrays};
pub use groups::{Groups, Sets, Solver, compile_groups, integrate_groups};
pub use kernels::evaluations::{Evaluations, Iterations};
pub use laws::damping::{Damping, DampingModel, DampingRate};
pub use laws::own::OwnLaws;
pub use laws::{
    Affine, BodyState, Curve, Drag, EvaluationTime, Gravity, Jacobians, LAWS, Law, Laws, MutualGravity,
    SourceMass, Thrust, Well, Wells, Wind, laws,
};
pub use methods::markers::{OwnMethod, mark_method, own_method};
pub use methods::table::{Claims, METHODS, Method};
pub use observe::cached_accelerations::{
    CachedAccelerations, CachedBodyAcceleration, CachedGroupAccelerations,
};
pub use observe::forces_on::{ForceCause, each_force, forces_on};
pub use observe::forecast::{Cure, Forecast, LimitingPart, Margin, SpringMargin};
pub use observe::law_texts::LawTexts;
pub use observe::ledger::{Energies, Ledger, LedgerLines, LedgerTotals};
pub use observe::totals::{KineticEnergy, Totals, totals};
pub use schedule::effects::{Effect, EffectState, NeverDeclared, column_bytes, state, switch};
pub use schedule::emission::emit_particles;
pub use schedule::plan::{Passes, StepPlan};
#[cfg(feature = "bevy")]
pub use schedule::plugin::InertiaPlugin;
pub use schedule::requests::{Request, Requests};
pub use schedule::stepper::Stepper;
pub use schedule::systems::{
    StepSystems, apply_forces, clear_forces, insert_step_resources, step_schedule, step_systems,
};
pub use state::clock::{BadTime, ClockState, Due, FrameClock, FrameTime, StepClock, TickClock, TimeStep};
pub use state::components::{
    AxisLocks, Force, GravityOff, Orientation, PhysicsBody, Quarantined, SpeedLimit, StableId, Transform,
};
pub use state::coupling::Grouped;
pub use state::emitter::{Dormant, Emission, EmissionState, Emitter, Particle};
pub use state::forces::{Forces, Push, PushQueue, PushedBodies};
pub use state::method_state::{LastAcceleration, LastStep};
pub use state::previous_position::{PreviousPosition, remember_positions};
pub use state::range::Range;
pub use state::springs::{Elastic, Link, SoftBody, Spring};
pub use state::static_bodies::Static;
pub use state::substeps::{OwnSubsteps, Substeps};
pub use state::switched_off::{Off, OffResource, SpringsOff};
pub use state::threads::Threads;
pub use tick::environment::{EnvironmentParam, TickOutput};
pub use tick::integrate::{
    Bodies, Unmarked, integrate, integrate_acceleration, integrate_in_one_pass, integrate_velocity,
};
pub use tick::quarantine::{Cause, Fault, Quarantine, QuarantineRecord, quarantine_bodies};
