//! Picking: rays find things where they are drawn.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use motion::{
    Dormant, Orientation, PhysicsBody, PreviousPosition, Quarantined, SoftBody, Transform,
};
use pick::{Blades, Chunk, Drawn, Ray, Shape, SoftPoint, Viewpoint};

use crate::stage::Stage;
use crate::stage::query;
use crate::stage::things::{Picked, drawn, is_movable};
use crate::view::picture::find_points;
use crate::view::{Mode, View};

/// Least width at which parts of a soft body are drawn and hit, pixels.
const THINNEST_PX: f64 = 2.0;

/// Width below which a body leaves no trace in the picture, pixels.
const THINNEST_SHAPE_PX: f64 = 0.5;

/// Smallest radius with which a particle is drawn, pixels (crates/render/shaders/particle.wgsl).
const SMALLEST_DISC_PX: f64 = 0.75;

/// How much farther than the ground a floor in its place may be found, by rounding.
const ON_GROUND: f64 = 1.0 + 1e-5;

/// Half the widest vertical field of view, radians.
const WIDEST: f64 = 1.2;

impl View {
    /// The ray that picks: through the pointer in selection mode, through the middle of the view otherwise.
    pub(crate) fn picking_ray(&self) -> Ray {
        let [corner, size] = self.view_area();
        let pixel = if self.mode == Mode::Selection { self.pointer - corner } else { size / 2.0 };
        self.viewpoint().ray_through(pixel, size)
    }

    /// The camera as rays and pictures need it. Beside panels the view may be narrow: it is widened to show what is
    /// seen from side to side without them.
    pub fn viewpoint(&self) -> Viewpoint {
        let mut view = self.camera.viewpoint();
        let [width, height] = self.size_px.map(f64::from);
        let DVec2 { x, y } = self.view_area()[1];
        let narrower = (width / height.max(1.0)) / (x / y.max(1.0));
        if narrower > 1.0 {
            view.fov_y_rad = 2.0 * ((0.5 * view.fov_y_rad).tan() * narrower).atan().min(WIDEST);
        }
        view
    }

    /// The part of the picture that shows the scene: its top left corner and its size, pixels.
    pub fn view_area(&self) -> [DVec2; 2] {
        let [width, height] = self.size_px;
        let [left, top, width, height] =
            self.view_px.unwrap_or([0, 0, width, height]).map(f64::from);
        [DVec2::new(left, top), DVec2::new(width, height)]
    }

    /// Projects a place to pixels from the top left of the picture, and whether that is inside the view; `None` if it is behind
    /// the camera.
    pub(crate) fn seen_at(&self, place: DVec3) -> Option<(DVec2, bool)> {
        let [corner, size] = self.view_area();
        let at = self.viewpoint().project(place, size)?;
        Some((at + corner, at.cmpge(DVec2::ZERO).all() && at.cmple(size).all()))
    }

    /// Whether a place is inside the view.
    pub(crate) fn sees(&self, place: DVec3) -> bool {
        self.seen_at(place).is_some_and(|(_, inside)| inside)
    }

    /// The closest thing on a ray from the camera, as drawn. Things behind the ground come after all others. Drops of emitters
    /// are not things.
    pub(crate) fn cast(&mut self, stage: &Stage, ray: &Ray) -> Option<Picked> {
        self.see(stage);
        let view = self.viewpoint();
        let (along, finest) =
            (ray.direction().dot(view.forward()), self.pixel() * THINNEST_SHAPE_PX);
        let drawn = Drawn { nearest: view.near_m / along, farthest: view.far_m / along, finest };
        let Some(ground) =
            self.distance_of_ground(stage, ray).filter(|ground| *ground < drawn.farthest)
        else {
            return self.cast_through(stage, ray, drawn);
        };
        let above = self.cast_through(stage, ray, Drawn { farthest: ground * ON_GROUND, ..drawn });
        match above {
            Some(hit) if !self.is_in_place_of_ground(stage, hit.entity) => Some(hit),
            floor => {
                let below = Drawn { nearest: ground * ON_GROUND, ..drawn };
                self.cast_through(stage, ray, below).or(floor)
            }
        }
    }

    /// The distance along a ray from the camera to the ground that is drawn, m.
    fn distance_of_ground(&self, stage: &Stage, ray: &Ray) -> Option<f64> {
        let ground = self.ground.seen_from(self.camera.position, self.is_own_look(stage))?;
        let distance = f64::from(ground.height_m) / ray.direction().y;
        (distance > 0.0).then_some(distance)
    }

