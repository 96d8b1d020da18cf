//! Handles at the selection: arrows along the axes that move its entry when they are dragged.

use egui::{Color32, Painter, Pos2, Stroke};
use glam::{DQuat, DVec3};
use motion::{Orientation, SoftBody};
use pick::Shape;
use render::{Frame, Instance, Particle};
use scene::Appearance;

use super::parts::rounded_to_multiple;
use super::selected::selected_entry;
use crate::stage::Stage;
use crate::view::View;
use crate::view::hud::point;
use crate::view::navigation::birthplace;
use crate::view::picture::{PLAIN, add_translucent};

/// The axes and the colors of their arrows.
const AXES: [(DVec3, Color32); 3] = [
    (DVec3::X, Color32::from_rgb(255, 90, 75)),
    (DVec3::Y, Color32::from_rgb(115, 230, 100)),
    (DVec3::Z, Color32::from_rgb(100, 155, 255)),
];

/// Length of an arrow beyond the object that it moves, as a fraction of the distance of the object.
const LENGTH: f64 = 0.1;

/// Greatest number of bodies that are shown where a drag would put them.
const SHOWN: usize = 2000;

/// The arrow that is dragged, and how far.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Handle {
    axis: DVec3,
    /// Start of the arrows when it was pressed, m.
    from: DVec3,
    /// Place of the press on the axis, m from `from`.
    pressed: f64,
    /// How far it was dragged, m.
    pub by: DVec3,
}

/// The start and the length of the arrows of the selection, m.
fn arrows(stage: &Stage, view: &View) -> Option<(DVec3, f64)> {
    let thing = stage.selection()?;
    let (entry, _) = selected_entry(stage)?;
    let sim = stage.sim();
    let emitter = sim.scene.emitters.get(entry.index).filter(|_| entry.list == "emitters");
    let at = match emitter {
        Some(emitter) => birthplace(emitter, |id| stage.drawn_position(sim.body(id)?)),
        None => stage.drawn_position(thing)?,
    };
    let world = &stage.sim().world;
    let radius = match world.get::<SoftBody>(thing) {
        Some(soft) => {
            let points = soft.points.iter().filter_map(|point| stage.drawn_position(*point));
            points.map(|point| point.distance(at)).fold(0.0, f64::max)
        }
        None => world.get::<Shape>(thing).map_or(0.0, Shape::bounding_radius),
    };
    let distance = at.distance(view.camera.position);
    Some((at, radius.min(2.0 * LENGTH * distance) + LENGTH * distance))
        .filter(|(at, _)| at.is_finite())
}

impl Handle {
    /// The arrow within `near_px` pixels of the pointer.
    pub fn under_pointer(stage: &Stage, view: &View, near_px: f64) -> Option<Self> {
        let (from, length) = arrows(stage, view)?;
        let pointer = view.pointer;
        let distance = |axis: DVec3| {
            let [(tail, _), (tip, _)] = [view.seen_at(from)?, view.seen_at(from + axis * length)?];
            let along = tip - tail;
            let part = ((pointer - tail).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            // The middle belongs to the body: it is clicked and pulled there.
            let near = (tail + along * part).distance(pointer);
            (part > 0.25 && along.length() > near_px && near.is_finite()).then_some(near)
        };
        let near = AXES.iter().filter_map(|(axis, _)| Some((distance(*axis)?, *axis)));
        let (_, axis) =
            near.filter(|(near, _)| *near <= near_px).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let pressed = along(view, from, axis)?;
        Some(Self { axis, from, pressed, by: DVec3::ZERO })
    }

    /// Follows the pointer.
    pub fn follow(&mut self, view: &View) {
        if let Some(now) = along(view, self.from, self.axis) {
            let step = step(self.from.distance(view.camera.position));
            self.by = self.axis * rounded_to_multiple(now - self.pressed, step);
        }
    }

    /// Draws the dragged bodies where the drag would put them.
    pub fn draw(&self, stage: &Stage, view: &View, frame: &mut Frame) {
        let Some((entry, _)) = selected_entry(stage) else { return };
        let eye = view.camera.position;
        for id in entry.bodies.take(SHOWN) {
            let Some(body) = stage.sim().body(id) else { continue };
            let Some(at) = stage.drawn_position(body) else { continue };
            let world = &stage.sim().world;
            let position = (at + self.by - eye).as_vec3().to_array();
            let [r, g, b] = world.get::<Appearance>(body).copied().unwrap_or(PLAIN).color;
            let color = [r, g, b, 0.6];
            let Some(shape) = world.get::<Shape>(body) else {
                frame.translucent.particles.push(Particle { position, radius_m: 0.05, color });
                continue;
            };
            let half_extents = shape.half_extents().as_vec3().to_array();
            let turned = world.get::<Orientation>(body).map_or(DQuat::IDENTITY, |turned| turned.0);
            let orientation = turned.as_quat().to_array();
            let instance =
                Instance { position, half_extents, orientation, color, ..Default::default() };
            add_translucent(frame, shape, instance);
        }
    }
}

/// The arrows of the selection in the picture: their ends, points, and their colors.
pub(super) fn seen(stage: &Stage, view: &View, painter: &Painter) -> Vec<([Pos2; 2], Color32)> {
    let Some((from, length)) = arrows(stage, view) else { return Vec::new() };
    let at = |place| Some(point(painter, view.seen_at(place)?.0));
    let seen = |(axis, color)| Some(([at(from)?, at(from + axis * length)?], color));
    AXES.into_iter().filter_map(seen).collect()
}

/// Paints the arrows of the selection over the picture: inside a body, or behind one, they would not be seen.
pub(super) fn paint_handles(stage: &Stage, view: &View, painter: &Painter) {
    for ([tail, tip], color) in seen(stage, view, painter) {
        for (width, color) in [(5.0, Color32::from_black_alpha(160)), (3.0, color)] {
            painter.arrow(tail, tip - tail, Stroke::new(width, color));
        }
    }
}

/// The point on the axis through `from` that is nearest to the pointer's ray, m from `from`.
fn along(view: &View, from: DVec3, axis: DVec3) -> Option<f64> {
    let ray = view.picking_ray();
    let (direction, between) = (ray.direction(), from - ray.origin());
    let cosine = axis.dot(direction);
    let sine_squared = 1.0 - cosine * cosine;
    // Seen along the axis, every pixel is far away.
    (sine_squared > 1e-4)
        .then(|| (cosine * direction.dot(between) - axis.dot(between)) / sine_squared)
}

/// The grid of a drag, m: two thousandths of the distance, rounded down to a power of ten.
fn step(distance: f64) -> f64 {
    10.0_f64.powf((0.002 * distance.max(0.01)).log10().floor())
}
