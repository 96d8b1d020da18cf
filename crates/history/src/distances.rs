//! Distances between the bodies of two simulations of one scene.

use bevy_ecs::prelude::*;
use motion::units::Vector;
use motion::{Dormant, PhysicsBody, Quarantined, Transform};

use crate::simulation::Simulation;

impl Simulation {
    /// The body of that stable id, unless it was removed, is quarantined or is not born yet.
    #[must_use]
    pub fn present(&self, id: u32) -> Option<EntityRef<'_>> {
        let body = self.world.get_entity(*self.bodies.get(id as usize)?).ok()?;
        (!body.contains::<Quarantined>() && !body.contains::<Dormant>()).then_some(body)
    }

    /// Like [`Self::present`], for movable bodies alone.
    #[must_use]
    pub fn moving(&self, id: u32) -> Option<EntityRef<'_>> {
        self.present(id)
            .filter(|body| body.get::<PhysicsBody>().is_some_and(|state| state.inverse_mass > 0.0))
    }

    fn position(&self, id: u32) -> Option<Vector> {
        self.moving(id)?.get::<Transform>().map(|transform| transform.position)
    }
}

/// The distance of each body from its position in another simulation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Distances {
    /// Stable id and distance, m, of each body that moves in both, ascending by id.
    pub each: Vec<(u32, f64)>,
}

impl Distances {
    /// The distances between the bodies of `simulation` and those of `other`, of the same scene.
    #[must_use]
    pub fn between(simulation: &Simulation, other: &Simulation) -> Self {
        let distance = |id| Some((id, simulation.position(id)?.distance(other.position(id)?)));
        Self { each: (0..).take(simulation.bodies.len()).filter_map(distance).collect() }
    }

    /// The body with the largest distance among those for which `counts` is true; the first of several.
    #[must_use]
    pub fn farthest(&self, counts: impl Fn(u32) -> bool) -> Option<(u32, f64)> {
        let farther =
            |best: (u32, f64), body: (u32, f64)| if body.1 > best.1 { body } else { best };
        self.each.iter().copied().filter(|(id, _)| counts(*id)).reduce(farther)
    }
}

/// Distances over many ticks: the largest of each body, and the mean of all squares.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DistancesSoFar {
    /// By stable id; less than 0 for a body that never moved in both.
    largest: Vec<f64>,
    squares: f64,
    count: f64,
}

impl DistancesSoFar {
    /// Adds the distances of one more tick.
    pub fn add(&mut self, distances: &Distances) {
        for (id, distance) in &distances.each {
            let at = *id as usize;
            if at >= self.largest.len() {
                self.largest.resize(at + 1, -1.0);
            }
            self.largest[at] = self.largest[at].max(*distance);
            self.squares += distance * distance;
            self.count += 1.0;
        }
    }

    /// The largest distance of a body for which `counts` is true, m; `None` without such a body.
    #[must_use]
    pub fn largest(&self, counts: impl Fn(u32) -> bool) -> Option<f64> {
        let counted =
            (0..).zip(&self.largest).filter(|(id, distance)| **distance >= 0.0 && counts(*id));
        counted.map(|(_, distance)| *distance).reduce(f64::max)
    }

    /// Root of the mean square over all ticks and bodies, m; `None` without distances.
    #[must_use]
    pub fn rms(&self) -> Option<f64> {
        (self.count > 0.0).then(|| (self.squares / self.count).sqrt())
    }
}
