//! What a tick of bodies that all attract each other takes, before one is taken.

use std::collections::BTreeMap;

use cpu_time::ThreadTime;
use history::Simulation;
use scene::{BodySpec, Names, Scene};

/// Bodies of the sample.
const SAMPLE: usize = 2_000;

/// A tick of bodies that attract each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttractionTick {
    /// Bodies that move and attract each other.
    pub bodies: usize,
    /// Thread CPU time of a tick, s: what a tick of some of them takes here, by the square of their number.
    pub seconds: f64,
}

/// What a tick of `scene` takes if that is mostly attraction: of more than 2,000 bodies. `None` otherwise.
pub fn attraction_tick(scene: &Scene) -> Option<AttractionTick> {
    scene.mutual_gravity?;
    let is_particle = |id: u32| scene.emitters.iter().any(|emitter| emitter.pool.contains(&id));
    let moves = |body: &BodySpec| body.inverse_mass.is_some_and(|inverse_mass| inverse_mass > 0.0);
    let attracted = || (0..).zip(&scene.bodies).filter(|(id, body)| moves(body) && !is_particle(*id));
    let bodies = attracted().count();
    if bodies <= SAMPLE {
        return None;
    }
    let each = bodies.div_ceil(SAMPLE);
    let sample: Vec<BodySpec> = attracted().step_by(each).map(|(_, body)| *body).collect();
    let share = bodies as f64 / sample.len() as f64;
    let sample = Scene {
        bodies: sample,
        names: Names::default(),
        labels: Vec::new(),
        own_laws: BTreeMap::new(),
        emitters: Vec::new(),
        springs: Vec::new(),
        soft_bodies: Vec::new(),
        ..scene.clone()
    };
    let mut simulation = Simulation::new(sample);
    // The first tick makes columns and caches, and may have more to start.
    simulation.tick();
    let start = ThreadTime::now();
    simulation.tick();
    Some(AttractionTick { bodies, seconds: start.elapsed().as_secs_f64() * share * share })
}
