//! Arrows: velocities in m/s and forces in newtons.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Dormant, PhysicsBody, Transform};
use render::{Frame, Line};

use crate::view::forces::add_to;
use crate::view::stage::Stage;

const VELOCITY_COLOR: [f32; 4] = [0.3, 0.75, 1.0, 1.0];
const ARROW_WIDTH_PX: f32 = 2.5;
const NET_WIDTH_PX: f32 = 5.0;

/// Meters of an arrow per m/s.
const VELOCITY_SCALE: f64 = 0.5;

/// What stands for the sum of all forces on a body.
pub(crate) const NET: &str = "net";

/// A vector at a body, m.
struct Arrow {
    body: Entity,
    vector: DVec3,
    color: [f32; 4],
    width: f32,
}

impl Stage {
    pub(crate) fn add_arrows(&mut self, frame: &mut Frame, eye: DVec3) {
        let mut arrows = Vec::new();
        if self.view.velocity_arrows {
            self.add_velocities(&mut arrows);
        }
        self.view.force_causes.clear();
        if self.view.force_arrows {
            self.add_forces(&mut arrows, eye);
        } else {
            self.view.force_scale = None;
        }
        for Arrow { body, vector, color, width } in arrows {
            if let Some(from) = self.drawn_position(body).filter(|_| vector.is_finite()) {
                let (from, to) = ((from - eye).as_vec3(), (from + vector - eye).as_vec3());
                Line::arrow(&mut frame.lines, from, to, color, width);
            }
        }
    }

    fn movable(&mut self) -> Vec<(Entity, DVec3, DVec3)> {
        let mut bodies =
            self.sim.world.query_filtered::<(Entity, &Transform, &PhysicsBody), Without<Dormant>>();
        let bodies = bodies.iter(&self.sim.world).filter(|(.., body)| body.inverse_mass > 0.0);
        bodies.map(|(entity, transform, body)| (entity, transform.position, body.velocity)).collect()
    }

    fn add_velocities(&mut self, arrows: &mut Vec<Arrow>) {
        arrows.extend(self.movable().into_iter().map(|(body, _, velocity)| {
            let (vector, color) = (velocity * VELOCITY_SCALE, VELOCITY_COLOR);
            Arrow { body, vector, color, width: ARROW_WIDTH_PX }
        }));
    }

    /// The forces on every body, an arrow per cause, and their sum where there are several.
    fn add_forces(&mut self, arrows: &mut Vec<Arrow>, eye: DVec3) {
        let bodies = self.movable();
        let entities: Vec<_> = bodies.iter().map(|(entity, ..)| *entity).collect();
        let mut by_cause = vec![Vec::<(&'static str, DVec3)>::new(); bodies.len()];
        self.each_force(&entities, |place, cause, newtons| {
            add_to(&mut by_cause[place], cause.name(), newtons);
        });
        for forces in &mut by_cause {
            forces.retain(|(_, newtons)| *newtons != DVec3::ZERO);
            if forces.len() > 1 {
                forces.push((NET, forces.iter().map(|(_, newtons)| *newtons).sum()));
            }
        }
        let sizes = bodies.iter().zip(&by_cause).map(|((_, position, _), forces)| {
            let largest = forces.iter().map(|(_, newtons)| newtons.length()).fold(0.0, f64::max);
            (largest, position.distance(eye))
        });
        let finite = sizes.filter(|(newtons, _)| newtons.is_finite());
        let Some((largest, distance)) = finite.max_by(|(a, _), (b, _)| a.total_cmp(b)) else { return };
        let Some(scale) = self.newtons_per_meter(largest, distance) else { return };
        for (body, forces) in entities.into_iter().zip(by_cause) {
            for (name, newtons) in forces {
                if !self.view.force_causes.contains(&name) {
                    self.view.force_causes.push(name);
                }
                let width = if name == NET { NET_WIDTH_PX } else { ARROW_WIDTH_PX };
                arrows.push(Arrow { body, vector: newtons / scale, color: color_of(name), width });
            }
        }
    }
}

/// The color of the arrows of a cause.
pub(crate) fn color_of(cause: &str) -> [f32; 4] {
    let [r, g, b] = match cause {
        NET => [1.0, 1.0, 1.0],
        "gravity" => [0.85, 0.55, 1.0],
        "push" => [1.0, 0.35, 0.2],
        "springs" => [0.45, 0.9, 0.4],
        "drag" => [0.3, 0.85, 0.9],
        "damping" => [0.55, 0.65, 0.95],
        "wells" => [0.95, 0.45, 0.75],
        "mutual_gravity" => [1.0, 0.75, 0.3],
        "thrusts" => [1.0, 0.95, 0.4],
        _ => [1.0, 0.6, 0.75],
    };
    [r, g, b, 1.0]
}
