//! Layers: what another crate draws into a picture, from what it keeps on the device.

use std::any::Any;

use wgpu::{BindGroupLayout, RenderPass, VertexBufferLayout};

use crate::Gpu;
use crate::pipelines::{Destination, sprites};

/// A part of a frame that another crate draws, over the sprites.
pub trait Layer: Send + Sync {
    /// Brings what is kept on the device to the state of this frame. `kept` is what the layer of the last frame left there.
    fn prepare(&self, gpu: &Gpu, canvas: &Canvas<'_>, kept: &mut Kept);

    /// Draws what `prepare` has kept. The bind groups 0 and 1 are those of all pictures.
    fn draw(&self, kept: &Kept, pass: &mut RenderPass<'_>);
}

/// What a layer keeps from frame to frame.
pub type Kept = Option<Box<dyn Any + Send + Sync>>;

/// Makes the pipelines of a [`Layer`].
pub struct Canvas<'a> {
    pub(crate) globals: &'a BindGroupLayout,
    pub(crate) shadow_map: &'a BindGroupLayout,
    pub(crate) destination: &'a Destination,
}

impl Canvas<'_> {
    /// A pipeline that draws a sprite per instance, as four vertices of a strip. `shader` follows shaders/globals.wgsl and
    /// shaders/sprite.wgsl, `vertex` is its entry, and `group` is bind group 2.
    pub fn sprites(
        &self,
        gpu: &Gpu,
        shader: &[&str],
        vertex: &str,
        rows: &[Option<VertexBufferLayout<'_>>],
        group: &BindGroupLayout,
    ) -> wgpu::RenderPipeline {
        let groups = [Some(self.globals), Some(self.shadow_map), Some(group)];
        sprites(&gpu.device, &groups, self.destination, shader, vertex, rows)
    }
}
