//! The shadow map: depth as the light sees it.

use glam::{Mat4, Quat, Vec2, Vec3};

use crate::{Frame, Instance, Light, Surface};

/// Field of view of the map, radians. With the near and far shares below it is that of the tutorial's light at 289 m:
/// 45 degrees, 100 m to 500 m.
const FOV_RAD: f32 = std::f32::consts::FRAC_PI_4;
/// Nearest distance in the map, as a share of the distance from the light to its target.
const NEAR: f32 = 0.34;
/// Farthest distance in the map, as a share of the distance from the light to its target.
const FAR: f32 = 1.73;

/// A body whose shadow spans more than this share of the map's half width is scenery and does not widen the fit.
const SCENERY: f32 = 0.25;
/// Length over width from which on a body is fitted by its ends: a pole is no scenery.
const POLE: f32 = 4.0;
/// How often the fit may halve the map: at 289 m the last step covers 3.7 m with the whole map.
const MOST_HALVINGS: u32 = 6;
/// Room around the casters, as a share of the fitted half width, so that the fit can stay while they move.
const MARGIN: f32 = 0.125;

/// A ball around something that casts a shadow.
#[derive(Clone, Copy)]
pub(crate) struct Caster {
    center: Vec3,
    radius: f32,
}

impl Caster {
    /// The ends of a pole, or the ball around any other body.
    fn body(body: &Instance) -> impl Iterator<Item = Self> {
        let (center, half) = (Vec3::from(body.position), Vec3::from(body.half_extents));
        let axis = Vec3::AXES[half.max_position()];
        let across = half - axis * half;
        let width = across.max_element();
        let ends = (half.max_element() > POLE * width).then(|| {
            let along = Quat::from_array(body.orientation) * (half - across - axis * width);
            let radius = (across + axis * width).length();
            [center - along, center + along].map(|center| Self { center, radius })
        });
        let whole = ends.is_none().then_some(Self { center, radius: half.length() });
        ends.into_iter().flatten().chain(whole)
    }

    /// The points of a surface as casters. Unlike a body, a surface is never scenery, however wide, and is cropped to
    /// the map.
    fn points(surface: &Surface) -> impl Iterator<Item = Self> {
        surface
            .vertices
            .iter()
            .map(|vertex| Self { center: Vec3::from(vertex.position), radius: 0.0 })
    }

    /// All casters of shadows in `frame`.
    pub fn all(frame: &Frame) -> impl Iterator<Item = Self> {
        let bodies = frame.cuboids.iter().chain(&frame.spheres).flat_map(Self::body);
        bodies.chain(frame.surfaces.iter().flat_map(Self::points))
    }
}

/// The view from the light.
#[derive(Clone, Copy)]
pub(crate) struct LightView {
    /// From camera-relative meters to the clip space of the shadow map.
    pub projection: Mat4,
    /// Width of the map at 1 m from the light, m.
    pub span_m: f32,
}

impl LightView {
    /// Fits the map to the casters that are small enough to move about. `None` if the light casts no shadows or
    /// nothing could be in the map. Only casters have to fit: a receiver lies on the ray of light through its caster,
    /// thus in the same texel.
    pub fn new(light: &Light, casters: impl Iterator<Item = Caster>) -> Option<Self> {
        let toward = light.target - light.position;
        let distance = toward.length();
        if !light.shadows || !distance.is_finite() || distance < 1e-3 {
            return None;
        }
        let direction = toward / distance;
        // A light straight above looks along the usual up direction, which then does not determine the roll.
        let up = if direction.y.abs() > 0.999 { Vec3::Z } else { Vec3::Y };
        let view = glam::camera::rh::view::look_to_mat4(light.position, direction, up);
        let projection = glam::camera::rh::proj::directx::perspective(
            FOV_RAD,
            1.0,
            NEAR * distance,
            FAR * distance,
        ) * view;
        let (center, half) = fitted(projection, casters);
        // Makes x and y, after division by w, equal to (xy - center) / half.
        let rows = projection.transpose();
        let cropped = Mat4::from_cols(
            (rows.x_axis - rows.w_axis * center.x) / half,
            (rows.y_axis - rows.w_axis * center.y) / half,
            rows.z_axis,
            rows.w_axis,
        );
        Some(Self { projection: cropped.transpose(), span_m: 2.0 * (0.5 * FOV_RAD).tan() * half })
    }
}

/// Center and half width of the part of the light's view, -1 to 1 each way, that contains the casters. Both change in
/// steps, otherwise the edges of shadows would crawl with every move of a body.
fn fitted(projection: Mat4, casters: impl Iterator<Item = Caster>) -> (Vec2, f32) {
    let spread = 1.0 / (0.5 * FOV_RAD).tan();
    let mut low = Vec2::ONE;
    let mut high = Vec2::NEG_ONE;
    for caster in casters {
        let clip = projection * caster.center.extend(1.0);
        let radius = caster.radius * spread / clip.w;
        let place = clip.truncate().truncate() / clip.w;
        // NaN fails the comparisons and is left out.
        if clip.w > 0.0 && radius < SCENERY && place.abs().max_element() < 1.0 + radius {
            low = low.min(place - radius);
            high = high.max(place + radius);
        }
    }
    let (low, high) = (low.max(Vec2::NEG_ONE), high.min(Vec2::ONE));
    if low.x > high.x {
        return (Vec2::ZERO, 1.0);
    }
    let needed = 0.5 * (high - low).max_element();
    let mut half = 1.0;
    for _ in 0..MOST_HALVINGS {
        if 0.5 * half * (1.0 - MARGIN) < needed {
            break;
        }
        half *= 0.5;
    }
    if half == 1.0 {
        return (Vec2::ZERO, 1.0);
    }
    let step = MARGIN * half;
    ((0.5 * (low + high) / step).round() * step, half)
}

