//! Laws: accelerations that depend on position, velocity and time.
//!
//! A method evaluates a law as often as it needs, at states and times of its choice. An applied force
//! ([`Force`](crate::Force)) is constant over the tick and is not a law. Each law is one small file; a new law changes
//! no method.

mod body_drag;
mod curve;
pub(crate) mod damping;
mod drag;
pub(crate) mod epoch;
mod gravity;
#[cfg(test)]
mod lift;
mod mutual_gravity;
pub(crate) mod own;
mod prescribed_motion;
pub(crate) mod riding_well;
mod shared;
mod thrust;
pub(crate) mod tick_times;
mod wells;
mod wind;

use std::fmt::Debug;

use bevy_ecs::prelude::*;
use glam::DMat3;

use crate::units::Vector;

pub use body_drag::BodyDrag;
pub use curve::Curve;
pub use drag::Drag;
pub use gravity::Gravity;
#[cfg(test)]
pub use lift::Lift;
pub use mutual_gravity::{MutualGravity, SourceMass};
pub use prescribed_motion::PrescribedMotion;
pub use riding_well::RidingWell;
pub(crate) use riding_well::RidingWells;
#[cfg(feature = "serde")]
pub(crate) use shared::law_name;
pub(crate) use shared::{Changes, LawName, SharedLaws, SharedLawsParam, WorldLaw};
pub use shared::{LAWS, WorldLaws, device_forms};
pub use thrust::Thrust;
pub use wells::{Well, Wells};
pub use wind::{Air, Wind};

use crate::simd::vectorize;

/// The laws of every body that are resources of a world, in the order in which they are summed: name, type, part that can
/// be switched off alone, formula. A new law is a line here.
macro_rules! with_world_laws {
    ($then:ident) => {
        $crate::laws::with_laws_of_tests! {
            $then
            drag: Drag (wind: Wind)
                "drag of a fluid, linear and quadratic: a = -c u - k |u| u with u = v - wind";
            wells: Wells ()
                "points that attract or repel: a = -mu r / (r² + s²)^(3/2)";
        }
    };
}
pub(crate) use with_world_laws;

#[cfg(not(test))]
macro_rules! with_laws_of_tests {
    ($then:ident $($laws:tt)*) => {
        $then! { $($laws)* }
    };
}
#[cfg(test)]
macro_rules! with_laws_of_tests {
    ($then:ident $($laws:tt)*) => {
        $then! { $($laws)* lift: Lift () "lift of spinning bodies: a = w × v"; }
    };
}
pub(crate) use with_laws_of_tests;

/// The time at which a law is evaluated, and on which side of a discontinuity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct EvaluationTime {
    /// Time of the evaluation, s.
    pub time: f64,
    /// Side of a discontinuity: a time strictly within the step, s. A law that jumps compares this time with the jump,
    /// because `time` may be the jump itself, or lie outside the step.
    pub within_step: f64,
}

impl EvaluationTime {
    /// A time, s, that is no jump of a law.
    #[must_use]
    pub const fn at(time: f64) -> Self {
        Self { time, within_step: time }
    }
}

/// The state of a body at which a law is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub struct BodyState {
    /// Position, m.
    pub position: Vector,
    /// Velocity, m/s.
    pub velocity: Vector,
    /// Reciprocal of the mass, 1/kg, above 0: laws are not evaluated for immovable bodies.
    pub inverse_mass: f64,
}

impl BodyState {
    /// The state of a body of `mass`, kg, above 0, at `position`, m, with `velocity`, m/s.
    #[must_use]
    pub const fn new(position: Vector, velocity: Vector, mass: f64) -> Self {
        Self { position, velocity, inverse_mass: 1.0 / mass }
    }
}

/// Derivatives of an acceleration a by position and velocity, for implicit methods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jacobians {
    /// Derivative of a by position, 1/s²; column j is the derivative by coordinate j.
    pub position: DMat3,
    /// Derivative of a by velocity, 1/s.
    pub velocity: DMat3,
}

impl Jacobians {
    /// The Jacobians of a law that depends on time alone.
    #[must_use]
    pub fn zero() -> Self {
        Self { position: DMat3::ZERO, velocity: DMat3::ZERO }
    }
}

