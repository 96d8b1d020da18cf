//! The volume that a ray can hit.

use std::fmt;

use bevy_ecs::component::Component;
use glam::DVec3;

/// The volume that rays hit, centered on its entity's position.
///
/// A shape on an entity without a `PhysicsBody` is scenery: it never moves, and rays hit it all the same.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A box, rotated by the entity's `Orientation` if it has one.
    Cuboid {
        /// Half of each edge, m.
        half_extents: DVec3,
    },
    /// A ball.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
}

/// The error of a size that no shape can have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeError {
    /// Name of the size.
    what: &'static str,
    /// The refused size, m.
    size: f64,
}

impl fmt::Display for ShapeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, size) = (self.what, self.size);
        write!(
            f,
            "{what} is {size} m; it must be between {:e} and {:e} m",
            Shape::SMALLEST,
            Shape::LARGEST
        )
    }
}

impl std::error::Error for ShapeError {}

impl Shape {
    /// Smallest size of a shape, m: rays are tested in f32, and its square must not vanish there.
    pub const SMALLEST: f64 = 1e-15;
    /// Largest size of a shape, m: its square must stay finite in f32.
    pub const LARGEST: f64 = 1e15;

    /// A box of the given half edges, m.
    ///
    /// # Errors
    ///
    /// If one of them is not finite, or not between [`Self::SMALLEST`] and [`Self::LARGEST`].
    pub fn cuboid(half_extents: DVec3) -> Result<Self, ShapeError> {
        Self::Cuboid { half_extents }.validated()
    }

    /// A ball of the given radius, m.
    ///
    /// # Errors
    ///
    /// If it is not finite, or not between [`Self::SMALLEST`] and [`Self::LARGEST`].
    pub fn sphere(radius: f64) -> Result<Self, ShapeError> {
        Self::Sphere { radius }.validated()
    }

    /// The shape itself if its sizes are usable; for shapes that were written as literals.
    ///
    /// # Errors
    ///
    /// As [`Self::cuboid`] and [`Self::sphere`].
    pub fn validated(self) -> Result<Self, ShapeError> {
        let sizes = match self {
            Self::Cuboid { half_extents: DVec3 { x, y, z } } => [
                ("the half extent along x", x),
                ("the half extent along y", y),
                ("the half extent along z", z),
            ],
            Self::Sphere { radius } => [("the radius", radius); 3],
        };
        match sizes.iter().find(|(_, size)| !(Self::SMALLEST..=Self::LARGEST).contains(size)) {
            Some(&(what, size)) => Err(ShapeError { what, size }),
            None => Ok(self),
        }
    }

    /// Radius of the smallest ball around the center that contains the shape, m.
    #[must_use]
    pub fn bounding_radius(&self) -> f64 {
        match *self {
            Self::Cuboid { half_extents } => half_extents.length(),
            Self::Sphere { radius } => radius,
        }
    }

    /// Half of each edge of the box that contains the unrotated shape, m: the scale of a unit mesh.
    #[must_use]
    pub fn half_extents(&self) -> DVec3 {
        match *self {
            Self::Cuboid { half_extents } => half_extents,
            Self::Sphere { radius } => DVec3::splat(radius),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_that_is_not_positive_and_finite_is_refused_by_name() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-40, 1e40] {
            assert!(Shape::sphere(bad).is_err(), "radius {bad}");
            let error = Shape::cuboid(DVec3::new(1.0, bad, 1.0)).unwrap_err().to_string();
            assert!(error.starts_with("the half extent along y is"), "{error}");
        }
        assert_eq!(
            Shape::sphere(-2.0).unwrap_err().to_string(),
            "the radius is -2 m; it must be between 1e-15 and 1e15 m"
        );
    }

    #[test]
    fn the_bounding_ball_reaches_the_corners() {
        assert_eq!(Shape::cuboid(DVec3::new(2.0, 3.0, 6.0)).unwrap().bounding_radius(), 7.0);
        assert_eq!(Shape::sphere(2.5).unwrap().bounding_radius(), 2.5);
        assert_eq!(Shape::sphere(2.5).unwrap().half_extents(), DVec3::splat(2.5));
    }
}
