//! Draws swarms as sprites, from the buffers in which they are stepped.

use bytemuck::bytes_of;
use wgpu::{
    BindGroupLayout, BufferUsages, CompareFunction, RenderPass, ShaderStages, VertexBufferLayout,
};

use crate::Gpu;
use crate::pipelines::{Destination, Drawing, GLOBALS, SPRITE, layout, module};
use crate::swarm::{SWARM, Swarms};
use crate::swarm_parameters::{LookParameters, Parameters};
use crate::swarm_tick::Swarm;

const DRAW: &str = include_str!("../shaders/draw.wgsl");

const ROWS: [Option<VertexBufferLayout<'_>>; 2] = [
    Some(VertexBufferLayout {
        array_stride: 16,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![0 => Uint32x4],
    }),
    Some(VertexBufferLayout {
        array_stride: 16,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![1 => Uint32x4],
    }),
];

/// The swarms of a renderer.
pub(crate) struct SwarmPainter {
    pub swarms: Swarms,
    pipeline: wgpu::RenderPipeline,
    bindings: BindGroupLayout,
    /// For each swarm of the frame: the last tick, its look, and both bound.
    uniforms: Vec<(wgpu::Buffer, wgpu::Buffer, wgpu::BindGroup)>,
}

impl SwarmPainter {
    pub fn new(
        gpu: &Gpu,
        globals: &BindGroupLayout,
        shadow_map: &BindGroupLayout,
        to: &Destination,
    ) -> Self {
        let device = &gpu.device;
        let uniform = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::VERTEX,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let bindings = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("swarm look"),
            entries: &[uniform(0), uniform(1)],
        });
        let layout =
            layout(device, "swarm picture", &[Some(globals), Some(shadow_map), Some(&bindings)]);
        let drawing = Drawing {
            label: "swarm",
            shader: &module(device, "swarm picture", &[GLOBALS, SPRITE, SWARM, DRAW]),
            vertex: "vs_swarm",
            fragment: Some("fs_sprite"),
            rows: &ROWS,
            constants: &[to.srgb()],
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            cull: None,
            // As with sprites, a soft edge must not hide what is behind it.
            writes_depth: false,
            depth_compare: Some(CompareFunction::LessEqual),
            depth_bias: wgpu::DepthBiasState::default(),
            blend: Some(wgpu::BlendState::ALPHA_BLENDING),
        };
        let pipeline = drawing.pipeline(device, &layout, to);
        Self { swarms: Swarms::new(gpu), pipeline, bindings, uniforms: Vec::new() }
    }

    /// Advances the device to the last tick of each of `swarms`, and sets the uniforms to their looks.
    pub fn follow(&mut self, gpu: &Gpu, swarms: &[Swarm]) {
        self.swarms.follow(gpu, swarms);
        self.uniforms.truncate(swarms.len());
        while self.uniforms.len() < swarms.len() {
            self.uniforms.push(self.uniforms(gpu));
        }
        for ((swarm, device), (tick, look, _)) in
            swarms.iter().zip(self.swarms.devices()).zip(&self.uniforms)
        {
            if let Some(last) = &device.last {
                gpu.queue.write_buffer(tick, 0, bytes_of(last));
            }
            gpu.queue.write_buffer(look, 0, bytes_of(&LookParameters::from(swarm.look)));
        }
    }

    fn uniforms(&self, gpu: &Gpu) -> (wgpu::Buffer, wgpu::Buffer, wgpu::BindGroup) {
        let buffer = |size: usize| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("swarm look"),
                size: size as u64,
                usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let (tick, look) = (buffer(size_of::<Parameters>()), buffer(size_of::<LookParameters>()));
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("swarm look"),
            layout: &self.bindings,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: tick.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: look.as_entire_binding() },
            ],
        });
        (tick, look, group)
    }

    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        for (device, (_, _, group)) in self.swarms.devices().iter().zip(&self.uniforms) {
            if device.last.is_none() {
                continue;
            }
            let [positions, others] = device.rows.in_order();
            pass.set_bind_group(2, group, &[]);
            pass.set_vertex_buffer(0, positions.slice(..));
            pass.set_vertex_buffer(1, others.slice(..));
            pass.draw(0..4, 0..device.slots());
        }
    }
}
