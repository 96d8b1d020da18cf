//! State: the components and resources of bodies, forces, springs, emitters and clocks, without the systems that use
//! them.

pub(crate) mod archetypes;
pub(crate) mod clock;
pub(crate) mod components;
pub(crate) mod coupling;
pub(crate) mod emitter;
pub(crate) mod forces;
pub(crate) mod interpolate;
pub(crate) mod method_state;
pub(crate) mod off;
pub(crate) mod range;
pub(crate) mod rest;
pub(crate) mod springs;
pub(crate) mod substeps;
pub(crate) mod threads;
