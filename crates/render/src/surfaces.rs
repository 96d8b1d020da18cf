//! Draws surfaces: their pipelines, and the buffers that each frame refills.
//!
//! A sheet has no inside. So both sides are drawn, and the outline of a selected sheet consists of copies that are
//! moved on the screen, instead of a larger body behind it.

use std::ops::Range;

use wgpu::{
    BindGroupLayout, CompareFunction, Device, RenderPass, RenderPipeline, VertexBufferLayout,
};

use crate::pipelines::{Destination, Drawing, GLOBALS, LIGHT, OUTLINE_PX, RIM_PX, layout, module};
use crate::surface::silhouette;
use crate::{Gpu, Surface, SurfaceVertex, buffers::InstanceBuffer};

const SURFACE: &str = include_str!("../shaders/surface.wgsl");

/// Number of copies of a surface that make its outline; `vs_outline` moves each in another direction.
const DIRECTIONS: u32 = 8;

/// Bias added to depths in the shadow map, per texel of slope: unlike a body, a sheet has only one face for the map
/// and is compared with itself.
const SLOPE_BIAS: f32 = 1.5;

const ROWS: [Option<VertexBufferLayout<'_>>; 1] = [Some(VertexBufferLayout {
    array_stride: size_of::<SurfaceVertex>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Unorm8x4, 2 => Float32x3],
})];

const EDGE_ROWS: [Option<VertexBufferLayout<'_>>; 1] = [Some(VertexBufferLayout {
    array_stride: size_of::<[SurfaceVertex; 2]>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Unorm8x4, 2 => Float32x3, 3 => Float32x3, 4 => Unorm8x4, 5 => Float32x3
    ],
})];

/// Frames with more triangles have hard edges: where a pixel has one sample, edges are drawn in software.
const MOST_SMOOTHED: usize = 5_000;

/// All surfaces of a frame in one buffer of vertices and one of indices, the outlined ones last.
pub(crate) struct Surfaces {
    shadow: RenderPipeline,
    body: RenderPipeline,
    rim: RenderPipeline,
    outline: RenderPipeline,
    edge: RenderPipeline,
    vertices: InstanceBuffer,
    indices: InstanceBuffer,
    gathered_vertices: Vec<SurfaceVertex>,
    gathered_triangles: Vec<[u32; 3]>,
    edges: InstanceBuffer,
    /// Soft edges.
    soft: u32,
    /// Indices of the surfaces without an outline.
    plain: u32,
    /// All indices.
    total: u32,
}

impl Surfaces {
    pub fn new(
        device: &Device,
        globals: &BindGroupLayout,
        shadow_map: &BindGroupLayout,
        to: &Destination,
    ) -> Self {
        let shader = module(device, "surface", &[GLOBALS, LIGHT, SURFACE]);
        let picture = layout(device, "surfaces", &[Some(globals), Some(shadow_map)]);
        let from_light = layout(device, "surfaces from light", &[Some(globals)]);
        let srgb = to.srgb();
        let body = Drawing {
            label: "surface",
            shader: &shader,
            vertex: "vs_surface",
            fragment: Some("fs_surface"),
            has_color: true,
            rows: &ROWS,
            constants: &[srgb],
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull: None,
            writes_depth: true,
            depth_compare: Some(CompareFunction::Less),
            depth_bias: wgpu::DepthBiasState::default(),
            blend: None,
        };
        let outline = |label, width_px, bright| {
            Drawing {
                label,
                vertex: "vs_outline",
                fragment: Some("fs_outline"),
                constants: &[srgb, ("outline_px", width_px), ("outline_bright", bright)],
                writes_depth: false,
                ..body
            }
            .pipeline(device, &picture, to)
        };
        Self {
            shadow: Drawing {
                label: "shadow of surface",
                vertex: "vs_shadow",
                fragment: None,
                has_color: false,
                constants: &[],
                depth_bias: wgpu::DepthBiasState { slope_scale: SLOPE_BIAS, ..Default::default() },
                ..body
            }
            .pipeline(
                device,
                &from_light,
                &Destination { format: to.format, samples: 1 },
            ),
            rim: outline("rim of surface", RIM_PX, 0.0),
            outline: outline("outline of surface", OUTLINE_PX, 1.0),
            edge: Drawing {
                label: "edge of surface",
                vertex: "vs_edge",
                fragment: Some("fs_edge"),
                rows: &EDGE_ROWS,
                topology: wgpu::PrimitiveTopology::TriangleStrip,
                writes_depth: false,
                blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                ..body
            }
            .pipeline(device, &picture, to),
            body: body.pipeline(device, &picture, to),
            vertices: InstanceBuffer::new(device, "vertices of surfaces"),
            indices: InstanceBuffer::of_indices(device, "indices of surfaces"),
            gathered_vertices: Vec::new(),
            gathered_triangles: Vec::new(),
            edges: InstanceBuffer::new(device, "edges of surfaces"),
            soft: 0,
            plain: 0,
            total: 0,
        }
    }

