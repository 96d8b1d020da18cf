//! One pipeline for each thing that is drawn.

use wgpu::{BindGroupLayout, CompareFunction, Device, Face, TextureFormat, VertexBufferLayout};

use crate::{Instance, Line, Particle, Sprite, mesh::Vertex, shadow::SHADOW_FORMAT};

pub(crate) const GLOBALS: &str = include_str!("../shaders/globals.wgsl");
pub(crate) const LIGHT: &str = include_str!("../shaders/light.wgsl");
pub(crate) const BODY: &str = include_str!("../shaders/body.wgsl");
pub(crate) const BALL: &str = include_str!("../shaders/ball.wgsl");
const EDGE: &str = include_str!("../shaders/edge.wgsl");
const SKY: &str = include_str!("../shaders/sky.wgsl");
const GROUND: &str = include_str!("../shaders/ground.wgsl");
pub(crate) const PARTICLE: &str = include_str!("../shaders/particle.wgsl");
pub(crate) const SPRITE: &str = include_str!("../shaders/sprite.wgsl");
const LINE: &str = include_str!("../shaders/line.wgsl");

/// Width of the bright outline, pixels.
pub(crate) const OUTLINE_PX: f64 = 2.5;
/// Width of the bright outline and its dark rim together, pixels: the rim keeps it visible before a bright sky.
pub(crate) const RIM_PX: f64 = 4.0;

pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

const INSTANCES: VertexBufferLayout<'_> = VertexBufferLayout {
    array_stride: size_of::<Instance>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    // Written out because the macro cannot skip the padding after the half extents.
    attributes: &[
        attribute(3, wgpu::VertexFormat::Float32x3, 0),
        attribute(4, wgpu::VertexFormat::Uint32, 12),
        attribute(5, wgpu::VertexFormat::Float32x3, 16),
        attribute(6, wgpu::VertexFormat::Float32x4, 32),
        attribute(7, wgpu::VertexFormat::Float32x4, 48),
    ],
};

pub(crate) const BODY_ROWS: [Option<VertexBufferLayout<'_>>; 2] = [
    Some(VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2],
    }),
    Some(INSTANCES),
];

pub(crate) const BALL_ROWS: [Option<VertexBufferLayout<'_>>; 1] = [Some(INSTANCES)];

pub(crate) const PARTICLE_ROWS: [Option<VertexBufferLayout<'_>>; 1] = [Some(VertexBufferLayout {
    array_stride: size_of::<Particle>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x4],
})];

const SPRITE_ROWS: [Option<VertexBufferLayout<'_>>; 1] = [Some(VertexBufferLayout {
    array_stride: size_of::<Sprite>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &[
        attribute(0, wgpu::VertexFormat::Float32x3, 0),
        attribute(1, wgpu::VertexFormat::Float32, 12),
        attribute(2, wgpu::VertexFormat::Float32x3, 16),
        attribute(3, wgpu::VertexFormat::Float32x4, 32),
    ],
})];

const LINE_ROWS: [Option<VertexBufferLayout<'_>>; 1] = [Some(VertexBufferLayout {
    array_stride: size_of::<Line>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Float32, 4 => Float32x4, 5 => Float32x4
    ],
})];

const fn attribute(
    location: u32,
    format: wgpu::VertexFormat,
    offset: u64,
) -> wgpu::VertexAttribute {
    wgpu::VertexAttribute { format, offset, shader_location: location }
}

/// The pipelines of one kind of body.
pub(crate) struct BodyPipelines {
    pub shadow: wgpu::RenderPipeline,
    pub body: wgpu::RenderPipeline,
    /// The dark rim, drawn before [`Self::outline`].
    pub rim: wgpu::RenderPipeline,
    pub outline: wgpu::RenderPipeline,
}

pub(crate) struct Pipelines {
    /// Bodies that are meshes.
    pub meshes: BodyPipelines,
    /// Balls that are ray-cast, each within a quad.
    pub balls: BodyPipelines,
    /// Their edges, drawn after everything that is seen through them.
    pub ball_edges: wgpu::RenderPipeline,
    /// The edges of boxes, [`EDGE_VERTICES`] per box.
    pub box_edges: wgpu::RenderPipeline,
    pub sky: wgpu::RenderPipeline,
    /// Drawn in place of the sky if there is a ground.
    pub ground: wgpu::RenderPipeline,
    /// The ground itself, which hides what is below it.
    pub ground_plane: wgpu::RenderPipeline,
    pub particle: wgpu::RenderPipeline,
    pub sprite: wgpu::RenderPipeline,
    pub line: wgpu::RenderPipeline,
}

/// Vertices of the edges of a box.
pub(crate) const EDGE_VERTICES: u32 = 72;

/// The format and sample count that the pipelines draw to.
pub(crate) struct Destination {
    pub format: TextureFormat,
    pub samples: u32,
}

