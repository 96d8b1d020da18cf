//! Draws a frame: shadow map, bodies and surfaces, sky, edges of surfaces, outlines, edges of balls and boxes, particles, sprites, translucent bodies, lines,
//! panels.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use egui::ecolor::linear_f32_from_gamma_u8;
use glam::{Mat4, Vec3, Vec4};

use crate::{
    Canvas, Frame, Gpu, Instance, Kept, Layer, Quality,
    buffers::{Bodies, InstanceBuffer},
    mesh::Mesh,
    panels::PanelPainter,
    pipelines::{BodyPipelines, DEPTH_FORMAT, Destination, EDGE_VERTICES, Pipelines, uniform},
    shadow::{Caster, LightView, ShadowMap},
    surfaces::Surfaces,
    translucent::TranslucentBodies,
};

/// Mirrors `Globals` in shaders/globals.wgsl, where the fields are explained.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Globals {
    view_projection: Mat4,
    light_projection: Mat4,
    camera_right: Vec4,
    camera_up: Vec4,
    camera_forward: Vec4,
    viewport: Vec4,
    light_position: Vec4,
    light_color: Vec4,
    shadow_map: Vec4,
    picture: Vec4,
    ground: Vec4,
}

/// Value of `Globals::picture.w` for soft light and matte bodies.
const SOFT: f32 = 1.0;
/// Value of `Globals::picture.w` for soft light on paper.
const FOR_PAPER: f32 = 2.0;

/// Up to this many spheres are drawn with all their triangles, however small they are.
const CROWD: usize = 100;

/// The textures that have the size of the picture.
struct Attachments {
    size_px: [u32; 2],
    depth: wgpu::TextureView,
    /// Only with more than one sample; resolved into the view that is drawn to.
    color: Option<wgpu::TextureView>,
}

/// Draws frames into views of one format.
pub struct Renderer {
    quality: Quality,
    destination: Destination,
    pipelines: Pipelines,
    globals: wgpu::Buffer,
    globals_layout: wgpu::BindGroupLayout,
    globals_group: wgpu::BindGroup,
    shadow_map: ShadowMap,
    cube: Mesh,
    sphere: Mesh,
    /// For the small spheres of a frame with many.
    small_sphere: Mesh,
    /// Whether the spheres of the frame are ray-cast, and not meshes.
    is_round: bool,
    cuboids: Bodies,
    spheres: Bodies,
    small_spheres: Bodies,
    /// Created with the first frame that has any.
    surfaces: Option<Surfaces>,
    /// Created with the first frame that has any.
    translucent: Option<TranslucentBodies>,
    /// What the layer of the last frame keeps.
    kept: Kept,
    particles: InstanceBuffer,
    sprites: InstanceBuffer,
    lines: InstanceBuffer,
    panels: PanelPainter,
    attachments: Option<Attachments>,
}