/// An affine law: `a = constant - rate v`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// The constant acceleration, m/s².
    pub constant: Vector,
    /// The rate of linear drag, 1/s.
    pub rate: f64,
}

impl Affine {
    /// Sums those of `laws` that are affine.
    pub(crate) fn sum<'a>(laws: impl Iterator<Item = &'a dyn Law>) -> Self {
        let zero = Self { constant: Vector::ZERO, rate: 0.0 };
        laws.filter_map(|law| law.affine()).fold(zero, |sum, law| Self {
            constant: sum.constant + law.constant,
            rate: sum.rate + law.rate,
        })
    }
}

/// The formula of a law among those that a graphics device evaluates for its particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeviceForm<'a> {
    /// `a = constant - rate v`.
    Affine(Affine),
    /// Drag that is not affine.
    Drag(&'a Drag),
    /// Points that attract or repel.
    Wells(&'a [Well]),
}

/// A law: the acceleration of one body as a function of its own state and the time.
///
/// ```
/// use bevy_ecs::prelude::*;
/// use motion::glam::DMat3;
/// use motion::prelude::*;
/// use motion::{BodyState, EvaluationTime, Jacobians, OwnLaws, Transform};
///
/// /// A spring to the origin: `a = -w² x`.
/// #[derive(Debug)]
/// struct Harmonic { w: f64 }
///
/// impl Law for Harmonic {
///     fn name(&self) -> &'static str { "harmonic" }
///     fn acceleration(&self, _: EvaluationTime, body: BodyState) -> Vector {
///         body.position * (-self.w * self.w)
///     }
///     fn jacobians(&self, _: EvaluationTime, _: BodyState) -> Jacobians {
///         Jacobians { position: DMat3::IDENTITY * (-self.w * self.w), ..Jacobians::zero() }
///     }
///     fn depends_on_velocity(&self) -> bool { false }
/// }
///
/// let mut world = World::new();
/// let laws = OwnLaws::new(vec![Box::new(Harmonic { w: std::f64::consts::TAU })]); // or for all: `Laws`
/// let body = world.spawn((Transform::at(Vector::X), PhysicsBody::with_mass(3.0), laws)).id();
/// let mut stepper = Stepper::new(&mut world, Method::RungeKutta4, TimeStep(0.01));
/// (0..100).for_each(|_| stepper.tick(&mut world));
/// assert!(world.get::<Transform>(body).unwrap().position.distance(Vector::X) < 1e-5);
/// ```
pub trait Law: Debug + Send + Sync + 'static {
    /// Name of the law in summaries, plans and receipts.
    fn name(&self) -> &'static str;

    /// Name and parameters of the law, for plans.
    fn text(&self) -> String {
        self.name().to_owned()
    }

    /// Acceleration of `body` at the time `at`, m/s².
    fn acceleration(&self, at: EvaluationTime, body: BodyState) -> Vector;

    /// Derivatives of [`Law::acceleration`] by position and velocity.
    fn jacobians(&self, at: EvaluationTime, body: BodyState) -> Jacobians;

    /// Whether the acceleration depends on the velocity. Some methods then take more evaluations or lose an order.
    fn depends_on_velocity(&self) -> bool;

    /// The law as a constant acceleration and linear drag, if it has no other terms. An affine law is summed once per tick and
    /// is never called.
    fn affine(&self) -> Option<Affine> {
        None
    }

    /// The well that the law is, if it rides on a body.
    #[doc(hidden)]
    fn riding_well(&self) -> Option<&RidingWell> {
        None
    }

    /// The formula by which a graphics device evaluates the law for its particles; `None` if it has none. An affine law has one.
    #[doc(hidden)]
    fn device_form(&self) -> Option<DeviceForm<'_>> {
        self.affine().map(DeviceForm::Affine)
    }

    /// Times at which the acceleration or its slope jumps, s. Steps are split at these times.
    fn discontinuities(&self) -> &[f64] {
        &[]
    }

    /// Whether the law is conservative: its work is the change of [`Law::potential_energy`]. The
    /// [`Ledger`](crate::ledger::Ledger) integrates the work of any other law along the path of the body.
    fn has_potential(&self) -> bool {
        false
    }

    /// Version of an own law whose acceleration in a given state and at a given time can change; `None` for every other law. A
    /// new version invalidates cached accelerations.
    fn version(&self) -> Option<u64> {
        None
    }

    /// Potential energy of `body`, J, for a law with [`Law::has_potential`].
    fn potential_energy(&self, body: BodyState) -> f64 {
        let _ = body;
        0.0
    }

    /// Adds the accelerations of a block of bodies to `sum`, m/s². Bodies of inverse mass 0 are skipped.
    ///
    /// There is one call per block and stage. The laws of this crate override this with something faster that gives the same bits.
    #[doc(hidden)]
    fn accelerate(&self, at: EvaluationTime, bodies: &BodyBlock<'_>, sum: &mut Axes) {
        bodies.add_each(
            sum,
            #[inline(always)]
            |body| self.acceleration(at, body),
        );
    }
}

