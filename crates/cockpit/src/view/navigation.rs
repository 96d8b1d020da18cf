//! The mouse moves the camera: orbit, pan, zoom and frame. Only within the cockpit: without it the mouse is the tutorial's.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3, Vec3};
use motion::{PhysicsBody, SoftBody};
use pick::Shape;
use scene::{CameraSpec, EmitterSpec, Scene};

use crate::stage::Stage;
use crate::stage::things::{Thing, is_movable};
use crate::view::View;
use crate::view::ground::{is_flat, swing};

/// Degrees per point of a drag around a place.
const DEGREES_PER_POINT: f64 = 0.3;

/// Factor by which a notch of the wheel changes the distance.
const CLOSER: f64 = 0.9;

/// Distance of a framed thing, as a multiple of the one at which it just fills the view.
const ROOM: f64 = 1.3;

/// Distance beyond which bodies are seen from far away, as a multiple of the one at which they are framed.
const FAR: f64 = 1.6;

/// Greatest number of bodies that are looked for in the view.
const CROWD: usize = 10_000;

/// The radius that is framed of what has none, m.
const OF_A_POINT: f64 = 0.5;

/// Least distance of the camera from what it approaches, m.
const LEAST: f64 = 1e-6;

/// How a drag of the pointer moves the camera about a place, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Drag {
    /// Around it.
    Orbit(DVec3),
    /// Sideways and up, so that it stays under the pointer.
    Pan(DVec3),
}

impl View {
    /// The place about which the camera moves, m: what is under the pointer, else the selection, else the middle of all that
    /// moves.
    pub(crate) fn pivot(&mut self, stage: &Stage) -> DVec3 {
        let ray = self.picking_ray();
        if let Some(hit) = self.cast(stage, &ray) {
            return ray.at(hit.distance);
        }
        let selected = stage.selection().and_then(|thing| stage.drawn_position(thing));
        let all = || Some(extent(stage, None, now(stage))?.0);
        selected.or_else(all).unwrap_or_else(|| ray.at(OF_A_POINT))
    }

    /// Moves the camera by a drag of `by` pixels; a point has `pixels_per_point` pixels.
    pub(crate) fn drag(&mut self, drag: Drag, by: DVec2, pixels_per_point: f32) {
        self.locked = None;
        let view = self.viewpoint();
        match drag {
            Drag::Orbit(pivot) => {
                let points = by / f64::from(pixels_per_point);
                self.camera.orbit(pivot, points * DEGREES_PER_POINT);
            }
            Drag::Pan(pivot) => {
                let meters_per_pixel = 2.0
                    * (0.5 * view.fov_y_rad).tan()
                    * (pivot - view.position).dot(view.forward())
                    / self.view_area()[1].y;
                self.camera.position +=
                    (view.up() * by.y - view.right() * by.x) * meters_per_pixel.max(0.0);
            }
        }
    }

    /// Moves the camera toward what is under the pointer, or away from it.
    pub(crate) fn zoom(&mut self, stage: &Stage, notches: f64) {
        let pivot = self.pivot(stage);
        self.approach(pivot, CLOSER.powf(notches.clamp(-20.0, 20.0)));
    }

    /// Moves the camera to `times` its distance from `pivot`.
    pub(crate) fn approach(&mut self, pivot: DVec3, times: f64) {
        self.locked = None;
        let away = self.camera.position - pivot;
        let (view, distance) = (self.viewpoint(), away.length());
        let wanted = distance * times;
        // Never through the pivot, and not so far away that nothing is drawn any more.
        let wanted = wanted.clamp(LEAST.min(distance), view.far_m.max(distance));
        self.camera.draw_from(wanted);
        self.camera.position = pivot + away.normalize_or_zero() * wanted;
    }

    /// The middle of what [`frame`](Self::frame) frames, m.
    pub(crate) fn middle(stage: &Stage) -> Option<DVec3> {
        extent(stage, stage.selection(), now(stage)).map(|(middle, _)| middle)
    }

    /// Puts the selection or, without one, all bodies but floors, scenery and particles into the middle of the view, without
    /// turning the camera.
    pub(crate) fn frame(&mut self, stage: &Stage) {
        self.frame_ball(extent(stage, stage.selection(), now(stage)));
    }

    /// Puts all bodies but floors, scenery and particles into the middle of the view, without turning the camera.
    pub(crate) fn frame_all(&mut self, stage: &Stage) {
        self.frame_ball(extent(stage, None, now(stage)));
    }

