//! Runs of a subject: in a world of entities, or in a loop over arrays.
//!
//! Tests implement the trait for a slow run and for a broken one.

use glam::DVec3;
use history::Simulation;
use motion::Method;
use motion::internals::Groups;

use super::record::{Counts, Failure};

/// Stable id, position, m, and velocity, m/s.
pub type Sample = (u32, DVec3, DVec3);

/// A run in progress.
pub trait Runner {
    /// Simulates one tick.
    fn tick(&mut self);
    /// The bodies with physics, in the order of their stable ids.
    fn states(&mut self) -> Vec<Sample>;
    /// Brings velocities that are half a step late to the time of the positions. The run is over then.
    fn synchronize(&mut self) {}
    /// Evaluations so far.
    fn counts(&mut self) -> Counts;
    /// Why the run produced no data point; non-finite states and large errors are found elsewhere.
    fn failure(&mut self) -> Option<Failure>;
}

impl Runner for Simulation {
    fn tick(&mut self) {
        Self::tick(self);
    }

    fn states(&mut self) -> Vec<Sample> {
        Self::states(self).collect()
    }

    fn synchronize(&mut self) {
        // A change of method brings velocities to the time of the positions.
        if self.method() == Method::PositionVerlet {
            self.set_method(Method::VelocityVerlet);
        }
    }

    fn counts(&mut self) -> Counts {
        let evaluations = self.evaluations();
        let (accelerations, newton, cg) = (
            evaluations.accelerations(),
            evaluations.newton_iterations(),
            evaluations.cg_iterations(),
        );
        Counts { accelerations, solver: newton + cg * mean_group(self) }
    }

    fn failure(&mut self) -> Option<Failure> {
        if let Some(failure) = Self::failure(self) {
            return Some(Failure::Quarantined {
                body: failure.name(&self.scene),
                tick: failure.tick,
            });
        }
        let steps = self.evaluations().unconverged_steps();
        (steps > 0).then_some(Failure::Unconverged { steps })
    }
}

/// Mean number of bodies of a group: an iteration of a solver works on one group.
fn mean_group(run: &Simulation) -> u64 {
    run.world
        .get_resource::<Groups>()
        .map_or(0, |groups| groups.bodies() as u64 / groups.len().max(1) as u64)
}
