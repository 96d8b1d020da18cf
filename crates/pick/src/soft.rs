//! Soft bodies as they are drawn: the points of one frame, and rays against their surfaces, points and springs.

use bevy_ecs::entity::Entity;
use glam::{DVec3, Vec3};
use motion::{Link, SoftBody};
use parry3d::query::Ray as LocalRay;
use parry3d::query::details::local_ray_intersection_with_triangle;

use crate::exact::within_reach;
use crate::{Drawn, Ray};

mod blades;

pub use blades::{BladeSurface, Blades};

/// Radius of a point of a rope, as a share of the mean rest length of its springs.
const POINT_RADIUS: f64 = 0.12;

/// Smallest and largest radius of a point, m: large enough to see and to hit, small enough for a rope.
const POINT_RADII: [f64; 2] = [0.002, 0.15];

/// Radius of a rope between its points, as a share of the radius of the points.
const LINK_RADIUS: f64 = 0.5;

/// A point of a soft body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftPoint {
    /// Where it is drawn, world space, m.
    pub position: DVec3,
    /// Whether forces move it.
    pub movable: bool,
}

/// A soft body as it is drawn in one frame.
#[derive(Clone, Debug)]
pub struct SoftPose {
    entity: Entity,
    points: Vec<Vec3>,
    movable: Vec<bool>,
    radius: f64,
    blades: Option<BladeSurface>,
}

impl SoftPose {
    /// The body.
    #[must_use]
    pub const fn entity(&self) -> Entity {
        self.entity
    }

    /// Drawn positions of its points minus the anchor, m; NaN for a missing point.
    #[must_use]
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Whether forces move point `number`; false for a missing point.
    #[must_use]
    pub fn is_movable(&self, number: u32) -> bool {
        self.movable.get(number as usize).is_some_and(|movable| *movable)
    }

    /// Radius of its points where they are drawn one by one, m: a share of the mean rest length of its springs.
    #[must_use]
    pub const fn point_radius(&self) -> f64 {
        self.radius
    }

    /// Radius of a rope between its points, m.
    #[must_use]
    pub const fn link_radius(&self) -> f64 {
        self.radius * LINK_RADIUS
    }

    /// The surface of its blades, if it has them.
    #[must_use]
    pub const fn blades(&self) -> Option<&BladeSurface> {
        self.blades.as_ref()
    }

    /// Positions of the points with those numbers minus the anchor, m; `None` if one of them is missing.
    #[must_use]
    pub fn corners<const N: usize>(&self, numbers: [u32; N]) -> Option<[Vec3; N]> {
        corners(&self.points, numbers)
    }

    fn update(
        &mut self,
        entity: Entity,
        body: &SoftBody,
        blades: Option<&Blades>,
        point: impl Fn(Entity) -> Option<SoftPoint>,
        anchor: DVec3,
    ) {
        self.entity = entity;
        self.points.clear();
        self.movable.clear();
        for found in body.points.iter().map(|entity| point(*entity)) {
            self.points.push(found.map_or(Vec3::NAN, |point| (point.position - anchor).as_vec3()));
            self.movable.push(found.is_some_and(|point| point.movable));
        }
        self.radius = point_radius(&body.springs);
        self.blades = blades.map(|blades| blades.surface(self));
    }

    /// A ball around its points: center and radius, m; `None` if all points are missing.
    fn bounds(&self) -> Option<(DVec3, f64)> {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for point in self.points.iter().filter(|point| within_reach(**point)) {
            (low, high) = (low.min(*point), high.max(*point));
        }
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        (low.x <= high.x).then(|| ((low + high) / 2.0, (high - low).length() / 2.0))
    }
}

/// Those of `places`; `None` if one of them is missing.
fn corners<const N: usize>(places: &[Vec3], numbers: [u32; N]) -> Option<[Vec3; N]> {
    let corners = numbers.map(|number| places.get(number as usize).copied().unwrap_or(Vec3::NAN));
    corners.iter().all(|corner| within_reach(*corner)).then_some(corners)
}

fn point_radius(springs: &[Link]) -> f64 {
    let sum: f64 = springs.iter().map(|spring| spring.elastic.rest_length).sum();
    #[expect(clippy::cast_precision_loss, reason = "no more springs than fit into memory")]
    let mean = sum / springs.len().max(1) as f64;
    let [least, most] = POINT_RADII;
    (POINT_RADIUS * mean).clamp(least, most)
}

