//! The program's own look, if the picture is not the tutorial's: one palette for bodies that a scene did not paint, and a soft
//! lamp at one side.

use glam::{DVec3, Vec3};
use pick::Shape;
use render::Light;
use scene::{Appearance, BodySpec, Scene};

use crate::view::camera::Camera;
use crate::view::navigation::extent_at_start;

const BOX: [f32; 3] = [0.28, 0.50, 0.80];
const BALL: [f32; 3] = [0.95, 0.58, 0.25];
const IMMOVABLE: [f32; 3] = [0.60, 0.62, 0.65];

/// Color of the lamp, linear.
const LAMP_COLOR: Vec3 = Vec3::new(1.15, 1.12, 1.05);

/// Direction of the lamp as seen from the scene's camera: to the left, up and toward the camera.
const LAMP_ASIDE: [f64; 3] = [0.55, 1.0, 0.45];

/// How far away the lamp is, in radii of what moves: its shadows cover 22.5 degrees to each side.
const LAMP_DISTANCE: f64 = 5.0;

/// The color of a body, as displayed.
pub(super) fn color(look: Appearance, shape: &Shape, movable: bool) -> [f32; 3] {
    match shape {
        _ if look.color != [1.0; 3] => look.color,
        _ if !movable => IMMOVABLE,
        Shape::Cuboid { .. } => BOX,
        Shape::Sphere { .. } => BALL,
    }
}

/// The lamp of a scene that declares a light.
#[derive(Clone, Debug, Default)]
pub(super) struct Lamp {
    /// The middle of what moves at the start, m.
    middle: DVec3,
    /// From the middle to the lamp, m.
    offset: DVec3,
    /// Ids of the bodies that shine where nothing is up, ascending.
    pub suns: Vec<u32>,
}

impl Lamp {
    pub fn of(scene: &Scene) -> Self {
        let (middle, radius) = extent_at_start(scene).unwrap_or_default();
        let view = Camera::new(scene.camera).viewpoint();
        let [left, up, near] = LAMP_ASIDE;
        let toward = -left * view.right() + up * DVec3::Y - near * view.forward();
        Self {
            middle,
            offset: toward.normalize_or(DVec3::Y) * (LAMP_DISTANCE * radius.max(2.0)),
            suns: suns(scene),
        }
    }

    /// The lamp relative to `eye`, m.
    pub fn seen_from(&self, eye: DVec3, shadows: bool) -> Light {
        Light {
            position: (self.middle + self.offset - eye).as_vec3(),
            target: (self.middle - eye).as_vec3(),
            color: LAMP_COLOR,
            shadows,
        }
    }
}

/// The places of wells, m.
pub(crate) fn wells(scene: &Scene) -> Vec<DVec3> {
    let own = scene.own_laws.values().flat_map(|laws| &laws.wells);
    let wells = scene.laws.wells.iter().flat_map(|wells| &wells.0).chain(own);
    let mut places: Vec<_> = wells.map(|well| well.position).collect();
    places.dedup();
    places
}

/// Ids of the balls that shine: those that are drawn where a well is, and among bodies that attract each other the one that has
/// most of the mass.
fn suns(scene: &Scene) -> Vec<u32> {
    let wells = wells(scene);
    let mass = |body: &BodySpec| {
        let own = body.inverse_mass.map(f64::recip).filter(|mass| mass.is_finite());
        body.source_mass.or(own).unwrap_or_default()
    };
    let most = match scene.mutual_gravity {
        Some(_) => 0.5 * scene.bodies.iter().map(mass).sum::<f64>(),
        None => f64::INFINITY,
    };
    let shines = |body: &BodySpec| match body.shape {
        Some(Shape::Sphere { radius }) if body.inverse_mass.is_none() => {
            wells.iter().any(|well| well.distance(body.position) <= radius)
        }
        Some(Shape::Sphere { .. }) => mass(body) > most,
        _ => false,
    };
    (0..).zip(&scene.bodies).filter(|(_, body)| shines(body)).map(|(id, _)| id).collect()
}
