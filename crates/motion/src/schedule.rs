//! The schedule: the systems that a tick is compiled of, and the changes of a world between two ticks.

pub(crate) mod backend;
#[cfg(feature = "bevy")]
pub(crate) mod drawing;
pub(crate) mod effects;
pub(crate) mod emission;
pub(crate) mod plan;
#[cfg(feature = "bevy")]
pub(crate) mod plugin;
pub(crate) mod requests;
pub(crate) mod restart;
pub(crate) mod stepper;
pub(crate) mod systems;

#[cfg(test)]
mod tests;
