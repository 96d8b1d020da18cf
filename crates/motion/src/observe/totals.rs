//! Totals over all bodies: energy, momentum, angular momentum.

use bevy_ecs::prelude::*;

use crate::groups::potential_energy;
use crate::laws::{Gravity, SharedLaws};
use crate::state::components::PhysicsBody;
use crate::state::emitter::Dormant;
use crate::tick::columns::{NO_STEPPER, observed};
use crate::units::{Scalar, Vector};

/// Energy, momentum and angular momentum of all movable bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct Totals {
    /// Sum of `m v² / 2`, J.
    pub kinetic_energy: Scalar,
    /// Sum of the potential energies of all laws with a potential, J. That of gravity is zero at the origin, that of
    /// wells and mutual gravity at infinity, that of springs at rest length.
    pub potential_energy: Scalar,
    /// Sum of `m v`, kg m/s.
    pub momentum: Vector,
    /// Sum of `m x × v` about the origin, kg m²/s.
    pub angular_momentum: Vector,
}

/// Computes the totals of all movable bodies of `world`. Sums are in stable-id order, so that the order of tables
/// changes no bit; bodies without an id come last, in table order.
///
/// # Panics
/// If no stepper was made for `world`.
#[must_use]
pub fn totals(world: &World) -> Totals {
    let mut query = observed::<Without<Dormant>>(world);
    let gravity = world.get_resource::<Gravity>();
    let shared = SharedLaws::of(world);
    let mut rows: Vec<_> = query.iter(world).filter(|row| row.body.inverse_mass > 0.0).collect();
    rows.sort_by_key(|row| row.key().0);
    let mut sum = Totals { potential_energy: potential_energy(world), ..Totals::default() };
    for row in rows {
        let (momentum, state, options) = (row.body.momentum(), row.state(), row.options.options());
        sum.kinetic_energy += row.body.kinetic_energy();
        sum.momentum += momentum;
        sum.angular_momentum += state.position.cross(momentum);
        let laws = shared.on_body(gravity.filter(|_| !options.gravity_off), false, options.laws);
        for law in laws.filter(|law| law.has_potential()) {
            sum.potential_energy += law.potential_energy(state);
        }
    }
    sum
}

/// A query that sums the kinetic energy of one world, faster than [`totals`] and with different rounding.
#[derive(Debug)]
pub struct KineticEnergy(QueryState<&'static PhysicsBody, Without<Dormant>>);

impl KineticEnergy {
    /// Makes a query for `world`.
    ///
    /// # Panics
    /// If no stepper was made for `world`.
    #[must_use]
    pub fn new(world: &World) -> Self {
        Self(world.try_query_filtered().expect(NO_STEPPER))
    }

    /// Sum of `m v² / 2` over the movable bodies of `world`, J, in the order of its tables.
    ///
    /// # Panics
    /// If `world` is not the world that the query was made for.
    pub fn sum(&mut self, world: &World) -> Scalar {
        let tables =
            self.0.contiguous_iter(world).expect("the state of a body is stored in tables");
        // Four sums: the divisions of one lane do not wait for the sum of another.
        let mut lanes = [0.0; 4];
        for block in tables.flat_map(|bodies| bodies.chunks(4)) {
            for (lane, body) in lanes.iter_mut().zip(block) {
                let energy = body.velocity.length_squared() / body.inverse_mass;
                *lane += if body.inverse_mass > 0.0 { energy } else { 0.0 };
            }
        }
        0.5 * lanes.iter().sum::<Scalar>()
    }
}
