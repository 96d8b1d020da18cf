//! Linear motion on an entity component system: `Transform`, `PhysicsBody` and `Force`, moved by four scheduled
//! systems.
//!
//! In order of importance, this crate is for: motion that can be proven against theory; hard cases that stay
//! finite; a step that costs what the arithmetic costs. It reads no file, no device and no clock.
//!
//! Does not include: rotation dynamics, collisions, friction, contact of any kind.

mod clock;
mod components;
mod effects;
mod forces;
mod interpolate;
mod kernels;
mod quarantine;
mod requests;
mod step;
mod stepper;
mod totals;
pub mod units;

pub use clock::{BadTime, Due, FrameClock, FrameTime, StepClock, TickClock};
pub use components::{
    AxisLocks, Force, GravityOff, Orientation, PhysicsBody, Quarantined, SpeedLimit, StableId, Transform,
};
pub use effects::{Damping, DampingModel, DampingRate, Gravity};
pub use forces::{Forces, Push, PushQueue, PushedBodies};
pub use interpolate::{PreviousPosition, remember_positions};
pub use quarantine::{Cause, Quarantine, QuarantineRecord, quarantine_bodies};
pub use requests::{Request, Requests};
pub use step::{
    Laws, Method, Passes, Step, TimeStep, apply_forces, clear_forces, insert_step_resources,
    integrate_acceleration, integrate_in_one_pass, integrate_velocity, step_schedule,
};
pub use stepper::Stepper;
pub use totals::{Totals, totals};