    /// The same with everything where it is at the start.
    pub(crate) fn frame_start(&mut self, stage: &Stage) {
        self.frame_ball(extent(stage, None, at_start(stage)));
    }

    /// Puts a ball of that middle and radius, m, into the middle of the view, without turning the camera.
    pub(crate) fn frame_ball(&mut self, ball: Option<(DVec3, f64)>) {
        let Some((middle, radius)) = ball else { return };
        self.locked = None;
        let distance = self.framed_distance(radius);
        self.camera.position = middle - self.viewpoint().forward() * distance;
        self.camera.draw_from(distance);
    }

    /// Whether the scene left the camera to the program, and its bodies are seen from far away, or the view is higher than wide, for
    /// which no scene is made.
    #[must_use]
    pub fn should_be_framed(&self, stage: &Stage) -> bool {
        let Some((middle, radius)) = extent(stage, None, at_start(stage)) else { return false };
        let [_, size] = self.view_area();
        let is_upright = self.has_bars() && size.y > size.x;
        is_upright
            || stage.sim().scene.camera == CameraSpec::TUTORIAL
                && self.camera.position.distance(middle) > FAR * self.framed_distance(radius)
    }

    /// The distance at which a ball of that radius fills the view, m.
    fn framed_distance(&self, radius: f64) -> f64 {
        let (view, [_, size]) = (self.viewpoint(), self.view_area());
        let half_up = (0.5 * view.fov_y_rad).tan();
        let half = half_up.min(half_up * size.x / size.y.max(1.0)).atan();
        ROOM * if radius > 0.0 { radius } else { OF_A_POINT } / half.sin()
    }

    /// Pixels per meter across the picture: at the body that the camera follows, else at the middle of where all that moves
    /// began, so that the number changes with the camera alone.
    pub(crate) fn pixels_per_meter(&self, stage: &Stage) -> Option<f64> {
        let followed =
            self.locked.and_then(|thing| stage.drawn_position(thing.entity(stage.sim())?));
        let start = || extent_at_start(&stage.sim().scene).map(|(middle, _)| middle);
        let middle = followed.or_else(start)?;
        let [at, aside] =
            [middle, middle + self.viewpoint().right()].map(|place| self.seen_at(place));
        Some(at?.0.distance(aside?.0)).filter(|pixels| pixels.is_finite() && *pixels > 0.0)
    }

    /// Whether bodies move, and none of them is inside the view.
    pub(crate) fn has_lost_all(&self, stage: &Stage) -> bool {
        let mut moving = moving(stage).peekable();
        let is_seen = |thing| stage.drawn_position(thing).is_some_and(|place| self.sees(place));
        moving.peek().is_some() && !moving.any(is_seen)
    }

    /// Whether everything that moves is below the floor.
    pub(crate) fn all_fell_through(&self, stage: &Stage) -> bool {
        let height = |thing| stage.drawn_position(thing).map_or(f64::NAN, |place| place.y);
        let top = self.ground.floor_top;
        top.is_some_and(|top| moving(stage).all(|thing| height(thing) < top))
    }

    /// Puts the camera back to where the scene put it, and unlocks it.
    pub(crate) fn reset_camera(&mut self, stage: &Stage) {
        self.camera.reset();
        self.locked = None;
        if self.has_bars() && self.should_be_framed(stage) {
            self.frame_start(stage);
        }
    }

    /// Locks the camera to the selection, or unlocks it.
    pub(crate) fn toggle_lock(&mut self, stage: &Stage) {
        self.locked = match self.locked {
            Some(_) => None,
            None => stage.selection().and_then(|entity| Thing::of(stage.sim(), entity)),
        };
    }
}

/// The bodies that move, and the points of soft bodies, but not the particles of emitters, among the first [`CROWD`].
fn moving(stage: &Stage) -> impl Iterator<Item = Entity> {
    let moves = |thing: &Entity| {
        let body = stage.sim().world.get::<PhysicsBody>(*thing);
        body.is_some_and(|body| body.inverse_mass > 0.0) && !is_particle(stage, *thing)
    };
    stage.sim().remaining_bodies().take(CROWD).filter(moves)
}

fn is_particle(stage: &Stage, thing: Entity) -> bool {
    stage.sim().id(thing).is_some_and(|id| stage.sim().scene.is_particle(id))
}

/// The places of things now, m.
fn now(stage: &Stage) -> impl Fn(Entity) -> Option<DVec3> + '_ {
    move |thing| stage.drawn_position(thing)
}

