//! Draws a plain [`Frame`] with wgpu: the same picture in a window and without one.
//!
//! - [`Frame`]: the plain data of one picture, relative to the camera; [`Line`] and [`Surface`] are parts of it.
//! - [`Renderer`]: draws a frame into any view of the right format. `pipelines` has one pipeline for each thing that is drawn,
//!   `mesh` the unit meshes, `shadow` the shadow map, `buffers` what is kept from frame to frame, and `surfaces`, `translucent`
//!   and `panels` draw cloth and jelly, translucent bodies and egui's triangles.
//! - [`Layer`]: what another crate draws into a frame.
//! - [`Gpu`]: an adapter, real or software. [`Quality`]: how much work a picture may cost.
//! - [`Offscreen`] and [`WindowTarget`]: where the view comes from, a texture or a swap chain. [`Screen`]: a swap chain with all that
//!   draws into it.
//! - [`Image`], [`Film`] and [`Gif`]: a picture in memory and as a PNG file, and pictures as an animated PNG or GIF.
//! - [`RenderError`]: what went wrong, and what to do.
//!
//! Does not include: loading of meshes or images, translucent surfaces, more than one light, and any knowledge of
//! entities, bodies or input.

mod buffers;
mod changes;
mod error;
mod film;
mod frame;
mod gif;
mod gpu;
mod image;
mod layer;
mod lines;
mod mesh;
mod offscreen;
mod panels;
mod pipelines;
mod quality;
mod renderer;
mod screen;
mod shadow;
mod surface;
mod surfaces;
mod target;
mod translucent;

pub use self::gif::Gif;
pub use error::RenderError;
pub use film::Film;
pub use frame::{
    CHECKER, Camera, Frame, Ground, Instance, Light, OUTLINED, Panels, Particle, SHINES, Sprite,
    Translucent,
};
pub use gpu::{AdapterSummary, Gpu, Reading, caught};
pub use image::Image;
pub use layer::{Canvas, Kept, Layer};
pub use lines::Line;
pub use offscreen::{OFFSCREEN_FORMAT, Offscreen};
pub use pipelines::{layout as pipeline_layout, module as shader_module, uniform};
pub use quality::Quality;
pub use renderer::Renderer;
pub use screen::Screen;
pub use surface::{Surface, SurfaceVertex};
pub use target::{WindowFrame, WindowTarget};

pub use wgpu;
