//! Sums over all bodies: energy, momentum, angular momentum.

use bevy_ecs::prelude::*;

use crate::components::{PhysicsBody, StableId, Transform};
use crate::effects::Gravity;
use crate::units::{Scalar, Vector};

/// Energy and momentum of all movable bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Sum of `m v² / 2`, J.
    pub kinetic_energy: Scalar,
    /// Sum of `-m g · x` under gravity that is on, J; zero at the origin.
    pub potential_energy: Scalar,
    /// Sum of `m v`, kg m/s.
    pub momentum: Vector,
    /// Sum of `m x × v` about the origin, kg m²/s.
    pub angular_momentum: Vector,
}

/// Sums over every movable body of `world`, in stable-id order so that no table order changes a bit; bodies
/// without an id come last, in table order.
pub fn totals(world: &mut World) -> Totals {
    let gravity = world.get_resource::<Gravity>().and_then(Gravity::acting);
    let mut rows: Vec<_> = world
        .query::<(Option<&StableId>, &Transform, &PhysicsBody)>()
        .iter(world)
        .filter(|(_, _, body)| body.inverse_mass > 0.0)
        .map(|(id, transform, body)| (id.map_or(u32::MAX, |id| id.0), *transform, *body))
        .collect();
    rows.sort_by_key(|(id, _, _)| *id);
    let mut sum = Totals::default();
    for (_, transform, body) in rows {
        let momentum = body.momentum();
        sum.kinetic_energy += body.kinetic_energy();
        sum.momentum += momentum;
        sum.angular_momentum += transform.position.cross(momentum);
        if let Some(g) = gravity {
            sum.potential_energy -= body.mass() * g.dot(transform.position);
        }
    }
    sum
}