impl Destination {
    /// The constant that `stored` of shaders/globals.wgsl needs: whether the target is an sRGB format.
    pub fn srgb(&self) -> (&'static str, f64) {
        ("target_is_srgb", f64::from(u8::from(self.format.is_srgb())))
    }
}

/// The options in which pipelines differ.
#[derive(Clone, Copy)]
pub(crate) struct Drawing<'a> {
    pub label: &'a str,
    pub shader: &'a wgpu::ShaderModule,
    pub vertex: &'a str,
    pub fragment: Option<&'a str>,
    /// Whether fragments have a color; otherwise depth alone is drawn.
    pub has_color: bool,
    pub rows: &'a [Option<VertexBufferLayout<'a>>],
    pub constants: &'a [(&'a str, f64)],
    pub topology: wgpu::PrimitiveTopology,
    pub cull: Option<Face>,
    pub writes_depth: bool,
    /// `None` for passes without depth.
    pub depth_compare: Option<CompareFunction>,
    pub depth_bias: wgpu::DepthBiasState,
    pub blend: Option<wgpu::BlendState>,
}

/// A shader made of the texts of its parts.
pub fn module(device: &Device, label: &str, parts: &[&str]) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(parts.concat().into()),
    })
}

/// The layout of the bind groups of a pipeline.
pub fn layout(
    device: &Device,
    label: &str,
    groups: &[Option<&BindGroupLayout>],
) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: groups,
        immediate_size: 0,
    })
}