/// Number of bodies in a block: laws are evaluated for this many at a time.
pub const BLOCK_BODIES: usize = 32;

/// x, y and z of the bodies of a block, as structures of arrays.
pub type Axes = [[f64; BLOCK_BODIES]; 3];

/// The states of a block of bodies at which a law is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct BodyBlock<'a> {
    /// Positions, m.
    pub positions: &'a Axes,
    /// Velocities, m/s.
    pub velocities: &'a Axes,
    /// Reciprocals of the masses, 1/kg.
    pub inverse_masses: &'a [f64; BLOCK_BODIES],
}

impl BodyBlock<'_> {
    /// The state of body number `k`.
    #[must_use]
    #[inline(always)]
    pub fn body(&self, k: usize) -> BodyState {
        let Self { positions: [x, y, z], velocities: [a, b, c], inverse_masses } = self;
        BodyState {
            position: Vector::from_array([x[k], y[k], z[k]]),
            velocity: Vector::from_array([a[k], b[k], c[k]]),
            inverse_mass: inverse_masses[k],
        }
    }

    /// Adds `acceleration` of every body whose inverse mass is above 0 to `sum`, with vector instructions if it is
    /// arithmetic without branches.
    #[inline(always)]
    pub fn add_each(&self, sum: &mut Axes, acceleration: impl Fn(BodyState) -> Vector) {
        let added = vectorize(
            #[inline(always)]
            || {
                // Without branches: one comparison of vectors.
                let all_move = self.inverse_masses.iter().fold(true, |all, w| all & (*w > 0.0));
                if all_move {
                    // Not into `sum` itself: the compiler would have to assume that it overlaps with the states.
                    let mut all = [[0.0; BLOCK_BODIES]; 3];
                    #[expect(clippy::needless_range_loop, reason = "one number for many arrays")]
                    for k in 0..BLOCK_BODIES {
                        let [x, y, z] = acceleration(self.body(k)).to_array();
                        (all[0][k], all[1][k], all[2][k]) = (x, y, z);
                    }
                    for (sum, all) in sum.iter_mut().zip(&all) {
                        sum.iter_mut().zip(all).for_each(|(sum, a)| *sum += *a);
                    }
                }
                all_move
            },
        );
        if !added {
            for k in (0..BLOCK_BODIES).filter(|k| self.inverse_masses[*k] > 0.0) {
                let a = acceleration(self.body(k)).to_array();
                (0..3).for_each(|axis| sum[axis][k] += a[axis]);
            }
        }
    }
}

/// Your own laws for every body, added to those of this crate.
#[derive(Resource, Debug, Default)]
pub struct Laws(pub Vec<Box<dyn Law>>);

/// The laws of every body, in the order in which they are summed. This includes gravity that is not [on](Gravity::on),
/// but no law that was [switched](crate::effects::switch()) off.
pub fn laws(world: &World) -> impl Iterator<Item = &dyn Law> {
    let gravity = world.get_resource::<Gravity>();
    SharedLaws::of(world).on_body(gravity, false, &[])
}

#[cfg(test)]
mod tests;
