//! The functions of arrays that run kernels.

use bevy_ecs::prelude::*;

use super::Bare;
use super::of_world::{LawsOf, NotForArrays};
use crate::groups::GroupKernel;
use crate::kernels::Kernel;
use crate::laws::damping::Damping;
use crate::laws::{Gravity, Law};
use crate::methods::table::Method;
use crate::methods::{Synchronize, with_method};

impl Bare {
    /// Copies every body of `world`, with its method (`method` for those without their own), its options, and
    /// everything that acts on and between bodies, for ticks of its [`TimeStep`](crate::TimeStep) from its
    /// clock's time on. Outdated groups of the world are compiled again; otherwise it does not change. Rows
    /// are in the order of [`StableId`](crate::StableId).
    ///
    /// `laws` returns the own laws of a body with [`OwnLaws`](crate::OwnLaws), in their order, and `shared` are the
    /// laws in [`Laws`](crate::Laws). Emitters continue as they are, on or off.
    ///
    /// A body whose velocity is half a step behind, because position Verlet integrated it, is synchronized if
    /// it has another method here, as by [`Bare::set_method`]. The ticks are those of
    /// [`Stepper`](crate::Stepper) to the last bit.
    ///
    /// # Errors
    /// If the world has no time step, or wells that ride on bodies.
    pub fn of_world(
        world: &mut World,
        method: Method,
        laws: LawsOf<'_>,
        shared: Vec<Box<dyn Law>>,
    ) -> Result<Self, NotForArrays> {
        let mut bare = Self::gathered(world, method, laws, shared)?;
        bare.synchronize_where(|method| method != Method::PositionVerlet);
        Ok(bare)
    }

    /// Integrates a tick. Does nothing if the tick has no length.
    pub fn tick(&mut self) {
        if !self.begin_tick() {
            return;
        }
        for group in 0..self.groups.len() {
            let kernel = with_method!(self.method_of_group(group), M => GroupKernel::of::<M>());
            self.tick_group(group, kernel);
        }
        for run in 0..self.individuals.runs.len() {
            let kernel = with_method!(self.method_of_run(run), M => Kernel::of::<M>());
            self.tick_rows(run, kernel);
        }
        self.end_tick();
    }

    /// Drops the method state and synchronizes velocities with positions, so that any method can continue.
    pub fn leave(&mut self) {
        self.synchronize_where(|_| true);
        self.last_steps.clear();
        self.forget_accelerations();
    }

    /// Synchronizes velocities that are half a step behind, for bodies whose method satisfies `which`.
    fn synchronize_where(&mut self, which: impl Fn(Method) -> bool) {
        self.individuals.plan(&self.bodies);
        for group in 0..self.groups.len() {
            if which(self.method_of_group(group))
                && self.is_half_a_step_behind(self.groups[group].members())
            {
                self.tick_group(group, GroupKernel::of::<Synchronize>());
            }
        }
        for run in 0..self.individuals.runs.len() {
            if which(self.method_of_run(run))
                && self.is_half_a_step_behind(self.individuals.runs[run].rows.clone())
            {
                self.tick_rows(run, Kernel::of::<Synchronize>());
            }
        }
        self.has_failed |= !self.refused.is_empty();
    }

    /// Sets the method of every body without its own. Restarts the methods, from synchronized velocities.
    pub fn set_method(&mut self, method: Method) {
        self.leave();
        self.method = method;
    }

    /// Replaces the laws of every body that are [`Laws`](crate::Laws) in a world. Restarts the methods.
    pub fn set_laws(&mut self, laws: Vec<Box<dyn Law>>) {
        // The method state belongs to the old laws.
        self.leave();
        self.resources.laws = laws;
    }

    /// Sets or removes gravity. Restarts the methods.
    pub fn set_gravity(&mut self, gravity: Option<Gravity>) {
        self.leave();
        self.resources.gravity = gravity;
    }

    /// Sets or removes damping. Restarts the methods.
    ///
    /// # Panics
    /// If its rate is below 0.
    pub fn set_damping(&mut self, damping: Option<Damping>) {
        damping.as_ref().map(Damping::check);
        self.leave();
        self.resources.damping = damping;
    }
}
