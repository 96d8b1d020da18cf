//! Accessors of a stage.

use bevy_ecs::prelude::*;
use history::{Change, Simulation};
use lab::cost::Setting;
use motion::effects::Effect;
use motion::{Push, TimeStep};
use scene::StepKind;

use crate::input::SwitchedBy;
use crate::stage::options::Options;
use crate::stage::playback::Playback;
use crate::stage::pull::Pull;
use crate::stage::quarantines::Quarantines;
use crate::stage::recorder::Recorder;
use crate::stage::timeline::Times;
use crate::stage::{Order, PerWorld, Stage, things};

impl Stage {
    /// The simulation.
    #[must_use]
    pub const fn sim(&self) -> &Simulation {
        &self.sim
    }

    /// The world, for programs with their own entities in it. Changes made through it are not recorded: use [`Self::change`].
    pub const fn world_mut(&mut self) -> &mut World {
        &mut self.sim.world
    }

    /// The simulation.
    #[cfg(test)]
    pub(crate) const fn sim_mut(&mut self) -> &mut Simulation {
        &mut self.sim
    }

    /// Sets the length of the next tick, s, if the scene steps by frames.
    pub(crate) fn expect_frame(&mut self, length: f64) {
        if self.sim.scene.step == StepKind::Frame {
            self.sim.world.insert_resource(TimeStep(length));
        }
    }

    /// What is replaced with the world.
    pub const fn here(&self) -> &PerWorld {
        &self.here
    }

    /// Pause, pace and single ticks.
    #[must_use]
    pub const fn playback(&self) -> &Playback {
        &self.playback
    }

    /// Pause, pace and single ticks.
    pub const fn playback_mut(&mut self) -> &mut Playback {
        &mut self.playback
    }

    /// The last minute and its faults.
    #[must_use]
    pub const fn recorder(&self) -> &Recorder {
        &self.recorder
    }

    /// The bodies that were quarantined.
    #[must_use]
    pub const fn quarantines(&self) -> &Quarantines {
        &self.quarantines
    }

    /// The options of the session.
    pub const fn options(&self) -> &Options {
        &self.options
    }

    /// The source of the last change of `effect`, if it was changed.
    pub(crate) fn switched_by(&self, effect: Effect) -> Option<SwitchedBy> {
        self.switched.get(&effect).copied()
    }

    /// The selected thing.
    #[must_use]
    pub const fn selection(&self) -> Option<Entity> {
        self.here.selection
    }

    /// Selects a thing, or nothing.
    pub const fn select(&mut self, thing: Option<Entity>) {
        self.here.selection = thing;
    }

    /// Name of a thing of the scene, or of a soft body.
    #[must_use]
    pub fn name(&self, thing: Entity) -> String {
        things::name(&self.sim, thing)
    }

    /// Method and substeps of bodies without their own setting.
    #[must_use]
    pub fn setting(&self) -> Setting {
        Setting { method: self.sim.method(), substeps: self.sim.substeps() }
    }

    /// The scene times at the ends of recorded ticks and now.
    pub(crate) fn times(&self) -> Times {
        self.recorder.times(&self.sim)
    }

    /// Begins or ends a pull of the pointer.
    pub(crate) fn set_pull(&mut self, pull: Option<Pull>) {
        self.here.interventions += u64::from(pull.is_some());
        self.here.pull = pull;
    }

    /// The pull of the pointer, if any.
    pub(crate) const fn pull_mut(&mut self) -> Option<&mut Pull> {
        self.here.pull.as_mut()
    }

    /// Sets the pushes of held keys, N, which are applied in every tick.
    pub(crate) fn hold(&mut self, held: Vec<Push>) {
        self.here.interventions += u64::from(self.held.is_empty() && !held.is_empty());
        self.held = held;
    }

    /// Takes the changes that were made since the last call.
    pub(crate) fn take_changes(&mut self) -> Vec<Change> {
        std::mem::take(&mut self.here.untold)
    }

    /// Takes the orders of this frame, for the program to carry out.
    pub fn take_orders(&mut self) -> Vec<Order> {
        std::mem::take(&mut self.orders)
    }
}
