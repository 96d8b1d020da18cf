//! A half-line with a unit direction, or a part of a half-line.

use std::fmt;

use glam::DVec3;

/// A half-line: it starts at its origin and has no end, unless it hits only [what is drawn](Self::through).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    origin: DVec3,
    direction: DVec3,
    drawn: Drawn,
}

/// The part of a ray that a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawn {
    /// Distance from which on surfaces are drawn, m: a shape that is entered before it is not seen from inside.
    pub nearest: f64,
    /// Distance up to which surfaces are drawn, m.
    pub farthest: f64,
    /// Width below which a shape leaves no trace in the picture, as a share of its distance.
    pub finest: f64,
}

impl Drawn {
    /// Everything.
    const ALL: Self = Self { nearest: 0.0, farthest: f64::INFINITY, finest: 0.0 };

    /// Whether a surface that is entered at `distance` m is drawn. NaN is not.
    #[inline]
    #[must_use]
    pub fn reaches(&self, distance: f64) -> bool {
        distance > 0.0 && distance >= self.nearest && distance <= self.farthest
    }
}

/// Why no ray could be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayError {
    /// The origin has a component that is not finite.
    Origin(DVec3),
    /// The direction is zero, not finite, or too short or too long to be normalized.
    Direction(DVec3),
}

impl fmt::Display for RayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Origin(origin) => write!(f, "a ray cannot start at {origin}: not finite"),
            Self::Direction(direction) => {
                write!(f, "a ray cannot point along {direction}: it has no direction")
            }
        }
    }
}

impl std::error::Error for RayError {}

impl Ray {
    /// A ray from `origin` (world space, m) along `direction`, which need not be of unit length.
    ///
    /// # Errors
    ///
    /// If the origin is not finite, or the direction is zero or not finite.
    pub fn new(origin: DVec3, direction: DVec3) -> Result<Self, RayError> {
        if !origin.is_finite() {
            return Err(RayError::Origin(origin));
        }
        let direction = direction.try_normalize().ok_or(RayError::Direction(direction))?;
        Ok(Self { origin, direction, drawn: Drawn::ALL })
    }

    /// The same ray, restricted to surfaces that are drawn.
    #[must_use]
    pub const fn through(self, drawn: Drawn) -> Self {
        Self { drawn, ..self }
    }

    /// The part of the ray that can hit.
    pub(crate) const fn drawn(&self) -> Drawn {
        self.drawn
    }

    /// Start of the ray, world space, m.
    #[must_use]
    pub const fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Direction of the ray, of unit length.
    #[must_use]
    pub const fn direction(&self) -> DVec3 {
        self.direction
    }

    /// The point `distance` m along the ray.
    #[must_use]
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_has_a_unit_direction() {
        let ray = Ray::new(DVec3::ONE, DVec3::new(0.0, 0.0, -25.0)).unwrap();
        assert_eq!(ray.direction(), DVec3::NEG_Z);
        assert_eq!(ray.at(2.0), DVec3::new(1.0, 1.0, -1.0));
    }

    #[test]
    fn a_ray_without_a_direction_or_an_origin_is_refused() {
        for direction in [DVec3::ZERO, DVec3::NAN, DVec3::X * f64::INFINITY] {
            assert!(
                matches!(Ray::new(DVec3::ZERO, direction), Err(RayError::Direction(_))),
                "{direction}"
            );
        }
        let error = Ray::new(DVec3::NAN, DVec3::X).unwrap_err();
        assert!(matches!(error, RayError::Origin(_)));
        assert!(error.to_string().contains("not finite"));
    }
}
