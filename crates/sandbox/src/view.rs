//! A simulation and how it is looked at: the camera, where things are drawn, the picture and the words in it.

pub(crate) mod arrows;
pub(crate) mod camera;
pub(crate) mod card;
mod forces;
mod ground;
pub(crate) mod hud;
pub(crate) mod inks;
pub(crate) mod labels;
pub(crate) mod marks;
pub(crate) mod notices;
pub(crate) mod options;
pub(crate) mod picture;
pub(crate) mod pose;
pub(crate) mod pull;
mod read;
pub(crate) mod recorded;
mod recording;
mod soft;
pub(crate) mod springs;
pub(crate) mod stage;
pub(crate) mod things;
mod told;
mod trails;
