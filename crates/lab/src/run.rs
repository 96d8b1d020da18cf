//! A running scene, and the time of its steps.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use history::{Simulation, Watch};
use motion::effects::Effect;
use motion::{Method, Request};
use scene::{BodySpec, Names, Scene};

use crate::clock::{BLOCK_S, thread_time};

/// The results of a study of the effects of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ByEffect<R> {
    /// Name of the scene.
    pub scene: String,
    /// Its method.
    pub method: Method,
    /// Ticks of the run.
    pub ticks: u64,
    /// Thread CPU time of a tick with all effects on, ns.
    pub ns: f64,
    /// A row for each effect.
    pub rows: Vec<R>,
}

/// Ticks before a measurement, in which schedules, caches and the columns with the state of methods are
/// built.
const WARM_UP: u64 = 5;

/// How often a block of ticks is measured; the least time counts.
const ROUNDS: usize = 9;

/// The start of `scene` with the effects of `without` switched off.
pub(crate) fn started(scene: impl Into<Arc<Scene>>, without: &[Effect]) -> Simulation {
    let mut simulation = Simulation::new(scene);
    without.iter().for_each(|effect| simulation.request(Request::Switch(*effect, false)));
    simulation.carry_out_requests();
    simulation
}

/// The bodies of `scene` that can move, with their stable ids.
pub(crate) fn movable(scene: &Scene) -> impl Iterator<Item = (u32, &BodySpec)> {
    (0..).zip(&scene.bodies).filter(|(_, body)| body.is_movable())
}

/// `power` of 10, the nearest number to it.
pub(crate) fn decade(power: i32) -> f64 {
    let whole = libm::pow(10.0, f64::from(power.abs()));
    if power < 0 { 1.0 / whole } else { whole }
}

/// The power of ten, in m, next to the size of the motion in `scene` within `seconds`: the largest distance of a body or a well from
/// their middle or, where all are in one place, the way of the fastest body at its first speed, or else 1 m.
pub(crate) fn size(scene: &Scene, seconds: f64) -> i32 {
    let wells = scene.laws.wells.iter().flat_map(|wells| &wells.0);
    let places: Vec<_> = wells
        .map(|well| well.position)
        .chain(scene.bodies.iter().map(|body| body.position))
        .collect();
    let middle = places.iter().sum::<DVec3>() / places.len().max(1) as f64;
    let largest = |lengths: &mut dyn Iterator<Item = f64>| lengths.fold(0.0, f64::max);
    let extent = largest(&mut places.iter().map(|place| place.distance(middle)));
    let speed = largest(&mut movable(scene).map(|(_, body)| body.velocity.length()));
    let size = [extent, speed * seconds, 1.0].into_iter().find(|size| *size > 0.0);
    libm::round(libm::log10(size.unwrap_or(1.0))) as i32
}

/// Thread CPU time of a tick, s, over `ticks` of them, at least 1.
fn time(ticks: u64, mut tick: impl FnMut()) -> f64 {
    let start = thread_time();
    (0..ticks).for_each(|_| tick());
    (thread_time() - start) / ticks as f64
}

/// Ticks of a block, at most `ticks`, if one takes `tick` seconds.
fn block_of(tick: f64, ticks: u64) -> u64 {
    ((BLOCK_S / tick.max(1e-9)) as u64).clamp(1, ticks.max(1))
}

/// Least thread CPU time of a tick of a scene in each of several variants, in blocks. A variant is the list of effects that are
/// switched off.
///
/// Every block starts from the same state, and blocks of all variants take turns, so that other load of the machine
/// affects all of them alike.
pub(crate) struct StepTimes {
    scene: Arc<Scene>,
    variants: Vec<Vec<Effect>>,
    /// Most ticks of a block.
    most: u64,
    /// Ticks of a block; 0 before the first one.
    block: u64,
    blocks: usize,
    /// Least time of each variant, s.
    least: Vec<f64>,
}

impl StepTimes {
    pub fn new(scene: &Scene, variants: Vec<Vec<Effect>>, ticks: u64) -> Self {
        let least = vec![f64::INFINITY; variants.len()];
        let scene = Arc::new(scene.clone());
        Self { scene, variants, most: ticks.max(1), block: 0, blocks: 0, least }
    }

    /// Times the next block. Returns whether it was the last one.
    pub fn time_block(&mut self) -> bool {
        let tick_time = |without: &[Effect], ticks| {
            let mut simulation = started(Arc::clone(&self.scene), without);
            simulation.run(WARM_UP);
            time(ticks, || simulation.tick())
        };
        if self.block == 0 {
            self.block = block_of(tick_time(&[], self.most.min(10)), self.most);
        } else {
            let place = self.blocks % self.variants.len();
            let time = tick_time(&self.variants[place], self.block);
            self.least[place] = self.least[place].min(time);
            self.blocks += 1;
        }
        self.blocks >= ROUNDS * self.variants.len()
    }

    /// The times of all variants, ns, once all blocks are timed.
    pub fn all_ns(mut self) -> Vec<f64> {
        while !self.time_block() {}
        self.ns()
    }

    /// The times so far, ns.
    pub fn ns(&self) -> Vec<f64> {
        self.least.iter().map(|seconds| seconds * 1e9).collect()
    }
}

/// Ticks before a watch is measured. The first ticks may begin a look, which keeps a ledger for at most as many
/// ticks.
const WATCH_WARM_UP: u64 = 32;

/// Least thread CPU time that a [`Watch`] adds to a tick of `scene`, ns, while no energy grows. It is measured by
/// itself: beside a tick of many springs it would be within the noise.
pub fn watch_time(scene: &Scene) -> f64 {
    let mut simulation = Simulation::new(scene.clone());
    let mut watch = Watch::new(&simulation);
    for _ in 0..WATCH_WARM_UP {
        watch.tick(&mut simulation, None);
    }
    let mut check_time = |checks| {
        time(checks, || {
            watch.check(&simulation);
        })
    };
    let block = block_of(check_time(1), u64::MAX);
    (0..ROUNDS).map(|_| check_time(block)).fold(f64::INFINITY, f64::min) * 1e9
}

/// Most bodies that [`attraction_tick`] simulates.
const SAMPLE: usize = 2_000;

/// A tick of bodies that attract each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttractionTick {
    /// Bodies that move and attract each other.
    pub bodies: usize,
    /// Thread CPU time of a tick, s, extrapolated from a tick of some of these bodies by the square of their number.
    pub seconds: f64,
}

/// The time of a tick of `scene` in which more than 2,000 bodies attract each other; `None` for other scenes.
pub fn attraction_tick(scene: &Scene) -> Option<AttractionTick> {
    scene.mutual_gravity?;
    let attracted = || movable(scene).filter(|(id, _)| !scene.is_particle(*id));
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
        motions: BTreeMap::new(),
        emitters: Vec::new(),
        springs: Vec::new(),
        soft_bodies: Vec::new(),
        ..scene.clone()
    };
    let mut simulation = Simulation::new(sample);
    // The first tick makes columns and caches.
    simulation.tick();
    Some(AttractionTick { bodies, seconds: time(1, || simulation.tick()) * share * share })
}
