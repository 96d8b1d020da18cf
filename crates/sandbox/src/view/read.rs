//! What there is to know about a session.

use std::borrow::Cow;
use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use history::Simulation;
use motion::clock::StepClock;
use motion::{Evaluations, Method, PhysicsBody, Quarantine, Quarantined, Stepper};
use scene::Scene;

use crate::app::control::Mode;
use crate::app::session::{QuarantinedBody, Session};
use crate::view::camera::Camera;

impl Session {
    /// What runs.
    #[must_use]
    pub const fn simulation(&self) -> &Simulation {
        &self.sim
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.sim.scene
    }

    /// The world, to look at.
    #[must_use]
    pub const fn world(&self) -> &World {
        &self.sim.world
    }

    /// The world, for queries, which need it mutable; input and scripts never write it.
    pub const fn world_mut(&mut self) -> &mut World {
        &mut self.sim.world
    }

    /// The compiled step.
    #[must_use]
    pub const fn stepper(&self) -> &Stepper {
        &self.sim.stepper
    }

    /// Camera or selection mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.control.mode
    }

    /// The camera.
    #[must_use]
    pub const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The selected thing.
    #[must_use]
    pub const fn selection(&self) -> Option<Entity> {
        self.control.selection
    }

    /// Newtons of a click.
    #[must_use]
    pub const fn click_force(&self) -> f64 {
        self.control.click_force
    }

    /// Size of the picture, pixels.
    #[must_use]
    pub const fn size_px(&self) -> [u32; 2] {
        self.options.size_px
    }

    /// Ticks simulated, over every reset of the world.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.sim.ticks()
    }

    /// Frames so far.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Simulated time, s; it goes on over a reset of the world.
    #[must_use]
    pub fn simulated(&self) -> f64 {
        self.sim.world.resource::<StepClock>().seconds()
    }

    /// Time dropped in hitches, s.
    #[must_use]
    pub const fn dropped(&self) -> f64 {
        self.dropped
    }

    /// Whether the last frame dropped time.
    pub(crate) fn drops_time(&self) -> bool {
        self.dropped_lately > 0.0
    }

    /// How often laws were evaluated so far, and what solvers did.
    #[must_use]
    pub fn evaluations(&self) -> &Evaluations {
        self.sim.world.resource::<Evaluations>()
    }

    /// Bodies that forces move, by the method that moves them, in the order of [`motion::METHODS`].
    pub fn methods(&mut self) -> Vec<(Method, usize)> {
        let scene = self.sim.method();
        let mut bodies = self.sim.world.query_filtered::<(EntityRef, &PhysicsBody), Without<Quarantined>>();
        let mut counts = BTreeMap::new();
        for (entity, _) in bodies.iter(&self.sim.world).filter(|(_, body)| body.inverse_mass > 0.0) {
            *counts.entry(motion::own_method(entity).unwrap_or(scene)).or_default() += 1;
        }
        counts.into_iter().collect()
    }

    /// Every body that was quarantined in the run up to now, in earlier scenes and before a reset too, in that order.
    #[must_use]
    pub fn quarantined(&self) -> &[QuarantinedBody] {
        &self.quarantined[..self.quarantined_end()]
    }

    /// The same with those that the run has gone back before, and whose ticks it has not dropped.
    #[must_use]
    pub fn all_quarantined(&self) -> &[QuarantinedBody] {
        &self.quarantined
    }

    /// Why `body` is frozen, in a few words.
    pub(crate) fn frozen_because(&self, body: Entity) -> Option<String> {
        let records = self.sim.world.resource::<Quarantine>().records();
        let record = records.iter().find(|record| record.body == body)?;
        Some(format!("in tick {} by {}", record.tick, record.cause.system))
    }

    /// Those of this world.
    pub(crate) fn frozen(&self) -> &[QuarantinedBody] {
        &self.quarantined[self.quarantined_before..self.quarantined_end()]
    }

    fn quarantined_end(&self) -> usize {
        let frozen = self.sim.world.resource::<Quarantine>().records().len();
        (self.quarantined_before + frozen).min(self.quarantined.len())
    }

    /// The body of that name, if there is one and it was not removed.
    #[must_use]
    pub fn body(&self, name: &str) -> Option<Entity> {
        self.sim.named(name)
    }

    /// Every thing of the scene that was not removed, in stable-id order.
    pub fn things(&self) -> impl Iterator<Item = Entity> + '_ {
        self.sim.bodies.iter().copied().filter(|thing| self.sim.world.get_entity(*thing).is_ok())
    }

    /// Ticks a second.
    #[must_use]
    pub const fn step_hz(&self) -> f64 {
        self.clock.rate()
    }

    /// Name of a thing of the scene, or of a soft body.
    #[must_use]
    pub fn name(&self, thing: Entity) -> String {
        let name = self.ids.get(&thing).and_then(|id| self.sim.scene.names.get(*id)).map(Cow::into_owned);
        name.or_else(|| self.soft_name(thing)).unwrap_or_else(|| format!("{thing}"))
    }

    /// Whether it is paused.
    #[must_use]
    pub const fn paused(&self) -> bool {
        self.control.paused
    }
}
