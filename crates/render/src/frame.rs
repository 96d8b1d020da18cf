//! The plain data of one picture, every position relative to the camera.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Quat, Vec3};

use crate::{Layer, Line, Surface};

/// Bit of [`Instance::surface`]: the 4 by 4 checkerboard of the tutorial, once on each cube face or around a sphere.
pub const CHECKER: u32 = 1;
/// Bit of [`Instance::surface`]: a bright outline with a dark rim, of constant width on the screen.
pub const OUTLINED: u32 = 2;
/// Bit of [`Instance::surface`]: a ball that shines, whatever light there is. Only with [`Frame::soft`] light.
pub const SHINES: u32 = 4;

/// Everything that one picture shows. The camera is the origin: positions are in meters relative to it, in the axes
/// of the world (+Y up), so that a scene far from the world's origin draws as sharply as one at the origin.
#[derive(Clone, Default)]
pub struct Frame {
    /// Width and height in pixels; if one is zero, nothing is drawn. Must be the size of the view that is drawn into.
    pub size_px: [u32; 2],
    /// The part of the picture that shows the scene: left, top, width and height in pixels, inside the picture;
    /// `None` for the whole picture.
    pub view_px: Option<[u32; 4]>,
    /// Color outside of that part: red, green and blue, as displayed.
    pub surround: [u8; 3],
    /// Direction and angle of view of the camera.
    pub camera: Camera,
    /// Whether the scene has no up direction: the sky then has no horizon.
    pub space: bool,
    /// Whether light is soft, bodies are matte, balls are round and the ground is light; otherwise they look as in the tutorial.
    pub soft: bool,
    /// Whether the picture is for paper: no sky, a white ground, and light that is soft.
    pub paper: bool,
    /// A plain that hides what is below it, but for lines and translucent bodies.
    pub ground: Option<Ground>,
    /// The only lamp; without it everything is lit softly from the camera.
    pub light: Option<Light>,
    /// Boxes, in any order.
    pub cuboids: Vec<Instance>,
    /// Balls, in any order.
    pub spheres: Vec<Instance>,
    /// Meshes that are new in every frame, in any order.
    pub surfaces: Vec<Surface>,
    /// Small discs; they receive shadows and cast none.
    pub particles: Vec<Particle>,
    /// Spots for things too small and fast to have a shape, such as drops and sparks. Drawn in this order over bodies
    /// and particles.
    pub sprites: Vec<Sprite>,
    /// What another crate draws over the sprites.
    pub layer: Option<Arc<dyn Layer>>,
    /// Bodies that others are seen through.
    pub translucent: Translucent,
    /// Lines and arrows, hidden by bodies in front of them; see [`Line::arrow`].
    pub lines: Vec<Line>,
    /// The user interface, painted last.
    pub panels: Option<Panels>,
}

impl Frame {
    /// Pixels per point of the panels.
    pub(crate) fn pixels_per_point(&self) -> f32 {
        self.panels
            .as_ref()
            .map(|panels| panels.pixels_per_point)
            .filter(|scale| *scale > 0.0)
            .unwrap_or(1.0)
    }

    /// Left, top, width and height of the part that shows the scene, pixels; each side at least 1.
    pub fn view_px(&self) -> [u32; 4] {
        let [width, height] = self.size_px;
        let [left, top, wide, high] = self.view_px.unwrap_or([0, 0, width, height]);
        let (left, top) = (left.min(width.saturating_sub(1)), top.min(height.saturating_sub(1)));
        [left, top, wide.clamp(1, (width - left).max(1)), high.clamp(1, (height - top).max(1))]
    }
}

/// Bodies that let through what is behind them: hidden by opaque ones that are nearer or at the same place, lit
/// from the camera so that a color is the same everywhere, without shadows, checkers and outlines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Translucent {
    /// Boxes, in any order; the alpha of a color is that of a face seen straight on, and edges of balls are denser.
    pub cuboids: Vec<Instance>,
    /// Balls, in any order.
    pub spheres: Vec<Instance>,
    /// Small discs, in any order.
    pub particles: Vec<Particle>,
}

impl Translucent {
    /// Whether there is nothing to draw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.cuboids.is_empty() && self.spheres.is_empty() && self.particles.is_empty()
    }
}

