//! Paints egui's triangles over a finished picture.

use std::collections::HashMap;
use std::sync::Arc;

use egui::epaint::{ImageData, ImageDelta, Primitive, Vertex};
use egui::{
    ClippedPrimitive, ColorImage, TextureFilter, TextureId, TextureOptions, TextureWrapMode,
};
use wgpu::{BindGroup, BindGroupLayout, Device, VertexBufferLayout};

use crate::buffers::InstanceBuffer;
use crate::pipelines::{Destination, Drawing, GLOBALS, layout, module};
use crate::{Frame, Gpu, Panels};

const PANEL: &str = include_str!("../shaders/panel.wgsl");

const ROWS: [Option<VertexBufferLayout<'_>>; 1] = [Some(VertexBufferLayout {
    array_stride: size_of::<Vertex>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4],
})];

/// Blending as in egui: alpha says how much of the picture below is covered, and colors are added.
const PREMULTIPLIED: wgpu::BlendState = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;

/// Draws panels. `egui-wgpu` filters images by hand, so that machines agree to the last bit: on a software adapter, panels took it
/// 90 ms that take 12 ms here, and no pixel differed.
pub(crate) struct PanelPainter {
    pipeline: wgpu::RenderPipeline,
    image_layout: BindGroupLayout,
    images: HashMap<TextureId, Loaded>,
    vertices: InstanceBuffer,
    indices: InstanceBuffer,
    gathered_vertices: Vec<Vertex>,
    gathered_indices: Vec<u32>,
}

/// An image of egui on the adapter, and in memory for the next one, if this is lost: egui sends it once.
struct Loaded {
    texture: wgpu::Texture,
    group: BindGroup,
    image: Arc<ColorImage>,
    options: TextureOptions,
}

impl PanelPainter {
    pub fn new(device: &Device, globals: &BindGroupLayout, to: &Destination) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let image_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("image of panels"),
            entries: &[
                entry(
                    0,
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: true },
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    },
                ),
                entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            ],
        });
        let to = Destination { format: to.format, samples: 1 };
        let pipeline = Drawing {
            label: "panels",
            shader: &module(device, "panels", &[GLOBALS, PANEL]),
            vertex: "vs_panel",
            fragment: Some("fs_panel"),
            has_color: true,
            rows: &ROWS,
            constants: &[to.srgb()],
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull: None,
            writes_depth: false,
            depth_compare: None,
            depth_bias: wgpu::DepthBiasState::default(),
            blend: Some(PREMULTIPLIED),
        };
        Self {
            pipeline: pipeline.pipeline(
                device,
                &layout(device, "panels", &[Some(globals), Some(&image_layout)]),
                &to,
            ),
            image_layout,
            images: HashMap::new(),
            vertices: InstanceBuffer::new(device, "vertices of panels"),
            indices: InstanceBuffer::of_indices(device, "indices of panels"),
            gathered_vertices: Vec::new(),
            gathered_indices: Vec::new(),
        }
    }

    /// Uploads changed textures. Must run for every frame, drawn or not, because egui sends each change of a texture
    /// once.
    pub fn update_textures(&mut self, gpu: &Gpu, panels: &Panels) {
        for (id, deltas) in &panels.textures_delta.set {
            for delta in deltas {
                self.update_texture(gpu, *id, delta);
            }
        }
    }

    fn update_texture(&mut self, gpu: &Gpu, id: TextureId, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let [width, height] = image.size.map(|side| side as u32);
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        if delta.pos.is_none() {
            let loaded = Loaded::new(&gpu.device, &self.image_layout, size, delta);
            self.images.insert(id, loaded);
        }
        // A change of an image that was never sent is ignored.
        let Some(Loaded { texture, image: kept, .. }) = self.images.get_mut(&id) else { return };
        if let Some(place) = delta.pos {
            replace(Arc::make_mut(kept), image, place);
        }
        let [x, y] = delta.pos.unwrap_or_default().map(|side| side as u32);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x, y, z: 0 },
                ..texture.as_image_copy()
            },
            bytemuck::cast_slice(&image.pixels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * width),
                rows_per_image: Some(height),
            },
            size,
        );
    }

    /// Uploads the images that `lost` had on another device.
    pub fn take_images(&mut self, gpu: &Gpu, lost: Self) {
        for (id, Loaded { image, options, .. }) in lost.images {
            self.update_texture(gpu, id, &ImageDelta::full(image, options));
        }
    }

    /// Drops the textures that are not used after this frame.
    pub fn free_textures(&mut self, panels: &Panels) {
        for id in &panels.textures_delta.free {
            self.images.remove(id);
        }
    }

    /// Records drawing the panels of `frame` over the content of `view`.
    pub fn paint(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        globals: &BindGroup,
        frame: &Frame,
    ) {
        let Some(panels) = &frame.panels else { return };
        if !self.upload(gpu, &panels.primitives) {
            return;
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("panels"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, globals, &[]);
        pass.set_index_buffer(self.indices.buffer().slice(..), wgpu::IndexFormat::Uint32);
        let (mut first, mut offset) = (0, 0);
        for ClippedPrimitive { clip_rect, primitive } in &panels.primitives {
            let Primitive::Mesh(mesh) = primitive else { continue };
            let indices = first..first + mesh.indices.len() as u32;
            let image = self.images.get(&mesh.texture_id);
            if let (Some(image), Some([left, top, width, height])) =
                (image, clip(clip_rect, frame.pixels_per_point(), frame.size_px))
            {
                pass.set_scissor_rect(left, top, width, height);
                pass.set_bind_group(1, &image.group, &[]);
                // Not by a base vertex, which WebGL 2 has not.
                pass.set_vertex_buffer(0, self.vertices.buffer().slice(offset..));
                pass.draw_indexed(indices.clone(), 0, 0..1);
            }
            first = indices.end;
            offset += size_of_val(&mesh.vertices[..]) as u64;
        }
    }

    /// Uploads the vertices and indices. Returns whether there is something to draw and room for it.
    fn upload(&mut self, gpu: &Gpu, primitives: &[ClippedPrimitive]) -> bool {
        self.gathered_vertices.clear();
        self.gathered_indices.clear();
        for ClippedPrimitive { primitive, .. } in primitives {
            if let Primitive::Mesh(mesh) = primitive {
                self.gathered_vertices.extend_from_slice(&mesh.vertices);
                self.gathered_indices.extend_from_slice(&mesh.indices);
            }
        }
        let vertices = self.vertices.upload(gpu, &self.gathered_vertices) as usize;
        let indices = self.indices.upload(gpu, &self.gathered_indices) as usize;
        indices > 0
            && vertices == self.gathered_vertices.len()
            && indices == self.gathered_indices.len()
    }
}

