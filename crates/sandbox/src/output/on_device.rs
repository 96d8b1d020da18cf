//! Particles on the graphics device without a window: their device, and their part of the summary of a run.

use cockpit::stage::Stage;
use cockpit::view::on_device::{self, swarms};
use render::Gpu;
use scene::{BodySpec, Scene};
use serde_json::{Value, json};
use swarm::{DrawnSwarm, SwarmError, SwarmLayer, SwarmParticle, SwarmTick, Swarms};
use xxhash_rust::xxh3::Xxh3;

use crate::failure::Failure;
use crate::output::pictures::{Camera, headless};
use crate::output::report::Summary;
use crate::output::tell;

/// The device of a run that draws no pictures.
pub(crate) struct Device {
    pub gpu: Gpu,
    swarms: Swarms,
}

impl Device {
    /// Opens a device for the particles of `scene`.
    pub fn open(scene: &Scene) -> Result<Self, Failure> {
        let gpu = headless()?;
        check(&gpu, scene)?;
        Ok(Self { swarms: Swarms::new(&gpu), gpu })
    }
}

/// Whether a scene has particles on the graphics device.
pub(crate) fn has_particles(scene: &Scene) -> bool {
    scene.on_device().next().is_some()
}

/// Checks that the adapter can hold the particles of `scene`.
pub(crate) fn check(gpu: &Gpu, scene: &Scene) -> Result<(), Failure> {
    on_device::check(gpu, scene).map_err(|(error, what)| match error {
        SwarmError::TooLarge { .. } => Failure::Usage(what),
        SwarmError::NoCompute { .. } => Failure::NoAdapter(what),
    })
}

/// Refuses rows of particles that are on a device.
pub(crate) fn refuse_rows(scene: &Scene) -> Result<(), Failure> {
    scene.on_device().next().map_or(Ok(()), |(i, _)| {
        let what = "its particles are on the graphics device and have no rows for --state";
        let cure = "give on: cpu, or leave --state out";
        Err(Failure::Usage(format!("{}: emitters[{i}]: {what}; {cure}", scene.name)))
    })
}

/// Refuses a scene in which nothing moves but particles on the graphics device: no study covers these.
pub(crate) fn refuse_alone(scene: &Scene) -> Result<(), Failure> {
    if has_particles(scene) && !scene.bodies.iter().any(BodySpec::is_movable) {
        let what = "particles on the graphics device are in no study, and no body of it can move; give on: cpu";
        return Err(Failure::Usage(format!("{}: {what}", scene.name)));
    }
    Ok(())
}

/// Adds the particles of `stage` to the summary of a run, read from the device of the camera or from their own. Returns how
/// many have failed.
pub(crate) fn add_to(
    summary: &mut Summary,
    stage: &Stage,
    camera: Option<&mut Camera>,
    device: Option<&mut Device>,
) -> u64 {
    if !has_particles(&stage.sim().scene) {
        return 0;
    }
    let layer = SwarmLayer(swarms(stage));
    let (gpu, device) = match (camera, device) {
        (Some(camera), _) => {
            let (gpu, kept) = camera.prepare(&layer);
            (Some(gpu), SwarmLayer::swarms(kept))
        }
        (None, Some(Device { gpu, swarms })) => {
            swarms.follow(gpu, &layer.0);
            (Some(&*gpu), Some(&*swarms))
        }
        (None, None) => (None, None),
    };
    let states = gpu.zip(device).map(|(gpu, device)| states(stage, &layer.0, gpu, device));
    let (states, failed) =
        states.unwrap_or_else(|| Ok(Default::default())).unwrap_or_else(|failure| {
            tell(&format!("the summary has no swarms: {failure}"));
            Default::default()
        });
    summary.add("swarms", states);
    failed
}

/// The states of `drawn`, the swarms of `stage`, on the device, and how many particles have failed.
///
/// # Errors
/// If they cannot be read back.
fn states(
    stage: &Stage,
    drawn: &[DrawnSwarm],
    gpu: &Gpu,
    device: &Swarms,
) -> Result<(Value, u64), Failure> {
    let (mut all, mut all_failed) = (Vec::new(), 0);
    for ((index, drawn), (_, emitter)) in
        drawn.iter().enumerate().zip(stage.sim().scene.on_device())
    {
        let State { living, failed, hash } = State::of(drawn, &device.read(gpu, index)?);
        all_failed += failed;
        all.push(json!({
            "emitter": emitter.name,
            "adapter": gpu.info.to_string(),
            "method": drawn.swarm.method.name(),
            "particles": drawn.swarm.slots(),
            "living": living,
            "failed": failed,
            "bytes": drawn.swarm.bytes(),
            "state_hash": format!("{hash:016x}"),
        }));
    }
    Ok((Value::Array(all), all_failed))
}

/// The state of a swarm: counts and a hash.
struct State {
    living: u64,
    /// Particles that would live if their state had not become infinite.
    failed: u64,
    hash: u64,
}

impl State {
    fn of(swarm: &DrawnSwarm, stored: &[Option<SwarmParticle>]) -> Self {
        let (mut living, mut failed, mut hash) = (0, 0, Xxh3::new());
        for (expected, stored) in expected(swarm).into_iter().zip(stored) {
            let Some(number) = expected else { continue };
            match stored {
                Some(SwarmParticle { generation, position, other })
                    if *generation == number / swarm.swarm.slots() =>
                {
                    living += 1;
                    // `other` is the last position or the velocity, depending on the method.
                    for part in position.iter().chain(other) {
                        hash.update(&part.to_bits().to_le_bytes());
                    }
                }
                _ => failed += 1,
            }
        }
        Self { living, failed, hash: hash.digest() }
    }
}

/// The number of the particle that each slot holds after the last tick, unless its state became infinite; `None` for a slot
/// without a living particle.
fn expected(swarm: &DrawnSwarm) -> Vec<Option<u64>> {
    let slots = swarm.swarm.slots();
    let mut living = vec![None; swarm.swarm.launches.len()];
    let dead = swarm.ticks.last().map_or(0, |tick| tick.dead);
    for SwarmTick { births: [first, after], born, .. } in &swarm.ticks {
        // Particles that are due free their slots even if they are not `born`.
        for number in (*first).max(dead)..*after {
            #[expect(clippy::cast_possible_truncation, reason = "below the length of a list")]
            let slot = (number % slots) as usize;
            living[slot] = born.then_some(number);
        }
    }
    living
}
