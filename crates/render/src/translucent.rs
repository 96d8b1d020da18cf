//! Draws translucent bodies: their pipelines, and the buffers that each frame refills.
//!
//! They write no depth and are drawn as if a little farther away, so that a solid body at the same position hides
//! them.

use wgpu::{
    BindGroupLayout, BlendState, CompareFunction, Device, Face, RenderPass, RenderPipeline,
};

use crate::mesh::Mesh;
use crate::pipelines::{
    BALL, BALL_ROWS, BODY, BODY_ROWS, Destination, Drawing, GLOBALS, LIGHT, PARTICLE,
    PARTICLE_ROWS, layout, module,
};
use crate::{Gpu, Instance, Particle, Translucent, buffers::InstanceBuffer};

pub(crate) struct TranslucentBodies {
    body: RenderPipeline,
    ball: RenderPipeline,
    particle: RenderPipeline,
    cuboids: Rows<Instance>,
    spheres: Rows<Instance>,
    particles: Rows<Particle>,
}

/// Rows that are drawn from the farthest to the nearest.
struct Rows<T> {
    buffer: InstanceBuffer,
    sorted: Vec<T>,
    count: u32,
}

impl<T: bytemuck::Pod> Rows<T> {
    fn new(device: &Device, label: &'static str) -> Self {
        Self { buffer: InstanceBuffer::new(device, label), sorted: Vec::new(), count: 0 }
    }

    fn upload(&mut self, gpu: &Gpu, rows: &[T], position: impl Fn(&T) -> [f32; 3]) {
        self.sorted.clear();
        self.sorted.extend_from_slice(rows);
        let distance = |row: &T| position(row).map(|part| part * part).iter().sum::<f32>();
        self.sorted.sort_by(|a, b| distance(b).total_cmp(&distance(a)));
        self.count = self.buffer.upload(gpu, &self.sorted);
    }
}

impl TranslucentBodies {
    pub fn new(
        device: &Device,
        globals: &BindGroupLayout,
        shadow_map: &BindGroupLayout,
        to: &Destination,
    ) -> Self {
        let bodies = module(device, "translucent body", &[GLOBALS, LIGHT, BODY, BALL]);
        let particles = module(device, "translucent particle", &[GLOBALS, LIGHT, PARTICLE]);
        let picture = layout(device, "picture", &[Some(globals), Some(shadow_map)]);
        let body = Drawing {
            label: "translucent body",
            shader: &bodies,
            vertex: "vs_translucent",
            fragment: Some("fs_translucent"),
            has_color: true,
            rows: &BODY_ROWS,
            constants: &[to.srgb()],
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull: Some(Face::Back),
            // Bodies behind must stay visible, whatever is drawn first.
            writes_depth: false,
            depth_compare: Some(CompareFunction::Less),
            depth_bias: wgpu::DepthBiasState::default(),
            blend: Some(BlendState::ALPHA_BLENDING),
        };
        let quads =
            Drawing { topology: wgpu::PrimitiveTopology::TriangleStrip, cull: None, ..body };
        let ball = Drawing {
            label: "translucent ball",
            vertex: "vs_translucent_ball",
            fragment: Some("fs_translucent_ball"),
            rows: &BALL_ROWS,
            ..quads
        };
        let particle = Drawing {
            label: "translucent particle",
            shader: &particles,
            vertex: "vs_particle",
            fragment: Some("fs_particle"),
            rows: &PARTICLE_ROWS,
            ..quads
        };
        Self {
            ball: ball.pipeline(device, &picture, to),
            particle: particle.pipeline(device, &picture, to),
            body: body.pipeline(device, &picture, to),
            cuboids: Rows::new(device, "translucent cuboids"),
            spheres: Rows::new(device, "translucent spheres"),
            particles: Rows::new(device, "translucent particles"),
        }
    }

    pub fn upload(&mut self, gpu: &Gpu, rows: &Translucent) {
        self.cuboids.upload(gpu, &rows.cuboids, |row| row.position);
        self.spheres.upload(gpu, &rows.spheres, |row| row.position);
        self.particles.upload(gpu, &rows.particles, |row| row.position);
    }

    /// Draws the bodies, spheres as `sphere` if opaque ones are that mesh. Call it after everything opaque.
    pub fn draw(&self, pass: &mut RenderPass<'_>, cube: &Mesh, sphere: Option<&Mesh>) {
        pass.set_pipeline(&self.body);
        cube.draw(pass, self.cuboids.buffer.buffer(), 0..self.cuboids.count);
        let balls = 0..self.spheres.count;
        match sphere {
            Some(mesh) => mesh.draw(pass, self.spheres.buffer.buffer(), balls),
            None => self.spheres.buffer.draw_quads(pass, &self.ball, balls),
        }
        self.particles.buffer.draw_quads(pass, &self.particle, 0..self.particles.count);
    }
}
