//! Linear motion on an entity component system: `Transform`, `PhysicsBody` and `Force`, moved by scheduled
//! systems.
//!
//! In order of importance, this crate is for: motion that can be proven against theory; hard cases that stay
//! finite; a step that costs what the arithmetic costs. It reads no file, no device and no clock.
//!
//! Does not include: rotation dynamics, collisions, friction, contact of any kind.

mod bare;
mod blocks;
mod clock;
mod components;
mod course;
mod diagnosis;
mod effects;
mod emission;
mod emitter;
mod epoch;
mod evaluations;
mod forces;
mod forces_on;
mod forecast;
mod groups;
mod integrate;
mod interpolate;
mod kept;
mod laws;
mod ledger;
mod method;
pub mod methods;
mod own;
mod quarantine;
mod range;
pub mod real;
mod record;
mod requests;
mod rest;
mod springs;
mod step;
mod stepper;
mod switch;
mod threads;
mod totals;
pub mod units;

pub use bare::{Bare, BareState, LawsOf, NotForArrays};
pub use clock::{BadTime, ClockState, Due, FrameClock, FrameTime, StepClock, TickClock};
pub use components::{
    AxisLocks, Force, GravityOff, Orientation, PhysicsBody, Quarantined, SpeedLimit, StableId, Transform,
};
pub use effects::{Damping, DampingModel, DampingRate};
pub use emission::{Emission, EmissionState, Particle, emit_particles};
pub use emitter::{Dormant, Emitter};
pub use evaluations::{Evaluations, Iterations};
pub use forces::{Forces, Push, PushQueue, PushedBodies};
pub use forces_on::{ForceCause, each_force, forces_on};
pub use forecast::{Cure, Forecast, Margin, Part, SpringMargin};
pub use groups::{Grouped, Groups, Sets, Solver, compile_groups, integrate_groups};
pub use integrate::{
    Acting, Bodies, Notes, Unmarked, integrate, integrate_acceleration, integrate_in_one_pass,
    integrate_velocity,
};
pub use interpolate::{PreviousPosition, remember_positions};
pub use kept::{KeptAcceleration, KeptAccelerations, KeptOfGroup};
pub use laws::{
    Affine, BodyState, Curve, Drag, Gravity, Jacobians, LAWS, Law, LawTexts, Laws, Moment, MutualGravity,
    SourceMass, Thrust, Well, Wells, Wind, laws,
};
pub use ledger::{Books, Energies, Ledger, Lines};
pub use method::{Claims, METHODS, Method};
pub use own::{
    LastAcceleration, LastStep, OwnLaws, OwnMethod, OwnSubsteps, Substeps, mark_method, own_method,
};
pub use quarantine::{Cause, Fault, Quarantine, QuarantineRecord, quarantine_bodies};
pub use range::Range;
pub use requests::{Request, Requests};
pub use rest::Static;
pub use springs::{Elastic, Link, SoftBody, Spring};
pub use step::{
    Passes, Step, StepPlan, StepSystems, TimeStep, apply_forces, clear_forces, insert_step_resources,
    remember_accelerations, remember_steps, step_schedule, step_systems,
};
pub use stepper::Stepper;
pub use switch::{
    Effect, EffectState, NeverDeclared, Off, OffResource, SpringsOff, column_bytes, state, switch,
};
pub use threads::Threads;
pub use totals::{KineticEnergy, Totals, totals};
