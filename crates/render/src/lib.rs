//! A plain [`Frame`] to pixels with wgpu: the same picture in a window and without one.
//!
//! [`Gpu`] finds an adapter, [`Renderer::draw`] draws a [`Frame`] into any view of the right format, and that view
//! comes from an [`Offscreen`] texture or from a [`WindowTarget`]. Everything in a frame is relative to the camera.
//!
//! Does not include: loading of meshes or images, translucent surfaces, more than one light, and any knowledge of
//! entities, bodies or input.

mod buffers;
mod error;
mod film;
mod frame;
mod gpu;
mod image;
mod lines;
mod mesh;
mod offscreen;
mod panels;
mod pipelines;
mod quality;
mod renderer;
mod shadow;
mod surface;
mod surfaces;
mod target;
mod translucent;

pub use error::RenderError;
pub use film::Film;
pub use frame::{
    CHECKER, Camera, Frame, Ground, Instance, Light, OUTLINED, Panels, Particle, Sprite, Translucent,
};
pub use gpu::{AdapterSummary, Gpu};
pub use image::Image;
pub use lines::Line;
pub use offscreen::{OFFSCREEN_FORMAT, Offscreen};
pub use quality::Quality;
pub use renderer::Renderer;
pub use surface::{Surface, SurfaceVertex};
pub use target::{WindowFrame, WindowTarget};

pub use wgpu;
