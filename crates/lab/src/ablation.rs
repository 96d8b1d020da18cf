//! A scene run again without each of its effects in turn: what each one changes, and what it costs.

use std::sync::Arc;

use history::Simulation;
use motion::effects::{Effect, EffectState};
use scene::Scene;

use crate::cost::{Deviation, Sample, Scales};
use crate::run::{ByEffect, StepTimes, started};

/// A run without one effect, against the full one.
#[derive(Clone, Debug, PartialEq)]
pub struct Absence {
    /// The effect that was left out.
    pub effect: Effect,
    /// Largest distance of a body at the end from its place in the full run, m.
    pub max_distance: f64,
    /// Root of the mean square of the distances, m.
    pub rms_distance: f64,
    /// Whether every position and velocity is the same to the last bit, and every particle on a graphics device.
    pub identical: bool,
    /// Evaluations that a tick saves without it.
    pub evaluations_saved: f64,
    /// Thread CPU time that a tick saves without it, ns.
    pub ns_saved: f64,
    /// Whether the pictures at the end differ; `None` if they were not drawn.
    pub picture_differs: Option<bool>,
}

impl Absence {
    /// Whether the run or its picture differs without the effect.
    pub fn needed(&self) -> bool {
        !self.identical || self.picture_differs == Some(true)
    }
}

/// The changes that each effect of a run makes: a row for every effect that acts at the start.
pub type Ablation = ByEffect<Absence>;

/// Runs `scene` for `ticks` ticks, at least 1, and again without each effect that acts at its start.
pub fn ablate(scene: &Scene, ticks: u64) -> Ablation {
    let ticks = ticks.max(1);
    let scene = Arc::new(scene.clone());
    let mut full = Simulation::new(Arc::clone(&scene));
    let acts = |effect: &Effect| motion::effects::state(&full.world, *effect) == EffectState::On;
    let effects: Vec<_> = Effect::ALL.into_iter().filter(acts).collect();
    full.run(ticks);
    let evaluations = |simulation: &Simulation| -> u64 {
        simulation.evaluations().laws().iter().map(|(_, count)| count).sum()
    };
    let (states, spent) = (full.states().collect::<Vec<_>>(), evaluations(&full));
    let particles = full.particle_keys();
    let variants: Vec<_> =
        [Vec::new()].into_iter().chain(effects.iter().map(|effect| vec![*effect])).collect();
    let times = StepTimes::new(&scene, variants, ticks).all_ns();
    let ns = times[0];
    let rows = effects
        .iter()
        .zip(&times[1..])
        .map(|(effect, time)| {
            let mut without = started(Arc::clone(&scene), &[*effect]);
            without.run(ticks);
            let saved = spent as f64 - evaluations(&without) as f64;
            let ends: Vec<_> = without.states().collect();
            let mut deviation = Deviation::default();
            deviation.look(&states, &ends, Scales::ONE);
            let errors = deviation.errors();
            Absence {
                effect: *effect,
                max_distance: errors.position_m,
                rms_distance: errors.position_rms_m,
                identical: bits(&states) == bits(&ends) && without.particle_keys() == particles,
                evaluations_saved: saved / ticks as f64,
                ns_saved: ns - time,
                picture_differs: None,
            }
        })
        .collect();
    Ablation { scene: scene.name.clone(), method: scene.method, ticks, ns, rows }
}

/// Stable ids and all bits of states.
fn bits(states: &[Sample]) -> Vec<(u32, [[u64; 3]; 2])> {
    states
        .iter()
        .map(|(id, x, v)| (*id, [x, v].map(|vector| vector.to_array().map(f64::to_bits))))
        .collect()
}
