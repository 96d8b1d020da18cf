//! The methods of integration, each written once.
//!
//! A method is a function from a state to the state one step later. It knows neither the number of bodies nor their
//! layout in memory: it asks a [`Field`] for accelerations and computes in the field's [`Space`], which is a block of
//! bodies in registers, or a single number in a test.
//!
//! Methods change a state only by adding increments to it, so that other numbers in the same register stay unchanged.

pub(crate) mod euler;
mod implicit_euler;
pub(crate) mod markers;
mod runge_kutta;
pub(crate) mod table;
mod verlet;
mod yoshida;

use std::ops::{Add, Mul, Sub};

pub use euler::{ExplicitEuler, SemiImplicitEuler};
pub(crate) use implicit_euler::MOST_HALVINGS;
pub use implicit_euler::{ImplicitEuler, MOST_ITERATIONS, Newton, newton_velocity};
pub use runge_kutta::{RungeKutta2Heun, RungeKutta2Midpoint, RungeKutta4};
pub(crate) use verlet::Synchronize;
pub use verlet::{PositionVerlet, VelocityVerlet};
pub use yoshida::Yoshida4;

use crate::methods::table::Method;

/// The vector space of positions, velocities and accelerations.
pub trait Space: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<X: Copy + Add<Output = X> + Sub<Output = X> + Mul<f64, Output = X>> Space for X {}

/// The accelerations of one step, as a method sees them.
pub trait Field {
    /// The vector space of positions, velocities and accelerations.
    type Space: Space;

    /// Length h of the step, s, above 0.
    fn step(&self) -> f64;

    /// Acceleration by the laws in the state (`x`, `v`) at the fraction `part` of the step: 0 is its start, 1 its end.
    fn laws(&mut self, part: f64, x: Self::Space, v: Self::Space) -> Self::Space;

    /// Acceleration by the applied forces, constant over the step.
    fn applied(&self) -> Self::Space;

    /// Acceleration by laws and applied forces.
    #[inline(always)]
    fn acceleration(&mut self, part: f64, x: Self::Space, v: Self::Space) -> Self::Space {
        let a = self.laws(part, x, v);
        self.plus_applied(a)
    }

    /// The acceleration `a` by the laws plus that by the applied forces.
    #[inline(always)]
    fn plus_applied(&self, a: Self::Space) -> Self::Space {
        a + self.applied()
    }

    /// Whether a law depends on the velocity.
    fn depends_on_velocity(&self) -> bool;

    /// Whether no law depends on the state or the time: one evaluation then serves the whole step.
    fn is_constant(&self) -> bool {
        false
    }

    /// Changes `v` by the acceleration `a` over the step; applies exact damping in explicit and semi-implicit Euler.
    #[inline(always)]
    fn kick(&mut self, v: Self::Space, a: Self::Space) -> Self::Space {
        v + a * self.step()
    }

    /// Applies damping, speed limit and locks before the move, in explicit and semi-implicit Euler.
    #[inline(always)]
    fn before_move(&mut self, v: Self::Space) -> Self::Space {
        v
    }

    /// Applies damping after the move, in explicit and semi-implicit Euler.
    #[inline(always)]
    fn after_move(&mut self, v: Self::Space) -> Self::Space {
        v
    }

    /// Acceleration by the laws just before the start of the step, if a law jumps there.
    #[inline(always)]
    fn laws_before_jump(&mut self, x: Self::Space, v: Self::Space) -> Option<Self::Space> {
        let _ = (x, v);
        None
    }

    /// Solves `v1 = v + a(x + v1 h, v1) h` for the velocity v1.
    fn implicit_velocity(&mut self, x: Self::Space, v: Self::Space) -> Self::Space;
}

/// A field whose implicit steps are solved by Newton's method; see [`newton_velocity`].
pub trait NewtonField: Field {
    /// The rate c, 1/s, if every law is affine, `a = constant - c v`: an implicit step then has a closed form.
    fn linear_rate(&self) -> Option<f64>;

    /// Solves `(I - h da/dv - h² da/dx) d = residual` for d, with the derivatives of the laws in the state (`x`, `v`)
    /// at the end of the step.
    fn correction(&mut self, x: Self::Space, v: Self::Space, residual: Self::Space) -> Self::Space;

    /// Largest magnitude among the components of a velocity or acceleration.
    fn size(&self, v: Self::Space) -> f64;

    /// Records the result of a solve.
    fn report(&mut self, newton: Newton);
}