impl Renderer {
    /// A renderer for views of `target_format`: [`crate::OFFSCREEN_FORMAT`] or [`crate::WindowTarget::format`].
    pub fn new(gpu: &Gpu, target_format: wgpu::TextureFormat, quality: Quality) -> Self {
        let device = &gpu.device;
        let supported = |format| {
            gpu.adapter
                .get_texture_format_features(format)
                .flags
                .sample_count_supported(quality.msaa)
        };
        let samples =
            if supported(target_format) && supported(DEPTH_FORMAT) { quality.msaa } else { 1 };
        let destination = Destination { format: target_format, samples };

        let globals = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("globals"),
            size: size_of::<Globals>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let globals_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("globals"),
            entries: &[uniform(0, wgpu::ShaderStages::VERTEX_FRAGMENT)],
        });
        let globals_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("globals"),
            layout: &globals_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: globals.as_entire_binding() }],
        });
        let shadow_map = ShadowMap::none(device);
        let shadow_map_px = quality.shadow_map_px.clamp(1, ShadowMap::largest(device));
        let panels = PanelPainter::new(device, &globals_layout, &destination);
        Self {
            quality: Quality { shadow_map_px, msaa: samples, ..quality },
            pipelines: Pipelines::new(device, &globals_layout, &shadow_map.layout, &destination),
            destination,
            globals,
            globals_layout,
            globals_group,
            shadow_map,
            cube: Mesh::cube(device),
            sphere: Mesh::sphere(device, quality.sphere_meridians),
            small_sphere: Mesh::sphere(device, quality.small_sphere_meridians()),
            is_round: false,
            cuboids: Bodies::new(device, "cuboids"),
            spheres: Bodies::new(device, "spheres"),
            small_spheres: Bodies::new(device, "small spheres"),
            surfaces: None,
            translucent: None,
            kept: None,
            particles: InstanceBuffer::new(device, "particles"),
            sprites: InstanceBuffer::new(device, "sprites"),
            lines: InstanceBuffer::new(device, "lines"),
            panels,
            attachments: None,
        }
    }

    /// Takes over what was sent only once to a renderer whose device is lost.
    pub fn replace(&mut self, gpu: &Gpu, lost: Self) {
        self.panels.take_images(gpu, lost.panels);
    }

    /// The quality in use: the requested one, limited to what the adapter supports.
    pub fn quality(&self) -> Quality {
        self.quality
    }

    /// Prepares `layer` as a frame with it does, and returns what it keeps.
    pub fn prepare(&mut self, gpu: &Gpu, layer: &dyn Layer) -> &Kept {
        let canvas = Canvas {
            globals: &self.globals_layout,
            shadow_map: &self.shadow_map.layout,
            destination: &self.destination,
        };
        layer.prepare(gpu, &canvas, &mut self.kept);
        &self.kept
    }

    /// Draws `frame` into `view`, which must have the frame's size and the format given to [`Renderer::new`], and
    /// submits the work without waiting for it. A frame without area draws nothing, but still takes in the panels'
    /// textures.
    pub fn draw(&mut self, gpu: &Gpu, frame: &Frame, view: &wgpu::TextureView) {
        if let Some(panels) = &frame.panels {
            self.panels.update_textures(gpu, panels);
        }
        if frame.size_px[0] > 0 && frame.size_px[1] > 0 {
            self.draw_visible(gpu, frame, view);
        }
        if let Some(panels) = &frame.panels {
            self.panels.free_textures(panels);
        }
    }

    fn draw_visible(&mut self, gpu: &Gpu, frame: &Frame, view: &wgpu::TextureView) {
        let light_view =
            frame.light.as_ref().and_then(|light| LightView::new(light, Caster::all(frame)));
        if light_view.is_some() && self.shadow_map.side_px < self.quality.shadow_map_px {
            // Memory for the map is allocated with the first shadow.
            self.shadow_map = self.shadow_map.enlarged(&gpu.device, self.quality.shadow_map_px);
        }
        let globals = self.globals_of(frame, light_view);
        gpu.queue.write_buffer(&self.globals, 0, bytemuck::bytes_of(&globals));
        let (forward, px_per_m) = (globals.camera_forward.truncate(), 1.0 / globals.viewport.z);
        // The tutorial's own look has the tutorial's meshes.
        self.is_round = frame.soft || frame.paper;
        let is_crowd = !self.is_round && frame.spheres.len() > CROWD;
        let small_px = if is_crowd { self.quality.small_sphere_px() } else { 0.0 };
        let is_small = |ball: &&Instance| {
            let radius_px = Vec3::from(ball.half_extents).max_element() * px_per_m;
            radius_px < small_px * Vec3::from(ball.position).dot(forward).abs()
        };
        self.cuboids.upload(gpu, &frame.cuboids);
        self.spheres.upload(gpu, frame.spheres.iter().filter(|ball| !is_small(ball)));
        self.small_spheres.upload(gpu, frame.spheres.iter().filter(is_small));
        let (globals_layout, shadow_layout) = (&self.globals_layout, &self.shadow_map.layout);
        let to = &self.destination;
        let soft_edges = self.is_round && to.samples == 1;
        if self.surfaces.is_some() || !frame.surfaces.is_empty() {
            let new = || Surfaces::new(&gpu.device, globals_layout, shadow_layout, to);
            self.surfaces.get_or_insert_with(new).upload(gpu, &frame.surfaces, soft_edges);
        }
        if self.translucent.is_some() || !frame.translucent.is_empty() {
            let new = || TranslucentBodies::new(&gpu.device, globals_layout, shadow_layout, to);
            self.translucent.get_or_insert_with(new).upload(gpu, &frame.translucent);
        }
        match &frame.layer {
            Some(layer) => {
                self.prepare(gpu, &**layer);
            }
            None => self.kept = None,
        }
        let particles = self.particles.upload(gpu, &frame.particles);
        let sprites = self.sprites.upload(gpu, &frame.sprites);
        let lines = self.lines.upload(gpu, &frame.lines);

        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        if light_view.is_some() {
            self.draw_shadows(&mut encoder);
        }
        self.draw_picture(gpu, &mut encoder, frame, view, [particles, sprites, lines]);
        self.panels.paint(gpu, &mut encoder, view, &self.globals_group, frame);
        gpu.queue.submit([encoder.finish()]);
    }

    fn globals_of(&self, frame: &Frame, light_view: Option<LightView>) -> Globals {
        let camera = &frame.camera;
        let [_, _, width, height] = frame.view_px().map(|side| side as f32);
        let half_up = (0.5 * camera.fov_y_rad).tan();
        let (light_position, light_color) = match &frame.light {
            Some(light) => {
                let casts = if light_view.is_some() { 1.0 } else { 0.0 };
                (light.position.extend(casts), light.color.extend(1.0))
            }
            None => (Vec4::ZERO, Vec4::ZERO),
        };
        let (light_projection, span_m) =
            light_view.map_or((Mat4::IDENTITY, 0.0), |view| (view.projection, view.span_m));
        let texels = self.shadow_map.side_px as f32;
        let (picture, scale) = (frame.size_px.map(|side| side as f32), frame.pixels_per_point());
        Globals {
            view_projection: camera.view_projection(width / height),
            light_projection,
            camera_right: (camera.orientation * Vec3::X).extend(half_up * width / height),
            camera_up: (camera.orientation * Vec3::Y).extend(half_up),
            camera_forward: (camera.orientation * Vec3::NEG_Z).extend(camera.near_m),
            viewport: Vec4::new(
                width,
                height,
                2.0 * half_up / height,
                camera.near_m * camera.far_m / (camera.near_m - camera.far_m),
            ),
            light_position,
            light_color,
            shadow_map: Vec4::new(1.0 / texels, span_m / texels, 0.0, 0.0),
            picture: Vec4::new(
                picture[0] / scale,
                picture[1] / scale,
                f32::from(u8::from(frame.space)),
                match (frame.paper, frame.soft) {
                    (true, _) => FOR_PAPER,
                    (false, true) => SOFT,
                    (false, false) => 0.0,
                },
            ),
            ground: frame.ground.map_or(Vec4::ZERO, |ground| {
                let [x, z] = ground.offset_m;
                Vec4::new(ground.height_m, ground.spacing_m, x, z)
            }),
        }
    }

    fn draw_shadows(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadows"),
            depth_stencil_attachment: Some(cleared_depth(
                &self.shadow_map.view,
                wgpu::StoreOp::Store,
            )),
            ..Default::default()
        });
        pass.set_bind_group(0, &self.globals_group, &[]);
        let all = |bodies: &Bodies| 0..bodies.total;
        self.draw_meshes(&mut pass, &self.pipelines.meshes.shadow, all);
        self.draw_balls(&mut pass, &self.pipelines.balls.shadow, all);
        if let Some(surfaces) = &self.surfaces {
            surfaces.draw_shadows(&mut pass);
        }
    }

    fn draw_picture(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        view: &wgpu::TextureView,
        [particles, sprites, lines]: [u32; 3],
    ) {
        let size_px = frame.size_px;
        let stored = |part: u8| match self.destination.format.is_srgb() {
            true => f64::from(linear_f32_from_gamma_u8(part)),
            false => f64::from(part) / 255.0,
        };
        let [r, g, b] = frame.surround.map(stored);
        let surround = wgpu::Color { r, g, b, a: 1.0 };
        self.attachments.take_if(|kept| kept.size_px != size_px);
        let attachments = self
            .attachments
            .get_or_insert_with(|| Attachments::new(&gpu.device, &self.destination, size_px));
        let depth = attachments.depth.clone();
        let multisampled = attachments.color.clone();
        let (target, resolve_target, store) = match &multisampled {
            Some(color) => (color, Some(view), wgpu::StoreOp::Discard),
            None => (view, None, wgpu::StoreOp::Store),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target,
                // Visible only around the view: inside, the sky covers every pixel that nothing else does.
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(surround), store },
            })],
            depth_stencil_attachment: Some(cleared_depth(&depth, wgpu::StoreOp::Discard)),
            ..Default::default()
        });
        let [left, top, width, height] = frame.view_px();
        pass.set_viewport(left as f32, top as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(left, top, width, height);
        pass.set_bind_group(0, &self.globals_group, &[]);
        pass.set_bind_group(1, &self.shadow_map.bind_group, &[]);

        let Pipelines { meshes, balls, .. } = &self.pipelines;
        let plain = |bodies: &Bodies| 0..bodies.plain;
        self.draw_meshes(&mut pass, &meshes.body, plain);
        self.draw_balls(&mut pass, &balls.body, plain);
        if let Some(surfaces) = &self.surfaces {
            surfaces.draw_plain(&mut pass);
        }
        let behind = match frame.ground {
            Some(_) => &[&self.pipelines.ground_plane, &self.pipelines.ground][..],
            None => &[&self.pipelines.sky],
        };
        for pipeline in behind {
            pass.set_pipeline(pipeline);
            pass.draw(0..3, 0..1);
        }
        if let Some(surfaces) = &self.surfaces {
            surfaces.draw_edges(&mut pass);
        }
        // The outlines write no depth, so they come after everything that they cover and before the bodies that they
        // surround.
        let outlined = |bodies: &Bodies| bodies.plain..bodies.total;
        let parts: [fn(&BodyPipelines) -> &wgpu::RenderPipeline; 3] =
            [|kind| &kind.rim, |kind| &kind.outline, |kind| &kind.body];
        for part in parts {
            self.draw_meshes(&mut pass, part(meshes), outlined);
            self.draw_balls(&mut pass, part(balls), outlined);
        }
        if let Some(surfaces) = &self.surfaces {
            surfaces.draw_outlined(&mut pass);
        }
        self.draw_balls(&mut pass, &self.pipelines.ball_edges, |bodies| 0..bodies.total);
        if self.is_round && self.destination.samples == 1 {
            let boxes = &self.cuboids;
            let edges = &self.pipelines.box_edges;
            boxes.instances.draw_vertices(&mut pass, edges, EDGE_VERTICES, plain(boxes));
        }
        self.particles.draw_quads(&mut pass, &self.pipelines.particle, 0..particles);
        self.sprites.draw_quads(&mut pass, &self.pipelines.sprite, 0..sprites);
        if let Some(layer) = &frame.layer {
            layer.draw(&self.kept, &mut pass);
        }
        if let Some(translucent) = &self.translucent {
            let sphere = (!self.is_round).then_some(&self.sphere);
            translucent.draw(&mut pass, &self.cube, sphere);
        }
        self.lines.draw_quads(&mut pass, &self.pipelines.line, 0..lines);
    }

    /// Draws bodies that are meshes. Boxes are last, because a floor is one, and other bodies hide much of it.
    fn draw_meshes(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        rows: impl Fn(&Bodies) -> Range<u32>,
    ) {
        pass.set_pipeline(pipeline);
        let meshes = [
            (&self.sphere, &self.spheres),
            (&self.small_sphere, &self.small_spheres),
            (&self.cube, &self.cuboids),
        ];
        for (mesh, bodies) in meshes.into_iter().skip(if self.is_round { 2 } else { 0 }) {
            mesh.draw(pass, bodies.instances.buffer(), rows(bodies));
        }
    }

    /// Draws spheres that are ray-cast.
    fn draw_balls(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        rows: impl Fn(&Bodies) -> Range<u32>,
    ) {
        if self.is_round {
            self.spheres.instances.draw_quads(pass, pipeline, rows(&self.spheres));
        }
    }
}

impl Attachments {
    fn new(device: &wgpu::Device, destination: &Destination, size_px: [u32; 2]) -> Self {
        let texture = |label, format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: size_px[0],
                    height: size_px[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: destination.samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        Self {
            size_px,
            depth: texture("depth", DEPTH_FORMAT),
            color: (destination.samples > 1).then(|| texture("samples", destination.format)),
        }
    }
}

fn cleared_depth(
    view: &wgpu::TextureView,
    store: wgpu::StoreOp,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store }),
        stencil_ops: None,
    }
}
