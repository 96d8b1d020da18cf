//! A scene on its way, and how long its steps take.

use bevy_ecs::prelude::*;
use cpu_time::ThreadTime;
use history::Watch;
use motion::effects::Effect;
use motion::units::Vector;
use motion::{PhysicsBody, Request, Requests, Stepper, TimeStep};
use scene::Scene;

/// Ticks before a measurement: schedules, caches and the columns of methods are there after them.
const WARM_UP: u64 = 5;

/// How often each block is measured; the least of them counts.
const ROUNDS: usize = 9;

/// Length of a block, s: long against the clock, short against the time slices of a machine that does other
/// things too.
const BLOCK: f64 = 1e-3;

/// A world and its stepper.
pub(crate) struct Run {
    pub world: World,
    pub stepper: Stepper,
    /// By stable id.
    bodies: Vec<Entity>,
}

impl Run {
    /// The start of `scene`, with effects switched off; those that it never declared are off anyway.
    pub fn of(scene: &Scene, without: &[Effect]) -> Self {
        let mut world = World::new();
        let bodies = scene.spawn(&mut world);
        let mut stepper = Stepper::new(&mut world, scene.method, TimeStep(1.0 / scene.step_hz));
        let mut requests = world.resource_mut::<Requests>();
        without.iter().for_each(|effect| requests.ask(Request::Switch(*effect, false)));
        stepper.carry_out_requests(&mut world);
        Self { world, stepper, bodies }
    }

    /// The bodies of the scene, in the order of their stable ids.
    pub fn bodies(&self) -> &[Entity] {
        &self.bodies
    }

    pub fn ticks(&mut self, ticks: u64) {
        (0..ticks).for_each(|_| self.stepper.tick(&mut self.world));
    }

    /// Position and velocity of every body with physics, in stable-id order.
    pub fn states(&mut self) -> Vec<(u32, Vector, Vector)> {
        history::states(&mut self.world)
    }

    /// Stable ids of the bodies that can move, ascending.
    pub fn movable_ids(&self) -> Vec<u32> {
        let moves =
            |body: &Entity| self.world.get::<PhysicsBody>(*body).is_some_and(|body| body.inverse_mass > 0.0);
        (0..).zip(&self.bodies).filter(|(_, body)| moves(body)).map(|(id, _)| id).collect()
    }

    /// Thread CPU time of a tick, s, over `ticks` of them, at least 1.
    fn time(&mut self, ticks: u64) -> f64 {
        time(ticks, || self.ticks(1))
    }
}

/// Thread CPU time of a tick, s, over `ticks` of them, at least 1.
#[expect(clippy::cast_precision_loss, reason = "a count of ticks")]
fn time(ticks: u64, mut tick: impl FnMut()) -> f64 {
    let start = ThreadTime::now();
    (0..ticks).for_each(|_| tick());
    start.elapsed().as_secs_f64() / ticks as f64
}

/// Ticks of a block, at most `ticks`, when one of them takes so many seconds.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a count of ticks")]
fn block_of(tick: f64, ticks: u64) -> u64 {
    ((BLOCK / tick.max(1e-9)) as u64).clamp(1, ticks.max(1))
}

/// Least thread CPU time of a step of `scene` without each of those lists of effects, ns, over at most `ticks` of
/// them.
///
/// Every block starts from the same state, and blocks of all variants take turns: what else the machine does hits
/// all of them alike.
pub(crate) fn step_times(scene: &Scene, variants: &[Vec<Effect>], ticks: u64) -> Vec<f64> {
    let started = |without: &[Effect]| {
        let mut run = Run::of(scene, without);
        run.ticks(WARM_UP);
        run
    };
    let ticks = ticks.max(1);
    let first = started(&[]).time(ticks.min(10));
    let block = block_of(first, ticks);
    let mut least = vec![f64::INFINITY; variants.len()];
    for _ in 0..ROUNDS {
        for (least, without) in least.iter_mut().zip(variants) {
            *least = least.min(started(without).time(block));
        }
    }
    least.into_iter().map(|seconds| seconds * 1e9).collect()
}

/// Ticks before a watch is measured: longer than books are kept after the start of a fall.
const WATCH_WARM_UP: u64 = 32;

/// What a [`Watch`] adds to a tick of `scene`, least thread CPU time, ns, while nothing grows. It is measured by itself:
/// beside a tick of many springs it would be lost in what measurements differ by.
#[must_use]
pub fn watch_time(scene: &Scene) -> f64 {
    let mut run = Run::of(scene, &[]);
    let mut watch = Watch::new(&mut run.world);
    for _ in 0..WATCH_WARM_UP {
        watch.tick(&mut run.stepper, &mut run.world, None);
    }
    let mut looks = |looks| {
        time(looks, || {
            watch.look(&mut run.world, 0.0);
        })
    };
    let block = block_of(looks(1), u64::MAX);
    (0..ROUNDS).map(|_| looks(block)).fold(f64::INFINITY, f64::min) * 1e9
}