/// The closest soft body on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftHit {
    /// The soft body.
    pub entity: Entity,
    /// Distance from the ray's origin, m, above 0.
    pub distance: f64,
    /// Point of its surface that was hit, world space, m.
    pub point: DVec3,
    /// Number of the triangle that was hit; `None` for a rope.
    pub triangle: Option<usize>,
    /// The body that a push at the hit acts on: the nearest movable point of the triangle, spring or point that was hit.
    pub pushed: Option<Entity>,
}

/// The drawn points of all soft bodies of one frame, relative to an anchor: filled once per frame, read by ray casts
/// and by the extraction of surfaces.
///
/// A soft body with triangles or blades is hit at its triangles, from both sides, and any other at its points and springs with the
/// radii at which they are drawn. A point that is missing or farther than 1e18 m is not hit, nor are its triangles and
/// springs.
#[derive(Debug, Default)]
pub struct SoftTargets {
    anchor: DVec3,
    poses: Vec<SoftPose>,
}

impl SoftTargets {
    /// Takes over the points of `bodies`, relative to `anchor` (world space, m; the camera's position). `point` returns
    /// each of them, or `None` for a point that is not drawn.
    pub fn update<'a>(
        &mut self,
        anchor: DVec3,
        bodies: impl Iterator<Item = (Entity, &'a SoftBody, Option<&'a Blades>)>,
        point: impl Fn(Entity) -> Option<SoftPoint>,
    ) {
        self.anchor = anchor;
        let mut count = 0;
        for (entity, body, blades) in bodies {
            if count == self.poses.len() {
                self.poses.push(SoftPose {
                    entity,
                    points: Vec::new(),
                    movable: Vec::new(),
                    radius: 0.0,
                    blades: None,
                });
            }
            self.poses[count].update(entity, body, blades, &point, anchor);
            count += 1;
        }
        self.poses.truncate(count);
    }

    /// Every soft body as it is drawn.
    #[must_use]
    pub fn poses(&self) -> &[SoftPose] {
        &self.poses
    }

    /// The closest soft body on `ray`; the first of two equally close ones. `body` returns the structure that belongs to a
    /// pose. Points and springs thinner than `thinnest` (radius over distance, at least 0) are drawn, and hit, with that ratio.
    ///
    /// Every triangle and spring of the bodies near the ray is tested; some 10 ns each.
    pub fn cast<'a>(
        &self,
        ray: &Ray,
        thinnest: f64,
        body: impl Fn(Entity) -> Option<&'a SoftBody>,
    ) -> Option<SoftHit> {
        let shift = ray.origin() - self.anchor;
        let mut closest: Option<SoftHit> = None;
        for pose in &self.poses {
            let limit = closest.map_or(f64::INFINITY, |hit| hit.distance);
            let Some(near) =
                Near::of(pose, ray, shift, thinnest).filter(|near| near.skipped < limit)
            else {
                continue;
            };
            let Some(body) = body(pose.entity) else { continue };
            let found = match &pose.blades {
                Some(BladeSurface { corners, triangles }) => {
                    near.surface(pose, corners, triangles, 2)
                }
                None if body.triangles.is_empty() => near.rope(pose, body),
                None => near.surface(pose, &pose.points, &body.triangles, 1),
            };
            if let Some(Found { distance, triangle, pushed }) =
                found.filter(|found| found.distance < limit)
            {
                let pushed = pushed.map(|number| body.points[number as usize]);
                let point = ray.at(distance);
                closest = Some(SoftHit { entity: pose.entity, distance, point, triangle, pushed });
            }
        }
        closest
    }
}

/// A hit on one body.
struct Found {
    distance: f64,
    triangle: Option<usize>,
    /// Number of the point that a push acts on.
    pushed: Option<u32>,
}

/// A ray that starts just before the ball around a body, so that the numbers of the exact tests are of the body's
/// size and not of its distance.
struct Near {
    /// Start relative to the anchor, m.
    start: DVec3,
    direction: DVec3,
    /// Length of the ray before `start`, m.
    skipped: f64,
    thinnest: f64,
    drawn: Drawn,
}

impl Near {
    /// Moves the start of the ray to the ball around a body; `None` if the ray misses the ball.
    fn of(pose: &SoftPose, ray: &Ray, shift: DVec3, thinnest: f64) -> Option<Self> {
        let (middle, radius) = pose.bounds()?;
        let (center, direction) = (middle - shift, ray.direction());
        let farthest = center.length() + radius;
        let radius = 1.01 * (radius + pose.radius.max(thinnest * farthest));
        let along = center.dot(direction);
        let aside = (center - direction * along).length();
        if along + radius < 0.0 || aside > radius {
            return None;
        }
        let skipped = (along - radius).max(0.0);
        Some(Self {
            start: shift + direction * skipped,
            direction,
            skipped,
            thinnest,
            drawn: ray.drawn(),
        })
    }

