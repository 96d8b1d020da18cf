//! Arrows: velocities in m/s and forces in newtons.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::{Dormant, PhysicsBody, Transform};
use render::{Frame, Line};

use crate::stage::Stage;
use crate::stage::forces::add_to;
use crate::stage::query;
use crate::view::View;

const VELOCITY_COLOR: [f32; 4] = [0.3, 0.75, 1.0, 1.0];
const ARROW_WIDTH_PX: f32 = 2.5;
const NET_WIDTH_PX: f32 = 5.0;

/// Meters of an arrow per m/s.
pub(crate) const VELOCITY_SCALE: f64 = 0.5;

/// Length of the longest force arrow when the scale is chosen, as a fraction of the distance from the camera.
const SHARE: f64 = 0.15;

/// Factor by which an arrow may grow before the scale is chosen again.
const GROWTH: f64 = 3.0;

/// The name of the sum of all forces on a body.
pub(crate) const NET: &str = "net";

/// A vector at a body, m.
struct Arrow {
    body: Entity,
    vector: DVec3,
    color: [f32; 4],
    width: f32,
}

impl View {
    pub(super) fn add_arrows(&mut self, stage: &Stage, frame: &mut Frame) {
        let (mut arrows, eye) = (Vec::new(), self.camera.position);
        if self.velocity_arrows {
            add_velocities(stage, &mut arrows);
        }
        self.force_causes.clear();
        if self.force_arrows {
            self.add_forces(stage, &mut arrows);
        } else {
            self.force_scale = None;
        }
        for Arrow { body, vector, color, width } in arrows {
            if let Some(from) = stage.drawn_position(body).filter(|_| vector.is_finite()) {
                let (from, to) = ((from - eye).as_vec3(), (from + vector - eye).as_vec3());
                Line::arrow(&mut frame.lines, from, to, color, width);
            }
        }
    }

    /// Adds the forces on every body, an arrow per cause, and their sum if there are several.
    fn add_forces(&mut self, stage: &Stage, arrows: &mut Vec<Arrow>) {
        let (bodies, eye) = (movable(stage), self.camera.position);
        let entities: Vec<_> = bodies.iter().map(|(entity, ..)| *entity).collect();
        let mut by_cause = vec![Vec::<(&'static str, DVec3)>::new(); bodies.len()];
        motion::each_force(
            &stage.sim().world,
            &stage.here().pushes(),
            &entities,
            |place, cause, newtons| {
                add_to(&mut by_cause[place], cause.name(), newtons);
            },
        );
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
        let Some((largest, distance)) = finite.max_by(|(a, _), (b, _)| a.total_cmp(b)) else {
            return;
        };
        let Some(scale) = self.newtons_per_meter(largest, distance) else { return };
        for (body, forces) in entities.into_iter().zip(by_cause) {
            for (name, newtons) in forces {
                if !self.force_causes.contains(&name) {
                    self.force_causes.push(name);
                }
                let width = if name == NET { NET_WIDTH_PX } else { ARROW_WIDTH_PX };
                arrows.push(Arrow { body, vector: newtons / scale, color: color_of(name), width });
            }
        }
    }

    /// The scale of force arrows, N per m, if the largest force is one of `newtons` on a body `distance` meters from the camera.
    /// The scale stays until an arrow is [`GROWTH`] times too long, so that arrows can be seen to grow.
    fn newtons_per_meter(&mut self, newtons: f64, distance: f64) -> Option<f64> {
        let longest = SHARE * distance;
        if self.force_scale.is_none_or(|scale| newtons > scale * longest * GROWTH) {
            let scale = round_up(newtons / longest);
            self.force_scale = scale.is_normal().then_some(scale);
        }
        self.force_scale
    }
}

/// Every movable body that is not dormant, its position, m, and its velocity, m/s.
fn movable(stage: &Stage) -> Vec<(Entity, DVec3, DVec3)> {
    let mut bodies =
        query::<(Entity, &Transform, &PhysicsBody), Without<Dormant>>(&stage.sim().world);
    let bodies = bodies.iter(&stage.sim().world).filter(|(.., body)| body.inverse_mass > 0.0);
    bodies.map(|(entity, transform, body)| (entity, transform.position, body.velocity)).collect()
}

fn add_velocities(stage: &Stage, arrows: &mut Vec<Arrow>) {
    arrows.extend(movable(stage).into_iter().map(|(body, _, velocity)| {
        let (vector, color) = (velocity * VELOCITY_SCALE, VELOCITY_COLOR);
        Arrow { body, vector, color, width: ARROW_WIDTH_PX }
    }));
}

/// The color of the arrows of a law that is not one of the library's.
const OTHER_CAUSE: [f32; 3] = [1.0, 0.6, 0.75];

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
        _ => OTHER_CAUSE,
    };
    [r, g, b, 1.0]
}

/// The next of 1, 2, 5, 10, 20, ...
fn round_up(x: f64) -> f64 {
    let decade = x.log10().floor();
    // A negative power would not be rounded to the nearest number.
    let times =
        |m: f64| if decade < 0.0 { m / 10_f64.powf(-decade) } else { m * 10_f64.powf(decade) };
    [1.0, 2.0, 5.0].map(times).into_iter().find(|step| *step >= x).unwrap_or(times(10.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_has_a_color_of_its_own() {
        let causes: Vec<_> =
            motion::LAWS.iter().map(|(name, _)| *name).chain([NET, "push"]).collect();
        let mut colors: Vec<_> = causes.iter().map(|cause| color_of(cause)).collect();
        colors.push(color_of("a law of a game"));
        for (i, color) in colors.iter().enumerate() {
            assert!(!colors[..i].contains(color), "{:?} has the color of another", causes.get(i));
        }
    }

    #[test]
    fn scales_are_round_numbers() {
        for (x, rounded) in [
            (1.0, 1.0),
            (1.01, 2.0),
            (3.0, 5.0),
            (7.0, 10.0),
            (0.03, 0.05),
            (2e-7, 2e-7),
            (130.0, 200.0),
        ] {
            assert_eq!(round_up(x), rounded, "{x}");
        }
        assert!(!round_up(0.0).is_normal() && !round_up(f64::NAN).is_normal());
    }
}