    /// Copies the surfaces of a frame to the adapter, with `soft` edges or without.
    pub fn upload(&mut self, gpu: &Gpu, surfaces: &[Surface], soft: bool) {
        let triangles: usize = surfaces.iter().map(|surface| surface.triangles.len()).sum();
        let soft = soft && triangles <= MOST_SMOOTHED;
        let smoothed = surfaces.iter().filter(|surface| soft && !surface.outlined);
        let edges: Vec<_> = smoothed.flat_map(silhouette).collect();
        self.soft = self.edges.upload(gpu, &edges);
        self.gathered_vertices.clear();
        self.gathered_triangles.clear();
        let mut plain = 0;
        for outlined in [false, true] {
            for surface in surfaces.iter().filter(|surface| surface.outlined == outlined) {
                let first = self.gathered_vertices.len() as u32;
                self.gathered_vertices.extend(&surface.vertices);
                let moved =
                    surface.triangles.iter().map(|triangle| triangle.map(|corner| corner + first));
                self.gathered_triangles.extend(moved);
            }
            if !outlined {
                plain = self.gathered_triangles.len() as u32;
            }
        }
        let vertices = self.vertices.upload(gpu, &self.gathered_vertices);
        // With more points than the largest buffer of the adapter holds, draw nothing, rather than triangles with
        // missing points.
        let all = vertices as usize == self.gathered_vertices.len();
        let triangles = if all { self.indices.upload(gpu, &self.gathered_triangles) } else { 0 };
        (self.plain, self.total) = (3 * plain.min(triangles), 3 * triangles);
    }

    pub fn draw_shadows(&self, pass: &mut RenderPass<'_>) {
        self.draw(pass, &self.shadow, 0..self.total, 1);
    }

    pub fn draw_plain(&self, pass: &mut RenderPass<'_>) {
        self.draw(pass, &self.body, 0..self.plain, 1);
    }

    /// The outlines write no depth: draw them after everything that they cover and before the surfaces that they
    /// surround.
    pub fn draw_outlined(&self, pass: &mut RenderPass<'_>) {
        for (pipeline, copies) in
            [(&self.rim, DIRECTIONS), (&self.outline, DIRECTIONS), (&self.body, 1)]
        {
            self.draw(pass, pipeline, self.plain..self.total, copies);
        }
    }

    /// The soft edges write no depth: draw them after everything that is seen behind them.
    pub fn draw_edges(&self, pass: &mut RenderPass<'_>) {
        self.edges.draw_quads(pass, &self.edge, 0..self.soft);
    }

    fn draw(
        &self,
        pass: &mut RenderPass<'_>,
        pipeline: &RenderPipeline,
        indices: Range<u32>,
        copies: u32,
    ) {
        if !indices.is_empty() {
            pass.set_pipeline(pipeline);
            pass.set_vertex_buffer(0, self.vertices.buffer().slice(..));
            pass.set_index_buffer(self.indices.buffer().slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(indices, 0, 0..copies);
        }
    }
}
