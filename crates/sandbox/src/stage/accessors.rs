//! Accessors of a stage: clocks, counts, names, settings, orders.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;

use bevy_ecs::prelude::*;
use history::Simulation;
use lab::cost::Setting;
use motion::clock::StepClock;
use motion::{Method, PhysicsBody, Quarantined, TimeStep};

use crate::stage::query;
use crate::stage::soft::soft_name;
use crate::stage::{Order, Stage};

impl Stage {
    /// The simulation.
    #[must_use]
    pub const fn sim(&self) -> &Simulation {
        &self.sim
    }

    /// The simulation, for queries and observers that need it mutable. Change its motion only through [`Self::change`]: other
    /// changes are not recorded.
    pub const fn sim_mut(&mut self) -> &mut Simulation {
        &mut self.sim
    }

    /// The selected thing.
    #[must_use]
    pub const fn selection(&self) -> Option<Entity> {
        self.here.selection
    }

    /// Number of frames so far.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.run.frames
    }

    /// Simulated time, s. A reset of the world does not restart it.
    #[must_use]
    pub fn simulated(&self) -> f64 {
        self.sim.world.resource::<StepClock>().seconds()
    }

    /// The time at which bodies are drawn, between the last two ticks, s.
    pub(crate) fn drawn_at(&self) -> f64 {
        self.simulated() - (1.0 - self.here.alpha) * self.sim.world.resource::<TimeStep>().0
    }

    /// Time dropped in hitches, s.
    #[must_use]
    pub const fn dropped(&self) -> f64 {
        self.run.dropped
    }

    /// Number of bodies that forces move, per method, in the order of [`motion::METHODS`].
    pub fn methods(&self) -> Vec<(Method, usize)> {
        let scene = self.sim.method();
        let mut bodies = query::<(EntityRef, &PhysicsBody), Without<Quarantined>>(&self.sim.world);
        let mut counts = BTreeMap::new();
        for (entity, _) in bodies.iter(&self.sim.world).filter(|(_, body)| body.inverse_mass > 0.0)
        {
            *counts.entry(motion::own_method(entity).unwrap_or(scene)).or_default() += 1;
        }
        counts.into_iter().collect()
    }

    /// All things of the scene that were not removed, in stable-id order.
    pub fn things(&self) -> impl Iterator<Item = Entity> + '_ {
        self.sim.bodies.iter().copied().filter(|thing| self.sim.world.get_entity(*thing).is_ok())
    }

    /// Ticks per second.
    #[must_use]
    pub const fn step_hz(&self) -> f64 {
        self.clock.rate()
    }

    /// Name of a thing of the scene, or of a soft body.
    #[must_use]
    pub fn name(&self, thing: Entity) -> String {
        let name =
            self.sim.id(thing).and_then(|id| self.sim.scene.names.get(id)).map(Cow::into_owned);
        name.or_else(|| soft_name(&self.sim, thing)).unwrap_or_else(|| format!("{thing}"))
    }

    /// Method and substeps of bodies without their own setting.
    #[must_use]
    pub fn setting(&self) -> Setting {
        Setting { method: self.sim.method(), substeps: self.sim.substeps() }
    }

    /// Takes the orders of this frame, for the program to carry out.
    pub fn take_orders(&mut self) -> Vec<Order> {
        std::mem::take(&mut self.orders)
    }

    /// Scene files that were opened or saved, the newest last.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.run.files
    }

    /// Remembers scene files of earlier windows, the newest last.
    pub fn remember_files(&mut self, mut files: Vec<PathBuf>) {
        files.append(&mut self.run.files);
        files.iter().for_each(|file| self.run.note_file(file));
    }

    /// Simulated time plus the elapsed part of the next tick, s.
    pub(crate) fn progress(&self) -> f64 {
        self.simulated() + self.clock.fraction() / self.clock.rate()
    }

    /// Whether the stage is paused.
    #[must_use]
    pub const fn paused(&self) -> bool {
        self.paused
    }
}
