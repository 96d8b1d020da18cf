//! Wells: points that attract or repel every body.

use bevy_ecs::prelude::*;
use glam::DMat3;

use super::{
    Axes, BLOCK_BODIES, BodyBlock, BodyState, DeviceForm, EvaluationTime, Jacobians, Law, WorldLaw,
};
use crate::units::{Scalar, Vector, at_least_0, outer};

/// A point that attracts every body, whatever its mass: `a = -mu r / (r² + s²)^(3/2)` with r from the well to the body
/// (Newton; softened after Plummer 1911). At the center of a well without softening the force is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Well {
    /// Position, m.
    pub position: Vector,
    /// mu, m³/s²; negative repels.
    pub strength: Scalar,
    /// s, m, at least 0: keeps the acceleration finite near the well.
    pub softening: Scalar,
}

impl Well {
    /// A well at `position`, m, of the strength mu, m³/s², without softening.
    #[must_use]
    pub const fn new(position: Vector, strength: Scalar) -> Self {
        Self { position, strength, softening: 0.0 }
    }

    /// The same with a [`softening`](Self::softening), m.
    #[must_use]
    pub const fn softened(self, softening: Scalar) -> Self {
        Self { softening, ..self }
    }

    /// r and `(r² + s²)^(-1/2)`, which counts as 0 if r and s are 0: a force would have no direction there.
    #[inline(always)]
    fn reach(&self, body: BodyState) -> (Vector, f64) {
        let r = body.position - self.position;
        let squared = r.dot(r) + self.softening * self.softening;
        let inverse = 1.0 / squared.sqrt();
        (r, if squared == 0.0 { 0.0 } else { inverse })
    }

    /// The acceleration by this well alone, m/s².
    #[inline(always)]
    pub(super) fn acceleration(&self, body: BodyState) -> Vector {
        let (r, inverse) = self.reach(body);
        r * -(self.strength * inverse * inverse * inverse)
    }

    /// `sum` plus the derivative of the acceleration by position, 1/s².
    pub(super) fn add_jacobian(&self, sum: DMat3, body: BodyState) -> DMat3 {
        let (r, inverse) = self.reach(body);
        let cubed = self.strength * inverse * inverse * inverse;
        sum + outer(r, r) * (3.0 * cubed * inverse * inverse) - DMat3::IDENTITY * cubed
    }

    /// `mu / (r² + s²)^(3/2)` at `position`, 1/s²: the square of the frequency of a circular orbit there.
    pub(crate) fn squared_frequency(&self, position: Vector) -> Scalar {
        let squared = position.distance_squared(self.position) + self.softening * self.softening;
        self.strength / (squared * squared.sqrt())
    }
}

impl Well {
    /// The restoring part of the negative derivative of the acceleration, 1/s². A well that attracts restores across the line to
    /// it, and along it near its center if it is softened; one that repels restores along the line, farther out.
    pub(crate) fn restoring(&self, position: Vector) -> DMat3 {
        let r = position - self.position;
        let squared = r.length_squared();
        let [across, along] = self.restoring_across_and_along(position);
        if squared == 0.0 {
            return DMat3::from_diagonal(Vector::splat(across));
        }
        DMat3::IDENTITY * across + outer(r, r) * ((along - across) / squared)
    }

    /// The largest squared frequency of [`Self::restoring`], 1/s².
    pub(crate) fn largest_restoring(&self, position: Vector) -> Scalar {
        let [across, along] = self.restoring_across_and_along(position);
        across.max(along)
    }

    fn restoring_across_and_along(&self, position: Vector) -> [Scalar; 2] {
        let across = self.squared_frequency(position);
        let squared = position.distance_squared(self.position);
        let along = across * (1.0 - 3.0 * squared / (squared + self.softening * self.softening));
        [across.max(0.0), along.max(0.0)]
    }
}

/// Every well of the scene.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect), reflect(Resource))]
pub struct Wells(pub Vec<Well>);

impl WorldLaw for Wells {
    fn check(&self) {
        self.0.iter().for_each(|well| at_least_0(well.softening, "the softening of a well", "m"));
    }

    fn is_finite(&self) -> bool {
        // An infinite softening is valid: it leaves no pull.
        let is_finite = |well: &Well| {
            well.position.is_finite() && well.strength.is_finite() && !well.softening.is_nan()
        };
        self.0.iter().all(is_finite)
    }

    fn list_bytes(&self) -> usize {
        self.0.capacity() * size_of::<Well>()
    }
}

impl Law for Wells {
    fn name(&self) -> &'static str {
        "wells"
    }

    fn text(&self) -> String {
        format!("wells: {}", self.0.len())
    }

    fn acceleration(&self, _: EvaluationTime, body: BodyState) -> Vector {
        let mut sum = Vector::ZERO;
        self.0.iter().for_each(|well| sum += well.acceleration(body));
        sum
    }

    fn accelerate(&self, _: EvaluationTime, bodies: &BodyBlock<'_>, sum: &mut Axes) {
        if let [well] = &self.0[..] {
            bodies.add_each(
                sum,
                #[inline(always)]
                |body| well.acceleration(body),
            );
            return;
        }
        let mut wells = [[0.0; BLOCK_BODIES]; 3];
        for well in &self.0 {
            bodies.add_each(
                &mut wells,
                #[inline(always)]
                |body| well.acceleration(body),
            );
        }
        for (sum, wells) in sum.iter_mut().zip(&wells) {
            sum.iter_mut().zip(wells).for_each(|(sum, a)| *sum += *a);
        }
    }

    fn jacobians(&self, _: EvaluationTime, body: BodyState) -> Jacobians {
        let position = self.0.iter().fold(DMat3::ZERO, |sum, well| well.add_jacobian(sum, body));
        Jacobians { position, ..Jacobians::zero() }
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }

    fn has_potential(&self) -> bool {
        true
    }

    fn device_form(&self) -> Option<DeviceForm<'_>> {
        Some(DeviceForm::Wells(&self.0))
    }

    /// `-m mu / sqrt(r² + s²)`.
    fn potential_energy(&self, body: BodyState) -> f64 {
        let sum = self.0.iter().map(|well| well.strength * well.reach(body).1).sum::<f64>();
        -(sum / body.inverse_mass)
    }
}
