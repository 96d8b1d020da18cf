//! Draws swarms as sprites, from the buffers in which they are stepped.

use bytemuck::bytes_of;
use render::wgpu::{
    self, BindGroupLayout, BufferUsages, RenderPass, ShaderStages, VertexBufferLayout,
};
use render::{Canvas, Gpu, Kept, Layer, uniform};

use crate::device::{Swarms, TICK, buffer};
use crate::parameters::Parameters;
use crate::picture::{DrawnSwarm, SwarmLook};

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

/// Draws the swarms of a frame. An adapter that cannot have them draws none: see [`Swarms::check`].
#[derive(Clone, Debug)]
pub struct SwarmLayer(pub Vec<DrawnSwarm>);

impl SwarmLayer {
    /// The swarms on the device, if a layer of swarms has kept them.
    #[must_use]
    pub fn swarms(kept: &Kept) -> Option<&Swarms> {
        painter(kept).map(|painter| &painter.swarms)
    }
}

fn painter(kept: &Kept) -> Option<&SwarmPainter> {
    kept.as_ref()?.downcast_ref()
}

impl Layer for SwarmLayer {
    fn prepare(&self, gpu: &Gpu, canvas: &Canvas<'_>, kept: &mut Kept) {
        let fits = |drawn: &DrawnSwarm| Swarms::check(gpu, drawn.swarm.slots()).is_ok();
        if !self.0.iter().all(fits) {
            *kept = None;
            return;
        }
        let mut painter = match kept.take().map(|kept| kept.downcast()) {
            Some(Ok(painter)) => painter,
            _ => Box::new(SwarmPainter::new(gpu, canvas)),
        };
        painter.follow(gpu, &self.0);
        *kept = Some(painter);
    }

    fn draw(&self, kept: &Kept, pass: &mut RenderPass<'_>) {
        if let Some(painter) = painter(kept) {
            painter.draw(pass);
        }
    }
}

/// What a [`SwarmLayer`] keeps.
struct SwarmPainter {
    swarms: Swarms,
    pipeline: wgpu::RenderPipeline,
    bindings: BindGroupLayout,
    /// For each swarm of the frame: the last tick, its look, and both bound.
    uniforms: Vec<(wgpu::Buffer, wgpu::Buffer, wgpu::BindGroup)>,
}

impl SwarmPainter {
    fn new(gpu: &Gpu, canvas: &Canvas<'_>) -> Self {
        let uniform = |binding| uniform(binding, ShaderStages::VERTEX);
        let bindings = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("swarm look"),
            entries: &[uniform(0), uniform(1)],
        });
        let pipeline = canvas.sprites(gpu, &[TICK, DRAW], "vs_swarm", &ROWS, &bindings);
        Self { swarms: Swarms::new(gpu), pipeline, bindings, uniforms: Vec::new() }
    }

    /// Advances the device to the last tick of each of `swarms`, and sets the uniforms to their looks.
    fn follow(&mut self, gpu: &Gpu, swarms: &[DrawnSwarm]) {
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
            gpu.queue.write_buffer(look, 0, bytes_of(&swarm.look));
        }
    }

    fn uniforms(&self, gpu: &Gpu) -> (wgpu::Buffer, wgpu::Buffer, wgpu::BindGroup) {
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let buffer = |size: usize| buffer(gpu, "swarm look", usage, size as u64);
        let (tick, look) = (buffer(size_of::<Parameters>()), buffer(size_of::<SwarmLook>()));
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

    fn draw(&self, pass: &mut RenderPass<'_>) {
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
