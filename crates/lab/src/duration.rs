//! How long ticks take, estimated by counting what they compute, before any of them is simulated.
//!
//! The same on every machine, so that what is refused on one is refused on all: nanoseconds of one core as docs/performance.md has
//! them, within a factor of some three.

use std::sync::OnceLock;

use history::{REFERENCE_METHOD, reference_substeps};
use motion::{Elastic, Method};
use scene::{EmitterSpec, Scene, SwarmSpec};

use crate::run::movable;

/// Nanoseconds of a tick itself.
const TICK: f64 = 2_000.0;

/// Nanoseconds of evaluating the acceleration of one body.
const BODY: f64 = 8.0;

/// Additional nanoseconds per evaluation for a body in a group.
const MEMBER: f64 = 40.0;

/// Nanoseconds of evaluating one spring.
const SPRING: f64 = 12.0;

/// Cost of a cord, in springs: when it slackens or tightens, its group repeats the step. A chain of 100 cords took 11 times as long
/// as one of springs, where the bodies cost more than the springs: see [`MEMBER`].
const CORD: f64 = 40.0;

/// Nanoseconds of evaluating one law on one body: drag, a well or an engine.
const LAW: f64 = 6.0;

/// Nanoseconds of evaluating one triangle in the air.
const TRIANGLE: f64 = 30.0;

/// Nanoseconds of evaluating the attraction of one pair of bodies.
const PAIR: f64 = 1.5;

/// Nanoseconds of a step of one particle of a swarm, without a graphics device.
const PARTICLE: f64 = 30.0;

/// Approximate evaluations of a step of implicit Euler, its Newton iterations included.
const ITERATIONS: f64 = 30.0;

/// Most seconds that a command may take by default.
const USUAL: f64 = 3_600.0;

/// The longest estimated time that the person allows, s.
static ALLOWED: OnceLock<f64> = OnceLock::new();

/// Sets the longest estimated time of a command, s; only the first call counts.
pub fn allow_time(seconds: f64) {
    ALLOWED.get_or_init(|| seconds);
}

/// Refuses `seconds` if they exceed what the person allowed, or, without that, `usual` (default: an hour).
///
/// # Errors
/// If they do: the estimate and what is allowed, s.
pub fn check_time(seconds: f64, usual: Option<f64>) -> Result<(), TooLong> {
    let allowed = ALLOWED.get().copied().unwrap_or(usual.unwrap_or(USUAL));
    // NaN is too long.
    if seconds <= allowed { Ok(()) } else { Err(TooLong { seconds, allowed }) }
}

/// Something that takes longer than is allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooLong {
    /// Estimated duration, s.
    pub seconds: f64,
    /// Longest allowed duration, s.
    pub allowed: f64,
}

/// Approximate seconds that a CPU takes to step the swarms of `scene` for `ticks` ticks; unless `all`, each swarm for at most the
/// lifetime of its oldest particle.
#[must_use]
pub fn swarm_seconds(scene: &Scene, ticks: f64, all: bool) -> f64 {
    let of = |(_, emitter, swarm): (usize, &EmitterSpec, &SwarmSpec)| {
        let substeps = f64::from(swarm.substeps.unwrap_or(scene.substeps));
        let ticks = if all { ticks } else { ticks.min(emitter.life * scene.step_hz) };
        swarm.launches.len() as f64 * substeps * ticks * PARTICLE * 1e-9
    };
    scene.swarms().map(of).sum()
}

/// Ticks of `scene` in `seconds`, to the nearest; 0 for less than half a tick.
#[must_use]
pub fn ticks_in(scene: &Scene, seconds: f64) -> u64 {
    (seconds * scene.step_hz).round() as u64
}

/// Approximate seconds that a tick of `scene` takes on one core, with its method and substeps and those of its bodies.
#[must_use]
pub fn tick_seconds(scene: &Scene) -> f64 {
    let evaluations = |method: Method, substeps: u32| {
        let each = if method == Method::ImplicitEuler {
            ITERATIONS
        } else {
            f64::from(method.claims().evaluations_with_velocity_laws)
        };
        each * f64::from(substeps)
    };
    let of_body = movable(scene).map(|(_, body)| {
        let method = body.method.unwrap_or(scene.method);
        evaluations(method, body.substeps.unwrap_or(scene.substeps))
    });
    let (mut count, mut sum, mut most) = (0.0, 0.0, 0.0_f64);
    for evaluations in of_body {
        (count, sum, most) = (count + 1.0, sum + evaluations, most.max(evaluations));
    }
    // Which bodies have laws of their own or are in groups is not looked up: each counts as the one with most evaluations.
    let float = |count: usize| count as f64;
    let wells = scene.laws.wells.as_ref().map_or(0.0, |wells| float(wells.0.len()));
    let laws = wells + f64::from(u8::from(scene.laws.drag.is_some()));
    let own = scene.own_laws.values().map(|laws| {
        float(
            usize::from(laws.drag.is_some())
                + laws.wells.len()
                + laws.riding_wells.len()
                + laws.thrusts.len(),
        )
    });
    let soft = scene.soft_bodies.iter();
    let weight = |elastic: &Elastic| if elastic.pull_only { CORD } else { 1.0 };
    let springs = scene.all_springs().map(|(_, elastic)| weight(&elastic)).sum::<f64>();
    let in_air = scene.laws.drag.is_some();
    let triangles: f64 = soft
        .clone()
        .filter(|soft| in_air && soft.sheet)
        .map(|soft| float(soft.triangles.len()))
        .sum();
    let ends_in_groups =
        soft.map(|soft| float(soft.points.len())).sum::<f64>() + 2.0 * float(scene.springs.len());
    let attracts = scene.mutual_gravity.is_some();
    // Mutual gravity does not act on particles of emitters.
    let attracted =
        float(movable(scene).filter(|(id, _)| attracts && !scene.is_particle(*id)).count());
    let members = if attracts { attracted } else { ends_in_groups.min(count) };
    let pairs = attracted * attracted;
    let of_group = members * MEMBER + springs * SPRING + triangles * TRIANGLE + pairs * PAIR;
    let ns = TICK + sum * (BODY + laws * LAW) + own.sum::<f64>() * most * LAW + most * of_group;
    ns * 1e-9
}

/// Approximate seconds that a tick of the reference of `scene` takes.
pub(crate) fn reference_tick_seconds(scene: &Scene) -> f64 {
    let substeps = reference_substeps(scene);
    let mut reference = Scene { method: REFERENCE_METHOD, substeps, ..scene.clone() };
    for body in &mut reference.bodies {
        (body.method, body.substeps) = (None, None);
    }
    tick_seconds(&reference)
}
