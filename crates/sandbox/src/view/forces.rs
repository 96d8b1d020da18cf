//! The forces on the bodies of a session, and the scale at which their arrows are drawn.

use bevy_ecs::prelude::*;
use glam::DVec3;
use motion::snapshot::LastStep;
use motion::{Damping, DampingModel, ForceCause, PhysicsBody, Push, SoftBody};

use crate::view::stage::Stage;

/// Length of the longest force arrow where its scale is chosen, as a share of the distance from the camera.
const SHARE: f64 = 0.15;

/// How much longer an arrow may grow before the scale is chosen again.
const GROWTH: f64 = 3.0;

impl Stage {
    /// The forces on `body` at its present state, N, by cause; pushes are those of the last tick.
    pub fn forces_on(&mut self, body: Entity) -> Vec<(ForceCause, DVec3)> {
        let mut forces = Vec::new();
        self.each_force(&[body], |_, cause, newtons| forces.push((cause, newtons)));
        forces
    }

    /// Calls `each` with every force on `bodies`, given by their places among them.
    pub(crate) fn each_force(&mut self, bodies: &[Entity], each: impl FnMut(usize, ForceCause, DVec3)) {
        let pushes = self.pushes();
        motion::each_force(&mut self.sim.world, &pushes, bodies, each);
    }

    /// The pushes of the last tick.
    pub(crate) fn pushes(&self) -> Vec<Push> {
        let push = |(body, newtons): (&Entity, &DVec3)| Push { body: *body, newtons: *newtons };
        self.seen.acting.iter().map(push).collect()
    }

    /// Newtons of a force arrow of one meter, where the largest force is one of `newtons` on a body `distance` meters
    /// from the camera. It stays as it is chosen once, so that arrows can be seen to grow.
    pub(crate) fn newtons_per_meter(&mut self, newtons: f64, distance: f64) -> Option<f64> {
        let longest = SHARE * distance;
        if self.view.force_scale.is_none_or(|scale| newtons > scale * longest * GROWTH) {
            let scale = round_up(newtons / longest);
            self.view.force_scale = scale.is_normal().then_some(scale);
        }
        self.view.force_scale
    }
}

/// The state of a body at the time of its position, from the forces on it: position Verlet keeps the velocity of half a
/// step before.
pub(crate) fn synchronized(
    world: &World,
    body: Entity,
    forces: &[(ForceCause, DVec3)],
) -> Option<PhysicsBody> {
    let state = *world.get::<PhysicsBody>(body)?;
    let damping = damping_model(world);
    let laws = forces.iter().filter(|(cause, _)| is_of_laws(*cause, damping));
    let newtons: DVec3 = laws.map(|(_, newtons)| *newtons).sum();
    Some(state.moving_at(state.velocity + newtons * state.inverse_mass * half_step(world, body)))
}

/// The state of a soft body at the time of its positions; its points move `together`.
pub(crate) fn synchronized_points(
    world: &mut World,
    pushes: &[Push],
    soft: Entity,
    together: PhysicsBody,
) -> PhysicsBody {
    let points = world.get::<SoftBody>(soft).map_or_else(Vec::new, |soft| soft.points.clone());
    let halves: Vec<_> = points.iter().map(|point| half_step(world, *point)).collect();
    let (damping, mut impulse) = (damping_model(world), DVec3::ZERO);
    if halves.iter().any(|half| *half != 0.0) {
        motion::each_force(world, pushes, &points, |place, cause, newtons| {
            if is_of_laws(cause, damping) {
                impulse += newtons * halves[place];
            }
        });
    }
    together.moving_at(together.velocity + impulse * together.inverse_mass)
}

fn half_step(world: &World, body: Entity) -> f64 {
    world.get::<LastStep>(body).map_or(0.0, |last| last.0 / 2.0)
}

fn damping_model(world: &World) -> Option<DampingModel> {
    world.get_resource::<Damping>().map(|damping| damping.model)
}

/// Adds to the sum of that name, or begins it.
pub(crate) fn add_to<N: PartialEq>(sums: &mut Vec<(N, DVec3)>, name: N, newtons: DVec3) {
    match sums.iter_mut().find(|(known, _)| *known == name) {
        Some((_, sum)) => *sum += newtons,
        None => sums.push((name, newtons)),
    }
}

/// Whether a method asks for it as a law. All of a push, and of damping that is no law, is in a velocity already.
fn is_of_laws(cause: ForceCause, damping: Option<DampingModel>) -> bool {
    match cause {
        ForceCause::Push => false,
        ForceCause::Law("damping") => damping == Some(DampingModel::Exact),
        _ => true,
    }
}

/// The next of 1, 2, 5, 10, 20, ...
fn round_up(x: f64) -> f64 {
    let decade = x.log10().floor();
    // A negative power would not be rounded to the nearest number.
    let times = |m: f64| if decade < 0.0 { m / 10_f64.powf(-decade) } else { m * 10_f64.powf(decade) };
    [1.0, 2.0, 5.0].map(times).into_iter().find(|step| *step >= x).unwrap_or(times(10.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_round_numbers() {
        for (x, rounded) in
            [(1.0, 1.0), (1.01, 2.0), (3.0, 5.0), (7.0, 10.0), (0.03, 0.05), (2e-7, 2e-7), (130.0, 200.0)]
        {
            assert_eq!(round_up(x), rounded, "{x}");
        }
        assert!(!round_up(0.0).is_normal() && !round_up(f64::NAN).is_normal());
    }
}
