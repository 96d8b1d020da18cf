//! Arrows: velocities in m/s and forces in newtons.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Dormant, ForceCause, PhysicsBody, Transform};
use render::{Frame, Line};

use crate::view::stage::Stage;

const VELOCITY_COLOR: [f32; 4] = [0.3, 0.75, 1.0, 1.0];
const FORCE_COLOR: [f32; 4] = [1.0, 0.35, 0.2, 1.0];
const WEIGHT_COLOR: [f32; 4] = [0.85, 0.55, 1.0, 1.0];
const ARROW_WIDTH_PX: f32 = 2.5;

/// Meters of an arrow per m/s.
const VELOCITY_SCALE: f64 = 0.5;

impl Stage {
    pub(crate) fn add_arrows(&mut self, frame: &mut Frame, eye: DVec3) {
        let mut arrows = Vec::new();
        if self.view.velocity_arrows {
            self.add_velocities(&mut arrows);
        }
        if self.view.force_arrows {
            self.add_forces(&mut arrows, eye);
        } else {
            self.view.force_scale = None;
        }
        for (body, vector, color) in arrows {
            if let Some(from) = self.drawn_position(body).filter(|_| vector.is_finite()) {
                let (from, to) = ((from - eye).as_vec3(), (from + vector - eye).as_vec3());
                Line::arrow(&mut frame.lines, from, to, color, ARROW_WIDTH_PX);
            }
        }
    }

    fn movable(&mut self) -> Vec<(Entity, DVec3, DVec3)> {
        let mut bodies =
            self.sim.world.query_filtered::<(Entity, &Transform, &PhysicsBody), Without<Dormant>>();
        let bodies = bodies.iter(&self.sim.world).filter(|(.., body)| body.inverse_mass > 0.0);
        bodies.map(|(entity, transform, body)| (entity, transform.position, body.velocity)).collect()
    }

    fn add_velocities(&mut self, arrows: &mut Vec<(Entity, DVec3, [f32; 4])>) {
        let bodies = self.movable().into_iter();
        arrows.extend(bodies.map(|(body, _, velocity)| (body, velocity * VELOCITY_SCALE, VELOCITY_COLOR)));
    }

    /// The weight of every body, and the sum of all other forces on it.
    fn add_forces(&mut self, arrows: &mut Vec<(Entity, DVec3, [f32; 4])>, eye: DVec3) {
        let bodies = self.movable();
        let entities: Vec<_> = bodies.iter().map(|(entity, ..)| *entity).collect();
        let mut sums = vec![[DVec3::ZERO; 2]; bodies.len()];
        self.each_force(&entities, |place, cause, newtons| {
            sums[place][usize::from(cause == ForceCause::Law("gravity"))] += newtons;
        });
        let sizes = bodies.iter().zip(&sums).map(|((_, position, _), forces)| {
            (forces.map(DVec3::length).into_iter().fold(0.0, f64::max), position.distance(eye))
        });
        let finite = sizes.filter(|(newtons, _)| newtons.is_finite());
        let Some((largest, distance)) = finite.max_by(|(a, _), (b, _)| a.total_cmp(b)) else { return };
        let Some(scale) = self.newtons_per_meter(largest, distance) else { return };
        for (body, [others, weight]) in entities.into_iter().zip(sums) {
            arrows.extend([(body, others / scale, FORCE_COLOR), (body, weight / scale, WEIGHT_COLOR)]);
        }
    }
}