impl Loaded {
    fn new(
        device: &Device,
        layout: &BindGroupLayout,
        size: wgpu::Extent3d,
        delta: &ImageDelta,
    ) -> Self {
        let (ImageData::Color(image), options) = (&delta.image, delta.options);
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("image of panels"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let filter = |filter| match filter {
            TextureFilter::Nearest => wgpu::FilterMode::Nearest,
            TextureFilter::Linear => wgpu::FilterMode::Linear,
        };
        let wrap = match options.wrap_mode {
            TextureWrapMode::ClampToEdge => wgpu::AddressMode::ClampToEdge,
            TextureWrapMode::Repeat => wgpu::AddressMode::Repeat,
            TextureWrapMode::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
        };
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("image of panels"),
            mag_filter: filter(options.magnification),
            min_filter: filter(options.minification),
            address_mode_u: wrap,
            address_mode_v: wrap,
            ..Default::default()
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("image of panels"),
            layout,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&view),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&sampler),
                },
            ],
        });
        Self { texture, group, image: Arc::clone(image), options }
    }
}

/// Puts `part` into `image`, with its corner at the pixel `x`, `y`.
fn replace(image: &mut ColorImage, part: &ColorImage, [x, y]: [usize; 2]) {
    let width = image.size[0];
    for (row, pixels) in part.pixels.chunks_exact(part.size[0].max(1)).enumerate() {
        let start = (y + row) * width + x;
        image.pixels[start..start + pixels.len()].copy_from_slice(pixels);
    }
}

/// Left, top, width and height in pixels of the visible part of `rect`, points; `None` if no part is visible.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded; casts saturate"
)]
fn clip(rect: &egui::Rect, scale: f32, size_px: [u32; 2]) -> Option<[u32; 4]> {
    let edge = |points: f32, most: u32| ((points * scale).round() as u32).min(most);
    let [left, right] = [rect.min.x, rect.max.x].map(|x| edge(x, size_px[0]));
    let [top, bottom] = [rect.min.y, rect.max.y].map(|y| edge(y, size_px[1]));
    (left < right && top < bottom).then(|| [left, top, right - left, bottom - top])
}
