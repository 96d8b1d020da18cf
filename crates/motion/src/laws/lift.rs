//! Lift of spinning bodies: an example of a law, which only the tests of this crate have.

use bevy_ecs::prelude::*;

use super::{BodyState, EvaluationTime, Jacobians, Law, WorldLaw};
use crate::real::{Real, RealMatrix, RealVector};
use crate::units::Vector;

/// Lift of bodies that spin about a fixed axis: `a = w × v` (Magnus 1853).
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Lift {
    /// w, 1/s.
    pub turn: Vector,
}

impl Lift {
    /// The matrix M with `M v = w × v`.
    fn matrix<T: Real>(&self) -> T::Matrix {
        T::Matrix::from_columns(Vector::AXES.map(|axis| T::Vector::of(self.turn.cross(axis))))
    }
}

impl WorldLaw for Lift {
    fn is_finite(&self) -> bool {
        self.turn.is_finite()
    }
}

impl<T: Real> Law<T> for Lift {
    fn name(&self) -> &'static str {
        "lift"
    }

    fn acceleration(&self, _: EvaluationTime<T>, body: BodyState<T>) -> T::Vector {
        self.matrix::<T>().times(body.velocity)
    }

    fn jacobians(&self, _: EvaluationTime<T>, _: BodyState<T>) -> Jacobians<T> {
        Jacobians { velocity: self.matrix::<T>(), ..Jacobians::zero() }
    }

    fn depends_on_velocity(&self) -> bool {
        true
    }
}
