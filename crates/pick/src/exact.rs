//! The exact test of one ray against one shape: that of parry, done close to the shape.

use glam::{DVec3, Quat, Vec3};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose;
use parry3d::query::{Ray as LocalRay, RayCast};
use parry3d::shape::{Ball, Cuboid};

use crate::{Ray, Shape};

/// Whether something at `center` (m, relative to the anchor) can be hit at all: not if a coordinate is NaN, nor if it is so
/// far away that squares would overflow in f32.
#[inline]
pub(crate) fn within_reach(center: Vec3) -> bool {
    // Not `max_element() <`, which does not see a NaN beside a number.
    center.abs().cmplt(Vec3::splat(1e18)).all()
}

/// A shape in types of parry.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Volume {
    Ball(Ball),
    Cuboid(Cuboid),
    /// A literal with a size that the constructors refuse; never hit.
    Nothing,
}

impl Volume {
    pub(crate) fn of(shape: &Shape) -> Self {
        match shape.validated() {
            Ok(Shape::Sphere { radius }) => Self::Ball(Ball::new(radius as f32)),
            Ok(Shape::Cuboid { half_extents }) => Self::Cuboid(Cuboid::new(half_extents.as_vec3())),
            Err(_) => Self::Nothing,
        }
    }

    /// Radius of the ball around the center that contains it, m; NaN, which fails every comparison, for [`Self::Nothing`].
    pub(crate) fn bounding_radius(&self) -> f32 {
        match self {
            Self::Ball(ball) => ball.radius,
            Self::Cuboid(cuboid) => cuboid.half_extents.length(),
            Self::Nothing => f32::NAN,
        }
    }

    /// Half extents of the axis-aligned box that contains the rotated shape, m.
    pub(crate) fn reach(&self, orientation: Quat) -> Vec3 {
        match self {
            Self::Ball(ball) => Vec3::splat(ball.radius),
            Self::Cuboid(cuboid) => Aabb::new(-cuboid.half_extents, cuboid.half_extents)
                .transform_by(&Pose::from_rotation(orientation))
                .half_extents(),
            Self::Nothing => Vec3::ZERO,
        }
    }

    /// Whether the shape is at least `finest` m wide, seen in a direction; a thin plate is not, seen from its edge.
    #[inline]
    fn is_seen(&self, orientation: Quat, direction: DVec3, finest: f64) -> bool {
        if 2.0 * f64::from(self.bounding_radius()) < finest {
            return false;
        }
        let Self::Cuboid(cuboid) = self else { return true };
        if finest <= 2.0 * f64::from(cuboid.half_extents.min_element()) {
            return true;
        }
        // The projection of a box is as wide in a direction as those of its edges together, and is narrowest across one of them.
        let edges = [Vec3::X, Vec3::Y, Vec3::Z]
            .map(|axis| (orientation * (axis * cuboid.half_extents)).as_dvec3());
        let width =
            |across: DVec3| edges.iter().map(|edge| 2.0 * edge.dot(across).abs()).sum::<f64>();
        let across = edges.iter().filter_map(|edge| direction.cross(*edge).try_normalize());
        across.map(width).all(|width| width >= finest)
    }

    /// Distance along `ray` to the shape whose center is at `center` (m from the ray's origin), if it is hit
    /// at all and closer than `limit` m.
    ///
    /// A shape that contains the origin is not hit.
    #[inline]
    pub(crate) fn distance(
        &self,
        orientation: Quat,
        center: DVec3,
        ray: &Ray,
        limit: f64,
    ) -> Option<f64> {
        // parry forms b² - c and the like in f32, which for a ball of 1 m at 1 km is noise of the size of the
        // ball. So its ray starts just outside of the bounding ball, where all numbers are of the shape's size.
        let skipped =
            (center.dot(ray.direction()) - 1.01 * f64::from(self.bounding_radius())).max(0.0);
        if skipped > limit {
            return None;
        }
        let start = (ray.direction() * skipped - center).as_vec3();
        let local = LocalRay::new(start, ray.direction().as_vec3());
        let rest = match self {
            Self::Ball(ball) => ball.cast_local_ray(&local, f32::MAX, true),
            Self::Cuboid(cuboid) => {
                cuboid.cast_ray(&Pose::from_rotation(orientation), &local, f32::MAX, true)
            }
            Self::Nothing => None,
        }?;
        // parry answers 0 to a ray that starts inside, and NaN fails the comparison as well.
        let distance = skipped + f64::from(rest);
        let drawn = ray.drawn();
        let is_hit = rest > 0.0 && distance <= limit && drawn.reaches(distance);
        (is_hit && self.is_seen(orientation, ray.direction(), drawn.finest * distance))
            .then_some(distance)
    }
}
