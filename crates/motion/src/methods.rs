//! The methods of integration, each written once.
//!
//! A method is a function from a state to the state one step later. It knows neither how many bodies there are
//! nor where they lie: it asks a [`Field`] for accelerations, and reckons with whatever [`Space`] the field
//! reckons with: a block of bodies in registers, f64 or f32, or a single number in a test.
//!
//! State changes only by adding increments to it: what a register holds beside the state stays in it, and a
//! compensated sum may take the place of a plain one.

pub(crate) mod euler;
mod implicit_euler;
pub(crate) mod markers;
mod runge_kutta;
pub(crate) mod table;
mod verlet;
mod yoshida;

use std::ops::{Add, Mul, Sub};

pub use euler::{ExplicitEuler, SemiImplicitEuler};
pub use implicit_euler::{ImplicitEuler, MOST_ITERATIONS, Newton, newton_velocity};
pub use runge_kutta::{RungeKutta2Heun, RungeKutta2Midpoint, RungeKutta4};
pub(crate) use verlet::Synchronize;
pub use verlet::{PositionVerlet, VelocityVerlet};
pub use yoshida::Yoshida4;

use crate::methods::table::Method;
use crate::real::Real;

/// What positions, velocities and accelerations are in.
pub trait Space<T>: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<T, Output = Self> {}

impl<T, X: Copy + Add<Output = X> + Sub<Output = X> + Mul<T, Output = X>> Space<T> for X {}

/// Gives a method the accelerations of the step that is being taken.
pub trait Field {
    /// The number type.
    type Real: Real;
    /// What positions, velocities and accelerations are in.
    type Space: Space<Self::Real>;

    /// Length h of the step, s, above 0.
    fn step(&self) -> Self::Real;

    /// Acceleration by the laws in the state (`x`, `v`) at the fraction `part` of the step; 0 is its start, 1
    /// its end.
    fn laws(&mut self, part: Self::Real, x: Self::Space, v: Self::Space) -> Self::Space;

    /// Acceleration by the applied forces, constant over the step.
    fn applied(&self) -> Self::Space;

    /// Acceleration by everything that acts.
    #[inline(always)]
    fn acceleration(&mut self, part: Self::Real, x: Self::Space, v: Self::Space) -> Self::Space {
        self.laws(part, x, v) + self.applied()
    }

    /// Whether a law depends on the velocity.
    fn depends_on_velocity(&self) -> bool;

    /// Whether a law depends on anything at all; if not, one evaluation serves the whole step.
    fn is_constant(&self) -> bool {
        false
    }

    /// `v` after a step of acceleration `a`; exact damping has its place here in the two Eulers.
    #[inline(always)]
    fn kick(&mut self, v: Self::Space, a: Self::Space) -> Self::Space {
        v + a * self.step()
    }

    /// What the two Eulers do to the velocity before the move.
    #[inline(always)]
    fn before_move(&mut self, v: Self::Space) -> Self::Space {
        v
    }

    /// What the two Eulers do to the velocity after the move.
    #[inline(always)]
    fn after_move(&mut self, v: Self::Space) -> Self::Space {
        v
    }

    /// Acceleration by the laws at the start of the step as it was before, if a law jumps just there.
    #[inline(always)]
    fn laws_before_jump(&mut self, x: Self::Space, v: Self::Space) -> Option<Self::Space> {
        let _ = (x, v);
        None
    }

    /// The velocity v1 of `v1 = v + a(x + v1 h, v1) h`.
    fn implicit_velocity(&mut self, x: Self::Space, v: Self::Space) -> Self::Space;
}

/// A field in which an implicit step is solved by Newton's method; see [`newton_velocity`].
pub trait NewtonField: Field {
    /// The rate c if every law is affine, `a = constant - c v`: then an implicit step has a closed form.
    fn linear_rate(&self) -> Option<Self::Real>;

    /// The d of `(I - h da/dv - h² da/dx) d = residual`, with the derivatives of the laws in the state (`x`,
    /// `v`) at the end of the step.
    fn correction(&mut self, x: Self::Space, v: Self::Space, residual: Self::Space) -> Self::Space;

    /// Largest magnitude among the parts of a velocity or acceleration.
    fn size(&self, v: Self::Space) -> Self::Real;

    /// Takes the account of a solve.
    fn report(&mut self, newton: Newton);
}

/// What a method keeps of a body from one step to the next.
#[derive(Clone, Copy, Debug)]
pub struct Carry<F: Field> {
    /// Length of the last step, s: 0 if there was none, negative if velocities were turned round since.
    pub last_step: F::Real,
    /// Acceleration by the laws at the start of this step, if the last step left it.
    pub start: Option<F::Space>,
}

impl<F: Field> Carry<F> {
    /// Nothing is known of the past.
    #[must_use]
    pub fn new() -> Self {
        Self { last_step: F::Real::ZERO, start: None }
    }
}

impl<F: Field> Default for Carry<F> {
    fn default() -> Self {
        Self::new()
    }
}

/// What a method keeps of a body from one step to the next, by kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Nothing.
    None,
    /// [`Carry::last_step`].
    LastStep,
    /// [`Carry::start`], where no law depends on the velocity.
    LastAcceleration,
}

/// A method of integration. Each is also the marker component of the bodies that use it.
pub trait Integrator: Copy + Default + Send + Sync + 'static {
    /// Its row of the table.
    const METHOD: Method;
    /// What it keeps of a body.
    const MEMORY: Memory = Memory::None;
    /// Whether damping, speed limit and locks are inside its steps, as the tutorial has them, and not around
    /// its ticks.
    const DAMPS_INSIDE: bool = false;

    /// Whether a step iterates until it converges: bodies are then taken one at a time, so that none waits for
    /// another and loses its bits.
    const SOLVES: bool = false;
    /// Whether a step changes positions.
    const MOVES: bool = true;
    /// Whether the position of a step is that before and the velocity after it times the step, and nothing else.
    const MOVES_WITH_NEW_VELOCITY: bool = false;
    /// Whether a step changes velocities by what acts.
    const KICKS: bool = true;
    /// Whether the speed limit and the locks of a body follow the kick within a step (PhysX's order): a velocity along a
    /// locked axis counts towards the limit before it is dropped.
    const LIMITS_AFTER_KICK: bool = false;
    /// Whether time passes: damping and substeps are for methods in which it does.
    const PASSES_TIME: bool = true;
    /// Whether a state is looked at before it is stored. `false` is for measuring what that costs, and for nothing else.
    #[doc(hidden)]
    const CHECKED: bool = true;

    /// The state one step after (`x`, `v`).
    fn step<F: Field>(field: &mut F, x: F::Space, v: F::Space, carry: &mut Carry<F>) -> (F::Space, F::Space);
}

/// Does something with the type of a method.
macro_rules! with_method {
    ($method:expr, $name:ident => $do:expr) => {
        $crate::methods::with_method!(
            @each $method, $name => $do;
            ExplicitEuler SemiImplicitEuler ImplicitEuler PositionVerlet VelocityVerlet
            RungeKutta2Midpoint RungeKutta2Heun RungeKutta4 Yoshida4
        )
    };
    (@each $method:expr, $name:ident => $do:expr; $($each:ident)*) => {
        match $method {
            $($crate::methods::table::Method::$each => {
                type $name = $crate::methods::$each;
                $do
            })*
        }
    };
}
pub(crate) use with_method;
