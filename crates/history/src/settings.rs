//! Settings of a run: [`Overrides`], which replace those of its scenes, and [`RunSettings`], the present ones.

use motion::effects::Effect;
use motion::snapshot::Effects;
use motion::{DampingModel, Method, TimeStep};
use scene::{Scene, Substepping, unsolvable};
use serde::{Deserialize, Serialize};

use crate::simulation::Simulation;

/// Settings that replace those of a run's scenes; `None` keeps the scene's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Overrides {
    /// Method of the scene; bodies with their own method keep it.
    pub method: Option<Method>,
    /// Ticks per second, positive and finite.
    pub step_hz: Option<f64>,
    /// Substeps; bodies with their own keep them.
    pub substeps: Option<Substepping>,
    /// Damping model, where the scene declares damping.
    pub damping: Option<DampingModel>,
}

impl Overrides {
    /// The settings of `scene` itself.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        Self {
            method: Some(scene.method),
            step_hz: Some(scene.step_hz),
            substeps: Some(scene.substeps),
            damping: scene.damping.map(|damping| damping.model),
        }
    }

    /// Why `scene` cannot have these settings, if so: their method cannot solve one of its laws.
    #[must_use]
    pub fn unsolvable(self, scene: &Scene) -> Option<&'static str> {
        unsolvable(self.method?, scene.mutual_gravity.is_some())
    }

    /// Applies the settings to `scene`, except a method that cannot solve its laws and an invalid rate.
    pub fn apply(self, scene: &mut Scene) {
        let solved = self.unsolvable(scene).is_none();
        scene.method = self.method.filter(|_| solved).unwrap_or(scene.method);
        let rate =
            self.step_hz.filter(|rate| *rate > 0.0 && rate.is_finite() && (1.0 / rate).is_finite());
        scene.step_hz = rate.unwrap_or(scene.step_hz);
        scene.substeps = self.substeps.map_or(scene.substeps, Substepping::clamped);
        if let (Some(damping), Some(model)) = (&mut scene.damping, self.damping) {
            damping.model = model;
        }
    }
}

/// The present settings of a running simulation: method, ticks and effects.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSettings {
    /// Method of bodies without their own.
    pub method: Method,
    /// Substeps of bodies without their own.
    pub substeps: Substepping,
    /// Length of a tick, s.
    pub step: f64,
    /// Gravity and damping, and the effects that are off.
    pub effects: Effects,
}

impl RunSettings {
    /// The present settings of `simulation`.
    pub fn of(simulation: &Simulation) -> Self {
        Self {
            method: simulation.method(),
            substeps: simulation.substeps(),
            step: simulation.world.resource::<TimeStep>().0,
            effects: Effects::of(&simulation.world),
        }
    }

    /// Ticks per second, Hz: see [`rate_of`].
    #[must_use]
    pub fn step_hz(&self) -> f64 {
        rate_of(self.step)
    }

    /// Applies the settings to `scene`, so that a run of it starts with them.
    pub fn apply(&self, scene: &mut Scene) {
        (scene.method, scene.substeps, scene.step_hz) =
            (self.method, self.substeps, self.step_hz());
        (scene.gravity, scene.damping) = (self.effects.gravity, self.effects.damping);
        // Gravity has its own flag.
        let off = self.effects.off.iter().copied();
        scene.off_at_start = off.filter(|effect| *effect != Effect::Gravity).collect();
    }

    /// Applies the settings to another run of the same scene, except substeps, which that run has from its scene.
    pub fn put(&self, simulation: &mut Simulation) {
        simulation.world.insert_resource(TimeStep(self.step));
        self.effects.put(&mut simulation.world);
        simulation.stepper.recompile(&mut simulation.world);
        if self.method != simulation.method() {
            simulation.set_method(self.method);
        }
    }
}

/// The rate of ticks that last `step` s, in Hz: rounded to ten digits if ticks of the rounded rate have exactly this
/// length, else `1 / step`.
#[must_use]
pub fn rate_of(step: f64) -> f64 {
    let rate = 1.0 / step;
    let short = format!("{rate:.9e}").parse().unwrap_or(rate);
    if 1.0 / short == step { short } else { rate }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_comes_back_from_the_length_of_its_ticks() {
        for rate in [120.0, 60.0, 1.0, 49.0, 333.25, 1e4, 0.1, 59.94] {
            assert_eq!(rate_of(1.0 / rate), rate);
        }
    }
}