    /// Whether the ground is drawn in place of a body.
    fn is_in_place_of_ground(&self, stage: &Stage, body: Entity) -> bool {
        let shape = stage.sim().world.get::<Shape>(body);
        shape.is_some_and(|shape| self.is_ground(stage, body, shape))
    }

    fn cast_through(&self, stage: &Stage, ray: &Ray, drawn: Drawn) -> Option<Picked> {
        let through = &ray.through(drawn);
        let solid =
            self.seen.targets.cast(through).map(|hit| (hit.entity, hit.distance, Some(hit.entity)));
        let soft =
            self.seen.soft.cast(through, self.thinnest(), |body| stage.sim().world.get(body));
        let soft = soft.map(|hit| (hit.entity, hit.distance, hit.pushed));
        let disc =
            self.disc_on(ray, drawn).map(|(entity, distance)| (entity, distance, Some(entity)));
        // Of equally close hits, the solid one.
        let hits = solid.into_iter().chain(soft).chain(disc);
        let (entity, distance, pushed) = hits.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Picked { entity, distance, pushed })
    }

    /// The closest particle that is drawn as a disc on a ray from the camera, and its distance, m.
    fn disc_on(&self, ray: &Ray, drawn: Drawn) -> Option<(Entity, f64)> {
        let (forward, smallest) = (self.viewpoint().forward(), SMALLEST_DISC_PX * self.pixel());
        let along = ray.direction().dot(forward);
        let discs =
            self.seen.points.iter().filter(|point| point.fade.is_none()).filter_map(|point| {
                let center = point.position - ray.origin();
                let depth = center.dot(forward);
                let distance = depth / along;
                let radius = f64::from(point.radius).max(smallest * depth);
                let is_hit =
                    (ray.direction() * distance).distance_squared(center) <= radius * radius;
                (is_hit && drawn.reaches(distance)).then_some((point.entity, distance))
            });
        discs.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The thing that a click would select in the cockpit; with `immovable`, also things that cannot be moved.
    pub(crate) fn hovered(&mut self, stage: &Stage, immovable: bool) -> Option<Entity> {
        let [corner, size] = self.view_area();
        let at = self.pointer - corner;
        let inside = at.cmpge(DVec2::ZERO).all() && at.cmple(size).all();
        if !self.has_bars() || self.mode == Mode::Camera || stage.here().pull.is_some() || !inside {
            return None;
        }
        let ray = self.picking_ray();
        self.cast(stage, &ray)
            .map(|hit| hit.entity)
            .filter(|thing| immovable || is_movable(&stage.sim().world, *thing))
    }

    /// Smallest radius with which ropes are drawn, as a fraction of the distance.
    pub(crate) fn thinnest(&self) -> f64 {
        0.5 * THINNEST_PX * self.pixel()
    }

    /// Size of a pixel in the middle of the view, as a fraction of the distance along the line of sight.
    pub(super) fn pixel(&self) -> f64 {
        let height = self.view_area()[1].y.max(1.0);
        2.0 * (0.5 * self.viewpoint().fov_y_rad).tan() / height
    }

    /// Updates the drawn poses to the current state, relative to the camera.
    pub fn see(&mut self, stage: &Stage) {
        let version = Some(stage.here().version);
        let Self { seen, camera, .. } = self;
        if seen.version == version && seen.targets.anchor() == camera.position {
            return;
        }
        let (world, alpha) = (&stage.sim().world, stage.here().alpha);
        let mut things = query::<
            (Entity, &Transform, Option<&PreviousPosition>, &Shape, Option<&Orientation>),
            Without<Dormant>,
        >(&stage.sim().world);
        let tables =
            things.contiguous_iter(world).expect("every component of a thing is stored in tables");
        let chunks = tables.map(|(entities, transforms, previous, shapes, orientations)| Chunk {
            entities,
            transforms,
            previous,
            shapes,
            orientations,
        });
        seen.targets.update(camera.position, alpha, chunks);
        let mut bodies = query::<(Entity, &SoftBody, Option<&Blades>), ()>(&stage.sim().world);
        let mut points = query::<
            (&Transform, Option<&PreviousPosition>, &PhysicsBody),
            (Without<Quarantined>, Without<Dormant>),
        >(&stage.sim().world);
        let points = points.query(world);
        let point = |entity| {
            let (now, before, body) = points.get(entity).ok()?;
            Some(SoftPoint {
                position: drawn(now, before, alpha),
                movable: body.inverse_mass > 0.0,
            })
        };
        seen.soft.update(camera.position, bodies.iter(world), point);
        find_points(stage, &mut seen.points);
        seen.version = version;
    }
}

#[cfg(test)]
mod tests;