    fn local(&self, point: Vec3) -> DVec3 {
        point.as_dvec3() - self.start
    }

    /// The closest of these triangles, whose places are `each` for a point.
    fn surface(
        &self,
        pose: &SoftPose,
        places: &[Vec3],
        triangles: &[[u32; 3]],
        each: u32,
    ) -> Option<Found> {
        let ray = LocalRay::new(Vec3::ZERO, self.direction.as_vec3());
        let mut closest = f32::INFINITY;
        let mut hit = None;
        for (number, triangle) in triangles.iter().enumerate() {
            let Some(corners) = corners(places, *triangle) else { continue };
            let [a, b, c] = corners.map(|corner| self.local(corner).as_vec3());
            if let Some((met, weights)) = local_ray_intersection_with_triangle(a, b, c, &ray)
                && met.time_of_impact < closest
                && self.drawn.reaches(self.skipped + f64::from(met.time_of_impact))
            {
                closest = met.time_of_impact;
                hit = Some((number, *triangle, weights));
            }
        }
        let (number, triangle, weights) = hit?;
        let pushed = triangle
            .map(|corner| corner / each)
            .into_iter()
            .zip(weights.to_array())
            .filter(|(corner, _)| pose.is_movable(*corner))
            .max_by(|(_, a), (_, b)| a.total_cmp(b))
            .map(|(corner, _)| corner);
        Some(Found { distance: self.skipped + f64::from(closest), triangle: Some(number), pushed })
    }

    fn rope(&self, pose: &SoftPose, body: &SoftBody) -> Option<Found> {
        let mut closest: Option<Found> = None;
        let mut take = |distance: f64, pushed: Option<u32>| {
            if closest.as_ref().is_none_or(|found| distance < found.distance) {
                closest = Some(Found { distance, triangle: None, pushed });
            }
        };
        for (number, point) in (0..).zip(&pose.points) {
            if within_reach(*point)
                && let Some(distance) = self.capsule([*point; 2], pose.point_radius())
            {
                take(distance, Some(number).filter(|number| pose.is_movable(*number)));
            }
        }
        for Link { ends, .. } in &*body.springs {
            if let Some(corners) = pose.corners(*ends)
                && let Some(distance) = self.capsule(corners, pose.link_radius())
            {
                let met = self.direction * (distance - self.skipped);
                let away = |end: usize| self.local(corners[end]).distance_squared(met);
                let near_first = if away(0) <= away(1) { *ends } else { [ends[1], ends[0]] };
                take(distance, near_first.into_iter().find(|number| pose.is_movable(*number)));
            }
        }
        closest
    }

    /// Distance along the ray to a capsule of that radius, m, or of the radius that it is drawn with if that is
    /// larger. A capsule that contains the ray's origin is not hit.
    ///
    /// In f64 and not by parry, which tests a capsule only by a search for its support points.
    fn capsule(&self, ends: [Vec3; 2], radius: f64) -> Option<f64> {
        let [a, b] = ends.map(|end| self.local(end));
        let middle = (a + b) / 2.0;
        let distance = self.skipped + middle.dot(self.direction).max(0.0);
        let radius = radius.max(self.thinnest * distance);
        let axis = b - a;
        let along_axis = axis.dot(self.direction);
        let flat = axis.length_squared() - along_axis * along_axis;
        let mut entries = [a, b].map(|end| ball(end, self.direction, radius));
        if flat > 1e-12 * axis.length_squared() {
            // The infinite cylinder, where it is met between the ends.
            let across = axis.dot(a) * along_axis - axis.length_squared() * a.dot(self.direction);
            let rest = axis.length_squared() * (a.length_squared() - radius * radius)
                - axis.dot(a).powi(2);
            let root = across * across - flat * rest;
            let entry = (-across - root.sqrt()) / flat;
            let place = entry * along_axis - axis.dot(a);
            if root >= 0.0 && place > 0.0 && place < axis.length_squared() {
                entries[0] = Some(entry);
                entries[1] = None;
            }
        }
        let entry = entries.into_iter().flatten().min_by(f64::total_cmp)?;
        let distance = self.skipped + entry;
        self.drawn.reaches(distance).then_some(distance)
    }
}

/// How far along `direction` from the origin a ray enters a ball, m.
fn ball(center: DVec3, direction: DVec3, radius: f64) -> Option<f64> {
    let along = center.dot(direction);
    let aside = (center - direction * along).length_squared();
    let root = radius * radius - aside;
    (root >= 0.0).then(|| along - root.sqrt())
}

#[cfg(test)]
mod tests;
