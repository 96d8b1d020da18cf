//! The mouse moves the camera: orbit, pan, zoom and frame. Only within the cockpit: without it the mouse is the tutorial's.

use glam::{DVec2, DVec3};
use motion::{PhysicsBody, SoftBody};
use pick::Shape;

use crate::app::held::Drag;
use crate::app::session::Session;
use crate::view::stage::Mode;

/// Degrees per point of a drag around a place.
const DEGREES_PER_POINT: f64 = 0.3;

/// What is left of the distance after a notch of the wheel.
const CLOSER: f64 = 0.9;

/// How much room a framed thing leaves around it.
const ROOM: f64 = 1.3;

/// Least radius that is framed, m.
const SMALLEST: f64 = 0.5;

impl Session {
    /// Shows the bars and the dock, with a free pointer, or hides them.
    pub(crate) fn toggle_cockpit(&mut self) {
        self.let_go();
        if self.ui.toggle_cockpit() && self.view.mode == Mode::Camera {
            self.toggle_mode();
        }
    }

    /// Whether drags and the wheel move the camera.
    pub(crate) fn moves_camera(&self) -> bool {
        self.ui.cockpit.shown && self.view.mode == Mode::Selection
    }

    /// Whether the wheel zooms: it changes the force of a click while there is something to push, or Ctrl is held.
    pub(crate) fn zooms(&self) -> bool {
        let pushes = self.sim.scene.push.is_some() && self.moves_selection();
        self.moves_camera() && !pushes && !self.hands.held.changes_force()
    }

    /// What the camera moves about: what is under the pointer, else the selection, else the middle of all that moves.
    pub(crate) fn pivot(&mut self) -> DVec3 {
        let ray = self.picking_ray();
        if let Some(hit) = self.cast(&ray) {
            return ray.at(hit.distance);
        }
        let selected = self.seen.selection.and_then(|thing| self.drawn_position(thing));
        selected.or_else(|| Some(self.extent()?.0)).unwrap_or_else(|| ray.at(SMALLEST))
    }

    /// Moves the camera by a drag of so many pixels.
    pub(crate) fn drag(&mut self, drag: Drag, by: DVec2) {
        self.seen.locked = None;
        let view = self.viewpoint();
        match drag {
            Drag::Orbit(pivot) => {
                let points = by / f64::from(self.ui.pixels_per_point());
                self.view.camera.orbit(pivot, points * DEGREES_PER_POINT);
            }
            Drag::Pan(pivot) => {
                let meters = 2.0 * (0.5 * view.fov_y_rad).tan() * (pivot - view.position).dot(view.forward())
                    / self.view_area()[1].y;
                self.view.camera.position += (view.up() * by.y - view.right() * by.x) * meters.max(0.0);
            }
        }
    }

    /// Comes nearer to what is under the pointer, or goes away from it.
    pub(crate) fn zoom(&mut self, notches: f64) {
        self.seen.locked = None;
        let pivot = self.pivot();
        let away = self.view.camera.position - pivot;
        let (view, distance) = (self.viewpoint(), away.length());
        let wanted = distance * CLOSER.powf(notches.clamp(-20.0, 20.0));
        // Never through the pivot, and not where nothing is drawn any more.
        let wanted = wanted.clamp((2.0 * view.near_m).min(distance), view.far_m.max(distance));
        self.view.camera.position = pivot + away.normalize_or_zero() * wanted;
    }

    /// Puts the selection, or all that moves, into the middle of the view; the camera looks where it looked.
    pub(crate) fn frame_view(&mut self) {
        let Some((middle, radius)) = self.extent() else { return };
        self.seen.locked = None;
        let (view, [_, size]) = (self.viewpoint(), self.view_area());
        let half_up = (0.5 * view.fov_y_rad).tan();
        let half = half_up.min(half_up * size.x / size.y.max(1.0)).atan();
        let distance = ROOM * radius.max(SMALLEST) / half.sin();
        self.view.camera.position = middle - view.forward() * distance;
    }

    /// Middle and radius of the selection or, without one, of all that moves, m; of everything where nothing moves.
    fn extent(&self) -> Option<(DVec3, f64)> {
        let movable = |thing: &_| {
            let body = self.sim.world.get::<PhysicsBody>(*thing);
            body.is_some_and(|body| body.inverse_mass > 0.0)
        };
        let mut things: Vec<_> = match self.seen.selection {
            Some(thing) => {
                let soft = self.sim.world.get::<SoftBody>(thing);
                soft.map_or_else(|| vec![thing], |soft| soft.points.clone())
            }
            None => self.things().filter(movable).collect(),
        };
        if things.is_empty() {
            things = self.things().collect();
        }
        let balls = things.iter().filter_map(|thing| {
            let radius = self.sim.world.get::<Shape>(*thing).map_or(0.0, Shape::bounding_radius);
            Some((self.drawn_position(*thing)?, radius)).filter(|(place, _)| place.is_finite())
        });
        let balls: Vec<_> = balls.collect();
        let least = balls.iter().map(|(place, radius)| *place - *radius).reduce(DVec3::min)?;
        let most = balls.iter().map(|(place, radius)| *place + *radius).reduce(DVec3::max)?;
        let middle = (least + most) / 2.0;
        let radius = balls.iter().map(|(place, radius)| place.distance(middle) + radius).fold(0.0, f64::max);
        Some((middle, radius))
    }
}