/// The method state of one step: what a method keeps of a body from one step to the next.
#[derive(Clone, Copy, Debug)]
pub struct StepState<F: Field> {
    /// Length of the last step, s: 0 if there was none, negative if velocities were reversed since.
    pub last_step: f64,
    /// Cached acceleration by the laws at the start of this step, if the last step computed it.
    pub start: Option<F::Space>,
}

impl<F: Field> Default for StepState<F> {
    /// The method state at a start, without a last step.
    fn default() -> Self {
        Self { last_step: 0.0, start: None }
    }
}

/// The kind of method state that a method has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
pub enum MethodStateKind {
    /// Nothing.
    None,
    /// [`StepState::last_step`].
    LastStep,
    /// [`StepState::start`], where no law depends on the velocity.
    LastAcceleration,
}

/// A method of integration. Each of this crate is also the marker component of the bodies that use it.
pub trait Integrator: Copy + Default + Send + Sync + 'static {
    /// Its row of the table of methods. A method of another crate names the row that it is most like; see
    /// [`Stepper::of`](crate::Stepper::of).
    const METHOD: Method;
    /// The kind of its method state.
    const STATE: MethodStateKind = MethodStateKind::None;
    /// Whether damping, speed limit and locks are part of each step, as in the tutorial, and not applied around each
    /// tick.
    const DAMPS_INSIDE: bool = false;

    /// Whether a step iterates until it converges. Bodies are then integrated one at a time, so that the bits of one do
    /// not depend on the iterations of another.
    const SOLVES: bool = false;
    /// Whether a step changes positions.
    const MOVES: bool = true;
    /// Whether the new position is exactly the old one plus the new velocity times the step.
    const MOVES_WITH_NEW_VELOCITY: bool = false;
    /// Whether a step changes velocities by forces and laws.
    const KICKS: bool = true;
    /// Whether speed limit and locks follow the kick within a step (PhysX's order): the velocity along a locked axis
    /// counts toward the limit before it is dropped.
    const LIMITS_AFTER_KICK: bool = false;
    /// Whether a step passes time. Damping and substeps apply only if it does.
    const PASSES_TIME: bool = true;
    /// Whether a new state is checked before it is stored. `false` is only for measuring what the check costs.
    #[doc(hidden)]
    const CHECKED: bool = true;

    /// Returns the state one step after (`x`, `v`).
    fn step<F: Field>(
        field: &mut F,
        x: F::Space,
        v: F::Space,
        step_state: &mut StepState<F>,
    ) -> (F::Space, F::Space);
}

/// Evaluates an expression with the type of a method; `@table` makes the enum and the table of claims. Contains the list of methods,
/// against which the compiler checks the colors.
macro_rules! with_method {
    ($method:expr, $name:ident => $do:expr) => {
        $crate::methods::with_method! { @list @each $method, $name => $do; }
    };
    (@list $($then:tt)*) => {
        $crate::methods::with_method! {
            $($then)*
            ExplicitEuler SemiImplicitEuler ImplicitEuler PositionVerlet VelocityVerlet
            RungeKutta2Midpoint RungeKutta2Heun RungeKutta4 Yoshida4
        }
    };
    (@table) => {
        $crate::methods::with_method! { @list @tabulate }
    };
    (@tabulate $($each:ident)*) => {
        /// A method of integration.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[cfg_attr(not(feature = "exhaustive"), non_exhaustive)]
        pub enum Method {
            $(#[doc = concat!("The method [`", stringify!($each), "`](crate::methods::", stringify!($each), ").")]
            $each,)*
        }

        /// One row per method, in the order of [`Method`].
        pub const METHODS: &[Claims] = &[$($crate::methods::$each::CLAIMS),*];
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

/// The constants of an [`Integrator`] as values, for code that is the same for all methods.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Traits {
    pub method: Method,
    pub state: MethodStateKind,
    pub damps_inside: bool,
    pub moves: bool,
    pub kicks: bool,
    pub limits_after_kick: bool,
    pub passes_time: bool,
}

impl Traits {
    /// The constants of `M`.
    pub const fn of<M: Integrator>() -> Self {
        Self {
            method: M::METHOD,
            state: M::STATE,
            damps_inside: M::DAMPS_INSIDE,
            moves: M::MOVES,
            kicks: M::KICKS,
            limits_after_kick: M::LIMITS_AFTER_KICK,
            passes_time: M::PASSES_TIME,
        }
    }
}

impl Method {
    /// The constants of the method.
    pub(crate) const fn traits(self) -> Traits {
        with_method!(self, M => Traits::of::<M>())
    }
}
