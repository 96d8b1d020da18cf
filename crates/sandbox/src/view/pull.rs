//! A body pulled by the pointer: a damped spring from where it was taken to where the pointer is.
//!
//! The force is a push of every tick, so it is recorded, repeated and kept in the ledger as any push is.

use bevy_ecs::prelude::*;
use egui::{Align2, FontId, Painter, Pos2};
use glam::{DVec2, DVec3};
use motion::{PhysicsBody, PushQueue, SoftBody, TimeStep, Transform};
use render::{Frame, Line};

use crate::view::hud::{THIN, text};
use crate::view::soft::mass;
use crate::view::stage::Stage;

/// Angular frequency of the spring, 1/s: what is pulled follows within half a second.
const FREQUENCY: f64 = 8.0;

/// Largest part of a radian that the spring turns a light point in one tick, for every method to stay stable.
const PER_TICK: f64 = 0.4;

/// Most force, in weights of what is pulled on Earth.
const WEIGHTS: f64 = 30.0;

/// The acceleration of a weight, m/s².
const EARTH: f64 = 9.8;

const COLOR: [f32; 4] = [1.0, 0.8, 0.2, 1.0];

/// What the pointer holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pull {
    /// The body, or a point of a soft body.
    pub body: Entity,
    /// Mass of all that comes with it, kg.
    mass: f64,
    /// From the body's middle to where it was taken, m.
    offset: DVec3,
    /// How far in front of the camera it was taken, m.
    depth: f64,
    /// The force of the last tick, N, and whether there would be more without a limit.
    newtons: f64,
    limited: bool,
}

impl Stage {
    /// Takes the movable thing under the pointer; `None` if there is none.
    pub(crate) fn take(&mut self) -> Option<Pull> {
        let ray = self.picking_ray();
        let hit = self.cast(&ray)?;
        let body = hit.pushed?;
        let state = self.sim.world.get::<PhysicsBody>(body).filter(|state| state.inverse_mass > 0.0)?;
        let soft = self.sim.world.get::<SoftBody>(hit.entity).map(|soft| mass(&self.sim.world, soft));
        let place = ray.at(hit.distance);
        let depth = (place - self.view.camera.position).dot(self.viewpoint().forward());
        let (mass, offset) = (soft.unwrap_or(state.mass()), place - self.drawn_position(body)?);
        Some(Pull { body, mass, offset, depth, newtons: 0.0, limited: false })
    }

    /// Where the pulled thing was taken and where the pointer wants that, m.
    fn pulled_between(&self, pull: &Pull, middle: DVec3) -> [DVec3; 2] {
        let ray = self.picking_ray();
        let along = ray.direction().dot(self.viewpoint().forward());
        [middle + pull.offset, ray.at(pull.depth / along)]
    }

    /// Queues the force of the coming tick.
    pub(crate) fn pull(&mut self) {
        let Some(mut pull) = self.seen.pull else { return };
        let world = &self.sim.world;
        let (Some(place), Some(state)) =
            (world.get::<Transform>(pull.body), world.get::<PhysicsBody>(pull.body))
        else {
            self.seen.pull = None;
            return;
        };
        let (mass, step) = (state.mass(), world.resource::<TimeStep>().0);
        // Critically damped for all that comes with it; no stiffer than a light point stands.
        let stiffness = (pull.mass * FREQUENCY.powi(2)).min(mass * (PER_TICK / step).powi(2));
        let damping = 2.0 * (stiffness * mass).sqrt();
        let [taken, wanted] = self.pulled_between(&pull, place.position);
        let force = (wanted - taken) * stiffness - state.velocity * damping;
        let most = WEIGHTS * pull.mass * EARTH;
        let newtons = force.clamp_length_max(most);
        (pull.newtons, pull.limited) = (newtons.length(), newtons != force);
        self.seen.pull = Some(pull);
        if newtons.is_finite() {
            self.sim.world.resource_mut::<PushQueue>().push_once(pull.body, newtons);
        }
    }

    /// Draws the spring.
    pub(crate) fn add_pull(&self, frame: &mut Frame, eye: DVec3) {
        let Some(pull) = &self.seen.pull else { return };
        let Some(middle) = self.drawn_position(pull.body) else { return };
        let [taken, wanted] = self.pulled_between(pull, middle).map(|place| (place - eye).as_vec3());
        Line::arrow(&mut frame.lines, taken, wanted, COLOR, 3.0);
    }

    /// Writes the force beside the pointer.
    pub(crate) fn write_pull(&self, painter: &Painter) {
        let Some(pull) = &self.seen.pull else { return };
        let limit = if pull.limited { ", the most" } else { "" };
        let words = format!("{} N{limit}", report::numbers::digits(pull.newtons));
        let DVec2 { x, y } = self.view.pointer;
        #[expect(clippy::cast_possible_truncation, reason = "pixels")]
        let at = Pos2::new(x as f32, y as f32) / painter.ctx().pixels_per_point();
        let font = FontId::proportional(15.0);
        text(painter, at + egui::Vec2::new(14.0, -10.0), Align2::LEFT_BOTTOM, &words, font, THIN);
    }
}
