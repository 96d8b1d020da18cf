//! Rings where bodies pass through the ground; they spread and fade.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Dormant, PhysicsBody, PreviousPosition, Transform};
use pick::Shape;
use render::{Frame, Line};

use crate::stage::Stage;
use crate::view::View;

/// How long a ring is shown, s of simulated time.
const SHOWN_S: f64 = 1.5;

/// Radius of a ring at its end, as a multiple of the radius of its body.
const SPREADS: f64 = 2.0;

/// Greatest number of rings at once: those of the last bodies.
const MOST: usize = 100;

const SEGMENTS: u32 = 32;
const COLOR: [f32; 3] = [0.16, 0.24, 0.34];
const WIDTH_PX: f32 = 2.5;

/// A pass of a body through the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pass {
    at: DVec3,
    /// Radius of the body, m.
    radius: f64,
    /// Time of the pass, s of simulated time.
    time: f64,
}

/// The last passes.
#[derive(Debug, Default)]
pub(super) struct Passes(VecDeque<Pass>);

impl Passes {
    /// Notes the bodies that passed the height of the ground, m, in the tick of `tick` seconds that ended at `time`, s.
    pub fn after_tick(&mut self, world: &World, ground: f64, time: f64, tick: f64) {
        // After going back in time, later passes have not happened.
        self.0.retain(|pass| pass.time < time);
        let mut bodies = world
            .try_query_filtered::<(&Transform, &PreviousPosition, &Shape), (With<PhysicsBody>, Without<Dormant>)>();
        for (Transform { position: to, .. }, PreviousPosition(from), shape) in
            bodies.iter_mut().flat_map(|bodies| bodies.iter(world))
        {
            if (from.y < ground) != (to.y < ground) {
                let part = (ground - from.y) / (to.y - from.y);
                let at = from.lerp(*to, part).with_y(ground);
                let radius = shape.half_extents().with_y(0.0).length() / 2.0_f64.sqrt();
                self.0.push_back(Pass { at, radius, time: time - tick * (1.0 - part) });
            }
        }
        let surplus = self.0.len().saturating_sub(MOST);
        self.0.drain(..surplus);
    }
}

impl View {
    pub(super) fn add_passes(&self, stage: &Stage, frame: &mut Frame) {
        let drawn_at = stage.here().drawn_at(stage.sim());
        for Pass { at, radius, time } in frame.ground.iter().flat_map(|_| &self.passes.0) {
            let age = (drawn_at - time) / SHOWN_S;
            if !(0.0..1.0).contains(&age) {
                continue;
            }
            let radius = radius * (1.0 + (SPREADS - 1.0) * age);
            let place = |number: u32| {
                let (sin, cos) = (TAU * f64::from(number) / f64::from(SEGMENTS)).sin_cos();
                (*at + DVec3::new(cos, 0.0, sin) * radius - self.camera.position).as_vec3()
            };
            let [r, g, b] = COLOR;
            #[expect(clippy::cast_possible_truncation, reason = "a color")]
            let color = [r, g, b, (1.0 - age) as f32];
            let ring = (0..SEGMENTS).map(|k| Line::new(place(k), place(k + 1), color, WIDTH_PX));
            frame.lines.extend(ring);
        }
    }
}
