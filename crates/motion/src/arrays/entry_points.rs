//! What runs kernels: not generic, so that they are compiled here, optimised as this crate is.

use bevy_ecs::prelude::*;

use super::of_world::{LawsOf, NotForArrays};
use super::tick::{Compensating, Plainly};
use super::{Bare, Residues};
use crate::laws::damping::Damping;
use crate::laws::{Gravity, Law};
use crate::methods::table::Method;
use crate::methods::{Synchronize, with_method};

macro_rules! entry_points {
    ($($t:ty)*) => {$(
        impl Bare<$t> {
            /// Takes every body of `world` in, with its method, `method` for those that have none of their own, its
            /// substeps, laws, damping, speed limit and locks, and everything that acts on them and between them,
            /// in ticks of its [`TimeStep`](crate::TimeStep) from its clock's time on. Groups are made anew in the
            /// world if it is time to; otherwise it stays as it is. Rows are in the order of [`StableId`](crate::StableId).
            ///
            /// Boxed laws are of one precision: `laws` gives those of a body that has [`OwnLaws`](crate::OwnLaws),
            /// in their order, and `shared` are those of [`Laws`](crate::Laws). Emitters go on as they were: on or off.
            ///
            /// A body that a tick of the world would find half a step behind, because it was integrated by position
            /// Verlet, goes on with whatever method it has here as [`Bare::set_method`] says. In f64 the ticks
            /// are those of [`Stepper`](crate::Stepper) to the last bit.
            ///
            /// # Errors
            /// Where there is no time step.
            pub fn of_world(
                world: &mut World,
                method: Method,
                laws: LawsOf<'_, $t>,
                shared: Vec<Box<dyn Law<$t>>>,
            ) -> Result<Self, NotForArrays> {
                let mut bare = Self::gathered(world, method, laws, shared)?;
                bare.leave_foreign_methods();
                Ok(bare)
            }

            /// Integrates a tick. A tick of no length is none.
            pub fn tick(&mut self) {
                if !self.begin_tick() {
                    return;
                }
                for group in 0..self.groups.len() {
                    with_method!(self.method_of_group(group), M => self.tick_group::<M>(group));
                }
                for run in 0..self.individuals.runs.len() {
                    self.tick_run(run);
                }
                self.end_tick();
            }

            /// Forgets what the methods keep, with velocities that any other can start from: those of the
            /// positions' own time.
            pub fn leave(&mut self) {
                self.leave_those(|_| true);
                self.last_steps.clear();
                self.forget_accelerations();
            }

            /// Gives velocities that are half a step behind their time to bodies of other methods than position
            /// Verlet.
            fn leave_foreign_methods(&mut self) {
                self.leave_those(|method| method != Method::PositionVerlet);
            }

            /// Brings the velocities of those of some methods to the time of their positions.
            fn leave_those(&mut self, which: impl Fn(Method) -> bool) {
                self.individuals.plan(&self.bodies);
                for group in 0..self.groups.len() {
                    if which(self.method_of_group(group)) && self.is_half_a_step_behind(self.groups[group].members()) {
                        self.tick_group::<Synchronize>(group);
                    }
                }
                for run in 0..self.individuals.runs.len() {
                    if which(self.method_of_run(run)) && self.is_half_a_step_behind(self.individuals.runs[run].rows.clone()) {
                        self.tick_rows::<Synchronize, Plainly>(run);
                    }
                }
                self.has_failed |= !self.refused.is_empty();
            }

            /// Changes the method of every body that has none of its own: what the old one kept is turned into
            /// what the new one starts from.
            pub fn set_method(&mut self, method: Method) {
                self.leave();
                self.method = method;
            }

            /// Replaces the laws of every body that have no resource of their own in a world.
            pub fn set_laws(&mut self, laws: Vec<Box<dyn Law<$t>>>) {
                // What was kept was kept under the old ones.
                self.leave();
                self.resources.laws = laws;
            }

            /// Changes gravity, switches it on or off, or takes it away; bodies of position Verlet start anew.
            pub fn set_gravity(&mut self, gravity: Option<Gravity>) {
                self.leave();
                self.resources.gravity = gravity;
            }

            /// Changes damping or takes it away; bodies of position Verlet start anew.
            pub fn set_damping(&mut self, damping: Option<Damping>) {
                self.leave();
                self.resources.damping = damping;
            }
        }
    )*};
}

entry_points!(f64 f32);

impl Bare<f64> {
    fn tick_run(&mut self, run: usize) {
        with_method!(self.method_of_run(run), M => self.tick_rows::<M, Plainly>(run));
    }
}

impl Bare<f32> {
    /// With compensated sums: every body's position and velocity has a residue, what rounding left out of it, which is
    /// added with the next increment (Kahan 1965). What acts is evaluated at the sums, in single precision.
    #[must_use]
    pub fn compensated(mut self) -> Self {
        let zero = vec![[0.0; 3]; self.bodies.len()];
        self.residues = Some(Residues { x: zero.clone(), v: zero });
        self
    }

    fn tick_run(&mut self, run: usize) {
        if self.residues.is_some() {
            with_method!(self.method_of_run(run), M => self.tick_rows::<M, Compensating>(run));
        } else {
            with_method!(self.method_of_run(run), M => self.tick_rows::<M, Plainly>(run));
        }
    }
}
