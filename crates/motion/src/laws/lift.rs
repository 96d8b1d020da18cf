//! Lift of spinning bodies: an example of a law, which only the tests of this crate have.

use bevy_ecs::prelude::*;
use glam::DMat3;

use super::{BodyState, EvaluationTime, Jacobians, Law, WorldLaw};
use crate::units::Vector;

/// Lift of bodies that spin about a fixed axis: `a = w × v` (Magnus 1853).
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Lift {
    /// w, 1/s.
    pub turn: Vector,
}

impl Lift {
    /// The matrix M with `M v = w × v`.
    fn matrix(&self) -> DMat3 {
        let [x, y, z] = Vector::AXES.map(|axis| self.turn.cross(axis));
        DMat3::from_cols(x, y, z)
    }
}

impl WorldLaw for Lift {
    fn is_finite(&self) -> bool {
        self.turn.is_finite()
    }
}

impl Law for Lift {
    fn name(&self) -> &'static str {
        "lift"
    }

    fn acceleration(&self, _: EvaluationTime, body: BodyState) -> Vector {
        self.matrix() * body.velocity
    }

    fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
        Jacobians { velocity: self.matrix(), ..Jacobians::zero() }
    }

    fn depends_on_velocity(&self) -> bool {
        true
    }
}
