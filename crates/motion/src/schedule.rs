//! The schedule: the systems that a tick is compiled of, and the changes of a world between two ticks.

pub(crate) mod effects;
pub(crate) mod emission;
pub(crate) mod plan;
#[cfg(feature = "bevy")]
pub(crate) mod plugin;
pub(crate) mod requests;
pub(crate) mod restart;
pub(crate) mod stepper;
#[path = "../../swarm/src/log.rs"]
pub(crate) mod swarm;
#[cfg(feature = "serde")]
#[path = "../../swarm/src/files.rs"]
mod swarm_files;
#[path = "../../swarm/src/laws.rs"]
pub(crate) mod swarm_laws;
#[path = "../../swarm/src/swarm.rs"]
pub(crate) mod swarms;
pub(crate) mod systems;

#[cfg(test)]
mod tests;
