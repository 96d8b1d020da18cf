//! Swarms: the particles of emitters that live on a graphics device alone.
//!
//! - [`Swarm`]: the component of an emitter whose particles are on a device. In every tick of its world, [`advance_swarms`]
//!   enters into its [`SwarmLog`] a [`SwarmTick`] in plain numbers: which particles are born, which die, and the
//!   [`SwarmLaws`]. The state of the particles follows from the log alone, so that a device can compute it at any time, and
//!   again after going back. This part knows no device.
//! - With the feature `device`: `Swarms` steps swarms on a device, `SwarmLayer` draws them into a `render::Frame`.
//!
//! The formulas of the laws are in shaders/step.wgsl; a law says which is its own by
//! [`device_form`](motion::Law::device_form).

#[cfg(feature = "device")]
mod device;
mod files;
mod laws;
mod log;
#[cfg(feature = "device")]
mod painter;
#[cfg(feature = "device")]
mod parameters;
#[cfg(feature = "device")]
mod picture;
mod swarm;

#[cfg(feature = "device")]
pub use device::{SwarmError, SwarmParticle, Swarms};
pub use laws::SwarmLaws;
pub use log::{SwarmLog, SwarmTick};
#[cfg(feature = "device")]
pub use painter::SwarmLayer;
#[cfg(feature = "device")]
pub use picture::{DrawnSwarm, SwarmLook};
pub use swarm::{Swarm, advance_swarms};
