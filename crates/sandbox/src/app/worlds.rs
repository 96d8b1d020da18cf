//! The worlds of a session: built, built anew, and handed over to another scene.

use std::collections::HashMap;
use std::num::NonZero;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use history::{EffectsState, Simulation};
use motion::clock::StepClock;
use motion::{Evaluations, PhysicsBody, PreviousPosition, Threads, TimeStep, Transform};
use pick::{SoftTargets, Targets};
use scene::Scene;

use crate::app::session::{Options, Session};
use crate::app::ui::Panel;
use crate::view::trails::Trails;

impl Session {
    /// Builds the world anew; camera, gravity, damping, what is switched off and click force stay, the selection does
    /// not.
    pub(crate) fn reset_world(&mut self) {
        // Gravity and damping may have been asked for in this very frame.
        self.carry_out_requests();
        let method = self.sim.method();
        let step = *self.sim.world.resource::<TimeStep>();
        let mut next = build(Arc::clone(&self.sim.scene), self.options);
        self.hand_over(&mut next.world);
        next.world.insert_resource(step);
        EffectsState::of(&mut self.sim.world).put(&mut next.world);
        self.sim = next;
        self.ids = ids_of(&self.sim.bodies);
        self.sim.stepper.recompile(&mut self.sim.world);
        if method != self.sim.method() {
            self.sim.set_method(method);
        }
        self.control.selection = None;
        self.control.locked = None;
        self.forget_ahead();
        (self.quarantined_before, self.records_seen) = (self.quarantined.len(), 0);
        self.targets = Targets::default();
        self.soft = SoftTargets::default();
        self.targets_current = false;
        self.trails = Trails::default();
        self.acting.clear();
        self.shown_forecast = None;
        self.ui.retract_run();
        self.count_unconverged_from_now();
        self.clock.set_pace(1.0).expect("1 is positive and finite");
        self.restart_ghosts();
        self.restart_recording();
    }

    /// Goes on with another scene; window size and panels stay.
    pub fn open(&mut self, scene: Scene) {
        let mut next = Self::new(scene, Options { paused: false, ..self.options });
        std::mem::swap(&mut next.ui, &mut self.ui);
        next.ui.retract_run();
        next.ui.close(Panel::Ghosts);
        next.clock.start_at(self.clock.now());
        next.measured = self.measured;
        next.player = self.player.take();
        next.control.mode = self.control.mode;
        next.control.pointer = self.control.pointer;
        self.forget_ahead();
        (next.frames, next.quarantined) = (self.frames, std::mem::take(&mut self.quarantined));
        next.quarantined_before = next.quarantined.len();
        self.hand_over(&mut next.sim.world);
        next.count_effects_from_now();
        next.count_unconverged_from_now();
        next.ticks_left = self.ticks_left;
        next.dropped = self.dropped;
        next.ledger_asked = self.ledger_asked;
        next.open_or_close_ledger();
        next.recording = self.recording;
        next.restart_recording();
        *self = next;
    }

    /// Lets another world go on with the time and the counts of this one: it is the same run.
    fn hand_over(&mut self, world: &mut World) {
        let mut clock = *self.sim.world.resource::<StepClock>();
        clock.begin_scene();
        world.insert_resource(clock);
        world.insert_resource(std::mem::take(&mut *self.sim.world.resource_mut::<Evaluations>()));
    }
}

pub(crate) fn ids_of(entities: &[Entity]) -> HashMap<Entity, u32> {
    (0..).zip(entities).map(|(id, entity)| (*entity, id)).collect()
}

/// Lets threads share a large world.
pub(crate) fn share_among_threads(world: &mut World, bodies: usize, options: Options) {
    if bodies >= Threads::FROM {
        let usual = || std::thread::available_parallelism().map_or(1, NonZero::get);
        world.insert_resource(Threads::new(options.threads.unwrap_or_else(usual)));
    }
}

/// The start of `scene`, as `options` want it.
pub(crate) fn build(scene: impl Into<Arc<Scene>>, options: Options) -> Simulation {
    Simulation::prepared(scene, |world, bodies| {
        share_among_threads(world, bodies.len(), options);
        if options.interpolate {
            draw_between_ticks(world);
        }
    })
}

/// Lets movable bodies be drawn between two ticks.
pub(crate) fn draw_between_ticks(world: &mut World) {
    let movable: Vec<_> = world
        .query_filtered::<(Entity, &Transform, &PhysicsBody), Without<PreviousPosition>>()
        .iter(world)
        .filter(|(_, _, body)| body.inverse_mass > 0.0)
        .map(|(entity, transform, _)| (entity, PreviousPosition(transform.position)))
        .collect();
    world.insert_batch(movable);
}
