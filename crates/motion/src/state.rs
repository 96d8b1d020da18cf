//! State: the components and resources of bodies, forces, springs, emitters and clocks, without the systems that use
//! them.

pub(crate) mod archetypes;
pub(crate) mod clock;
pub(crate) mod components;
pub(crate) mod coupling;
pub(crate) mod disabled;
pub(crate) mod emitter;
pub(crate) mod forces;
pub(crate) mod method_state;
pub(crate) mod previous_position;
pub(crate) mod range;
pub(crate) mod soft_form;
pub(crate) mod springs;
pub(crate) mod static_bodies;
pub(crate) mod substeps;
pub(crate) mod switched_off;
pub(crate) mod threads;