/// The places of bodies at the start, m.
fn at_start(stage: &Stage) -> impl Fn(Entity) -> Option<DVec3> + '_ {
    move |thing| Some(stage.sim().scene.bodies.get(stage.sim().id(thing)? as usize)?.position)
}

/// Middle and radius of `one` thing or, without it, of all bodies but floors, scenery and particles, with the ends of springs as
/// far as they swing, m; of everything in a scene without such bodies. `place` says where each is.
fn extent(
    stage: &Stage,
    one: Option<Entity>,
    place: impl Fn(Entity) -> Option<DVec3>,
) -> Option<(DVec3, f64)> {
    let (sim, scene) = (stage.sim(), &stage.sim().scene);
    let shape = |thing: Entity| sim.world.get::<Shape>(thing);
    let is_subject = |thing: &Entity| {
        let is_floor = !is_movable(&sim.world, *thing) && shape(*thing).is_some_and(is_flat);
        sim.world.get::<PhysicsBody>(*thing).is_some() && !is_floor && !is_particle(stage, *thing)
    };
    let mut things: Vec<_> = match one {
        Some(thing) => {
            let soft = stage.sim().world.get::<SoftBody>(thing);
            soft.map_or_else(|| vec![thing], |soft| soft.points.clone())
        }
        None => sim.remaining_bodies().filter(is_subject).collect(),
    };
    if things.is_empty() {
        things = sim.remaining_bodies().collect();
    }
    let balls = things.iter().filter_map(|thing| {
        let radius = shape(*thing).map_or(0.0, Shape::bounding_radius);
        Some((place(*thing)?, radius)).filter(|(place, _)| place.is_finite())
    });
    let whole = one.is_none();
    let emitters = scene.emitters.iter().filter(|_| whole);
    let reaches = emitters
        .map(|emitter| reach(scene, emitter).unwrap_or_else(|| (place_of(scene, emitter), 0.0)));
    let swings = scene.springs.iter().filter(|_| whole).filter_map(|spring| swing(scene, spring));
    let balls: Vec<_> =
        balls.chain(reaches).chain(swings.flatten().map(|place| (place, 0.0))).collect();
    let least = balls.iter().map(|(place, radius)| *place - *radius).reduce(DVec3::min)?;
    let most = balls.iter().map(|(place, radius)| *place + *radius).reduce(DVec3::max)?;
    let middle = (least + most) / 2.0;
    let radius =
        balls.iter().map(|(place, radius)| place.distance(middle) + radius).fold(0.0, f64::max);
    Some((middle, radius))
}

/// Distance from the scene's camera to the middle of what moves, m; not finite if nothing moves.
pub(crate) fn distance_of(scene: &Scene) -> f64 {
    extent_at_start(scene).map_or(f64::NAN, |(middle, _)| middle.distance(scene.camera.position))
}

/// The place where the particles of an emitter are born, m, with the places of bodies.
pub(crate) fn birthplace(emitter: &EmitterSpec, of: impl Fn(u32) -> Option<DVec3>) -> DVec3 {
    emitter.position + emitter.rides_on.and_then(of).unwrap_or_default()
}

/// The same at the start.
fn place_of(scene: &Scene, emitter: &EmitterSpec) -> DVec3 {
    birthplace(emitter, |id| scene.bodies.get(id as usize).map(|body| body.position))
}

/// The place where particles on the graphics device are born at the start, and about how far they get, m: to the top of a throw,
/// or half their way.
fn reach(scene: &Scene, emitter: &EmitterSpec) -> Option<(DVec3, f64)> {
    // All are thrown equally fast.
    let speed = Vec3::from(*emitter.on_device.as_ref()?.launches.first()?).length();
    let gravity = scene.gravity.map_or(0.0, |gravity| gravity.acceleration.length());
    let speed = f64::from(speed);
    Some((place_of(scene, emitter), (speed * emitter.life).min(speed * speed / gravity) / 2.0))
}

/// Middle of the places of all that moves at the start of a scene, and half the diagonal of the box around them, m.
pub(super) fn extent_at_start(scene: &Scene) -> Option<(DVec3, f64)> {
    let reaches = || scene.emitters.iter().filter_map(|emitter| reach(scene, emitter));
    let ends = || reaches().flat_map(|(place, reach)| [place - reach, place + reach]);
    let places = || {
        scene.bodies.iter().filter(|body| body.is_movable()).map(|body| body.position).chain(ends())
    };
    let (least, most) = (places().reduce(DVec3::min), places().reduce(DVec3::max));
    least.zip(most).map(|(least, most)| ((least + most) / 2.0, most.distance(least) / 2.0))
}