/// Direction, angle and range of view; the camera is always at the origin of the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// From camera space (looking along -Z, +Y up, +X right) to the axes of the world.
    pub orientation: Quat,
    /// Vertical field of view, radians, between 0 and pi.
    pub fov_y_rad: f32,
    /// Nearest distance drawn, m, above 0.
    pub near_m: f32,
    /// Farthest distance drawn, m, above `near_m`.
    pub far_m: f32,
}

impl Default for Camera {
    /// The camera of the tutorial: 45 degrees, 0.1 m to 500 m, looking along -Z.
    fn default() -> Self {
        Self {
            orientation: Quat::IDENTITY,
            fov_y_rad: std::f32::consts::FRAC_PI_4,
            near_m: 0.1,
            far_m: 500.0,
        }
    }
}

impl Camera {
    /// From camera-relative meters to clip space with depth 0 (near) to 1 (far), right-handed; `aspect` is width
    /// over height.
    pub fn view_projection(&self, aspect: f32) -> Mat4 {
        let projection = glam::camera::rh::proj::directx::perspective(
            self.fov_y_rad,
            aspect.max(1e-6),
            self.near_m,
            self.far_m,
        );
        projection * Mat4::from_quat(self.orientation.conjugate())
    }
}

/// An endless plane with a grid of lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Height relative to the camera, m; below 0.
    pub height_m: f32,
    /// Distance between lines, along x and along z, m.
    pub spacing_m: f32,
    /// Distance from the last line to the camera, along x and z, m.
    pub offset_m: [f32; 2],
}

/// A point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Relative to the camera, m.
    pub position: Vec3,
    /// What the shadow map looks at, relative to the camera, m. The map covers 22.5 degrees to each side of it;
    /// whatever lies outside is lit.
    pub target: Vec3,
    /// Linear red, green and blue, usually 0 to 1.
    pub color: Vec3,
    /// Whether bodies cast shadows.
    pub shadows: bool,
}

/// One body: a box or, in [`Frame::spheres`], a ball. The layout is that of the vertex buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Instance {
    /// Center, relative to the camera, m.
    pub position: [f32; 3],
    /// Any of [`CHECKER`], [`OUTLINED`] and [`SHINES`].
    pub surface: u32,
    /// Half the size along each axis of the body, m; for a ball the radius, three times.
    pub half_extents: [f32; 3],
    #[doc(hidden)]
    pub _pad: u32,
    /// Unit quaternion x, y, z, w from the body's axes to those of the world.
    pub orientation: [f32; 4],
    /// Red, green, blue as displayed (not linear), 0 to 1, and an alpha that counts only in [`Translucent`].
    pub color: [f32; 4],
}

impl Default for Instance {
    /// White, plain, half a meter to each side, at the camera.
    fn default() -> Self {
        Self {
            position: [0.0; 3],
            surface: 0,
            half_extents: [0.5; 3],
            _pad: 0,
            orientation: [0.0, 0.0, 0.0, 1.0],
            color: [1.0; 4],
        }
    }
}

/// One small disc that always faces the camera. The layout is that of the vertex buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Particle {
    /// Center, relative to the camera, m.
    pub position: [f32; 3],
    /// Radius, m; never drawn smaller than three quarters of a pixel.
    pub radius_m: f32,
    /// Red, green, blue as displayed and alpha (1 opaque), 0 to 1.
    pub color: [f32; 4],
}

/// One soft spot without light and shadow that faces the camera. The layout is that of the vertex buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Sprite {
    /// Middle of its front, relative to the camera, m.
    pub position: [f32; 3],
    /// Radius, m; never drawn smaller than a pixel.
    pub radius_m: f32,
    /// Vector along which the spot is stretched, m; it ends at the position.
    pub streak: [f32; 3],
    #[doc(hidden)]
    pub _pad: f32,
    /// Red, green, blue as displayed and alpha (1 opaque), 0 to 1.
    pub color: [f32; 4],
}

/// A user interface already laid out and tessellated by egui.
#[derive(Clone, Default)]
pub struct Panels {
    /// From `Context::tessellate`.
    pub primitives: Vec<egui::ClippedPrimitive>,
    /// From `FullOutput::textures_delta`. Every delta must reach the renderer, in order: draw each frame that has
    /// panels, if need be with no area. Drawing a frame twice does no harm.
    pub textures_delta: egui::TexturesDelta,
    /// Pixels per logical point, above 0.
    pub pixels_per_point: f32,
}

impl Drop for Panels {
    /// Drawing borrows the frame and so cannot consume the deltas; egui panics when one is dropped unused.
    fn drop(&mut self) {
        self.textures_delta.clear();
    }
}