/// The shadow map and its bindings in the shaders.
pub(crate) struct ShadowMap {
    pub side_px: u32,
    pub view: wgpu::TextureView,
    pub layout: wgpu::BindGroupLayout,
    pub bind_group: wgpu::BindGroup,
}

pub(crate) const SHADOW_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

impl ShadowMap {
    /// A map of one pixel, which pictures without shadows bind and do not read.
    pub fn none(device: &wgpu::Device) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("shadow map"),
            entries: &[
                entry(
                    0,
                    wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Depth,
                        view_dimension: wgpu::TextureViewDimension::D2,
                        multisampled: false,
                    },
                ),
                entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
            ],
        });
        Self::with_layout(device, 1, layout)
    }

    /// A map with the same layout and `side_px` pixels per side, at most [`ShadowMap::largest`].
    pub fn enlarged(&self, device: &wgpu::Device, side_px: u32) -> Self {
        Self::with_layout(device, side_px, self.layout.clone())
    }

    /// The most pixels per side.
    pub fn largest(device: &wgpu::Device) -> u32 {
        device.limits().max_texture_dimension_2d
    }

    fn with_layout(device: &wgpu::Device, side_px: u32, layout: wgpu::BindGroupLayout) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow map"),
            size: wgpu::Extent3d { width: side_px, height: side_px, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: SHADOW_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("shadow map"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(wgpu::CompareFunction::LessEqual),
            ..Default::default()
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadow map"),
            layout: &layout,
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
        Self { side_px, view, layout, bind_group }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should panic")]
mod tests {
    use super::*;

    fn ball(position: Vec3, radius: f32) -> Instance {
        Instance { position: position.to_array(), half_extents: [radius; 3], ..Instance::default() }
    }

    const TUTORIAL: Light = Light {
        position: Vec3::new(-200.0, 60.0, -200.0),
        target: Vec3::ZERO,
        color: Vec3::ONE,
        shadows: true,
    };

    fn view_of(bodies: &[Instance]) -> LightView {
        LightView::new(&TUTORIAL, bodies.iter().flat_map(Caster::body)).unwrap()
    }

    fn in_map(view: &LightView, point: Vec3) -> bool {
        let clip = view.projection * point.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        clip.w > 0.0 && ndc.truncate().abs().max_element() <= 1.0 && (0.0..=1.0).contains(&ndc.z)
    }

    #[test]
    fn every_caster_of_the_tutorials_view_stays_in_the_fitted_map() {
        for spread in [1.0_f32, 5.0, 14.0, 40.0, 70.0] {
            let casters: Vec<Instance> = (0..25_u8)
                .map(|i| {
                    ball(
                        Vec3::new(f32::from(i % 5) - 2.0, 0.5, f32::from(i / 5)) * spread * 0.25,
                        1.0,
                    )
                })
                .collect();
            let view = view_of(&casters);
            for caster in &casters {
                for offset in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
                    assert!(
                        in_map(&view, Vec3::from(caster.position) + offset),
                        "spread {spread} {offset}"
                    );
                }
            }
        }
    }

    #[test]
    fn scenery_and_broken_positions_leave_the_map_as_wide_as_the_tutorials() {
        let whole = 2.0 * (0.5 * FOV_RAD).tan();
        let floor = ball(Vec3::ZERO, 100.0);
        let broken = ball(Vec3::splat(f32::NAN), 1.0);
        let view = view_of(&[floor, broken]);
        assert!((view.span_m - whole).abs() < 1e-6);
        let view = view_of(&[floor, broken, ball(Vec3::ZERO, 1.0)]);
        assert!(view.span_m < whole / 30.0);
    }

    #[test]
    fn both_ends_of_a_pole_are_in_the_map() {
        let pole = Instance { half_extents: [30.0, 0.5, 0.5], ..ball(Vec3::ZERO, 0.0) };
        let turned = Quat::from_rotation_z(1.0);
        let pole = Instance { orientation: turned.to_array(), ..pole };
        // Beside a ball, to which the map would be fitted if the pole were scenery.
        let view = view_of(&[pole, ball(Vec3::ZERO, 1.0)]);
        assert!([30.0, -30.0].iter().all(|end| in_map(&view, turned * Vec3::X * *end)));
    }

    #[test]
    fn a_small_move_leaves_the_map_where_it_is() {
        let at = |x| view_of(&[ball(Vec3::new(x, 0.0, 0.0), 3.0)]).projection;
        assert_eq!(at(0.3), at(0.3001));
    }

    #[test]
    fn the_map_holds_every_point_of_a_surface_however_wide() {
        for size in [1.0_f32, 20.0, 80.0] {
            let points = [
                Vec3::new(-size, 1.0, -size),
                Vec3::new(size, 2.0, 0.0),
                Vec3::new(0.0, 3.0, size),
            ];
            let surfaces = vec![Surface::smooth(&points, [[0, 1, 2]], [1.0; 4])];
            let frame =
                Frame { surfaces, spheres: vec![ball(Vec3::ZERO, 0.5)], ..Frame::default() };
            let view = LightView::new(&TUTORIAL, Caster::all(&frame)).unwrap();
            assert!(points.iter().all(|point| in_map(&view, *point)), "{size}");
        }
    }
}