/// A pipeline that draws a sprite per instance, as four vertices of a strip. `shader` follows shaders/globals.wgsl and
/// shaders/sprite.wgsl, and `vertex` is its entry.
pub(crate) fn sprites(
    device: &Device,
    groups: &[Option<&BindGroupLayout>],
    to: &Destination,
    shader: &[&str],
    vertex: &str,
    rows: &[Option<VertexBufferLayout<'_>>],
) -> wgpu::RenderPipeline {
    let drawing = Drawing {
        label: vertex,
        shader: &module(device, vertex, &[&[GLOBALS, SPRITE], shader].concat()),
        vertex,
        fragment: Some("fs_sprite"),
        has_color: true,
        rows,
        constants: &[to.srgb()],
        topology: wgpu::PrimitiveTopology::TriangleStrip,
        cull: None,
        // A soft edge must not hide what is behind it.
        writes_depth: false,
        depth_compare: Some(CompareFunction::LessEqual),
        depth_bias: wgpu::DepthBiasState::default(),
        blend: Some(wgpu::BlendState::ALPHA_BLENDING),
    };
    drawing.pipeline(device, &layout(device, vertex, groups), to)
}

/// The entry of a uniform buffer in the layout of a bind group.
pub const fn uniform(binding: u32, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

impl Pipelines {
    pub fn new(
        device: &Device,
        globals: &BindGroupLayout,
        shadow_map: &BindGroupLayout,
        to: &Destination,
    ) -> Self {
        let module = |label, parts: &[&str]| module(device, label, parts);
        let body = module("body", &[GLOBALS, LIGHT, BODY]);
        let ball = module("ball", &[GLOBALS, LIGHT, BODY, BALL]);
        let edge = module("edge", &[GLOBALS, LIGHT, BODY, EDGE]);
        let sky = module("sky", &[GLOBALS, SKY]);
        let ground = module("ground", &[GLOBALS, LIGHT, SKY, GROUND]);
        let particle = module("particle", &[GLOBALS, LIGHT, PARTICLE]);
        let line = module("line", &[GLOBALS, LINE]);
        let picture = layout(device, "picture", &[Some(globals), Some(shadow_map)]);
        // The map cannot be read while it is drawn into.
        let from_light = layout(device, "from light", &[Some(globals)]);

        let srgb = to.srgb();
        let bodies = Drawing {
            label: "body",
            shader: &body,
            vertex: "vs_surface",
            fragment: Some("fs_surface"),
            has_color: true,
            rows: &BODY_ROWS,
            constants: &[srgb],
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull: Some(Face::Back),
            writes_depth: true,
            depth_compare: Some(CompareFunction::Less),
            depth_bias: wgpu::DepthBiasState::default(),
            blend: None,
        };
        let to_map = Destination { format: to.format, samples: 1 };
        let kind = |body: Drawing<'_>, shadow: Drawing<'_>, outline: Drawing<'_>| {
            let outline = |label, width_px, bright| {
                Drawing {
                    label,
                    constants: &[srgb, ("outline_px", width_px), ("outline_bright", bright)],
                    writes_depth: false,
                    ..outline
                }
                .pipeline(device, &picture, to)
            };
            BodyPipelines {
                shadow: Drawing { label: "shadow", has_color: false, constants: &[], ..shadow }
                    .pipeline(device, &from_light, &to_map),
                rim: outline("rim", RIM_PX, 0.0),
                outline: outline("outline", OUTLINE_PX, 1.0),
                body: body.pipeline(device, &picture, to),
            }
        };
        let balls = Drawing {
            label: "ball",
            shader: &ball,
            vertex: "vs_ball",
            fragment: Some("fs_ball"),
            rows: &BALL_ROWS,
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            cull: None,
            ..bodies
        };
        let overlay = Drawing {
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            cull: None,
            depth_compare: Some(CompareFunction::LessEqual),
            blend: Some(wgpu::BlendState::ALPHA_BLENDING),
            ..bodies
        };
        let behind = Drawing {
            label: "sky",
            shader: &sky,
            vertex: "vs_sky",
            fragment: Some("fs_sky"),
            rows: &[],
            cull: None,
            writes_depth: false,
            // The sky is exactly on the far plane, which the depth is cleared to.
            depth_compare: Some(CompareFunction::LessEqual),
            ..bodies
        };
        Self {
            meshes: kind(
                bodies,
                // The map has the back faces, so that a surface seen by the light is not compared with itself.
                Drawing { vertex: "vs_shadow", fragment: None, cull: Some(Face::Front), ..bodies },
                Drawing {
                    vertex: "vs_outline",
                    fragment: Some("fs_outline"),
                    cull: Some(Face::Front),
                    ..bodies
                },
            ),
            balls: kind(
                balls,
                Drawing { vertex: "vs_ball_shadow", fragment: Some("fs_ball_shadow"), ..balls },
                Drawing {
                    vertex: "vs_ball_outline",
                    fragment: Some("fs_ball_outline"),
                    blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                    ..balls
                },
            ),
            ball_edges: Drawing {
                label: "ball edges",
                constants: &[srgb, ("edges", 1.0)],
                writes_depth: false,
                blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                ..balls
            }
            .pipeline(device, &picture, to),
            box_edges: Drawing {
                label: "box edges",
                shader: &edge,
                vertex: "vs_edge",
                fragment: Some("fs_edge"),
                rows: &BALL_ROWS,
                topology: wgpu::PrimitiveTopology::TriangleList,
                writes_depth: false,
                ..overlay
            }
            .pipeline(device, &picture, to),
            ground: Drawing {
                label: "ground",
                shader: &ground,
                fragment: Some("fs_ground"),
                ..behind
            }
            .pipeline(device, &picture, to),
            ground_plane: Drawing {
                label: "ground plane",
                shader: &ground,
                vertex: "vs_plain",
                fragment: Some("fs_ground"),
                writes_depth: true,
                depth_compare: Some(CompareFunction::Less),
                ..behind
            }
            .pipeline(device, &picture, to),
            sky: behind.pipeline(device, &picture, to),
            particle: Drawing {
                label: "particle",
                shader: &particle,
                vertex: "vs_particle",
                fragment: Some("fs_particle"),
                rows: &PARTICLE_ROWS,
                ..overlay
            }
            .pipeline(device, &picture, to),
            sprite: sprites(
                device,
                &[Some(globals), Some(shadow_map)],
                to,
                &[],
                "vs_sprite",
                &SPRITE_ROWS,
            ),
            line: Drawing {
                label: "line",
                shader: &line,
                vertex: "vs_line",
                fragment: Some("fs_line"),
                rows: &LINE_ROWS,
                ..overlay
            }
            .pipeline(device, &picture, to),
        }
    }
}

impl Drawing<'_> {
    pub fn pipeline(
        &self,
        device: &Device,
        layout: &wgpu::PipelineLayout,
        to: &Destination,
    ) -> wgpu::RenderPipeline {
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants: self.constants, ..Default::default() };
        let color = [Some(wgpu::ColorTargetState {
            format: to.format,
            blend: self.blend,
            write_mask: wgpu::ColorWrites::ALL,
        })];
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module: self.shader,
                entry_point: Some(self.vertex),
                compilation_options: compilation_options.clone(),
                buffers: self.rows,
            },
            primitive: wgpu::PrimitiveState {
                topology: self.topology,
                cull_mode: self.cull,
                ..Default::default()
            },
            depth_stencil: self.depth_compare.map(|compare| wgpu::DepthStencilState {
                format: if self.has_color { DEPTH_FORMAT } else { SHADOW_FORMAT },
                depth_write_enabled: Some(self.writes_depth),
                depth_compare: Some(compare),
                stencil: wgpu::StencilState::default(),
                bias: self.depth_bias,
            }),
            multisample: wgpu::MultisampleState { count: to.samples, ..Default::default() },
            fragment: self.fragment.map(|entry_point| wgpu::FragmentState {
                module: self.shader,
                entry_point: Some(entry_point),
                compilation_options,
                targets: if self.has_color { &color } else { &[] },
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
