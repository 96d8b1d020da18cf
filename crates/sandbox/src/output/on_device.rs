//! Swarms without a window: their device, and their part of the summary of a run.

use render::{Gpu, RenderError, Swarm, SwarmParticle, SwarmTick, Swarms};
use report::numbers::long_duration;
use scene::Scene;
use serde_json::{Value, json};
use xxhash_rust::xxh3::Xxh3;

use crate::failure::Failure;
use crate::output::pictures::{Camera, headless};
use cockpit::stage::Stage;
use cockpit::view::on_device::all_swarms;

/// The device of a run that draws no pictures.
pub(crate) struct SwarmDevice {
    pub gpu: Gpu,
    swarms: Swarms,
}

impl SwarmDevice {
    /// Opens a device for the swarms of `scene`.
    pub fn open(scene: &Scene) -> Result<Self, Failure> {
        let gpu = headless()?;
        check(&gpu, scene)?;
        Ok(Self { swarms: Swarms::new(&gpu), gpu })
    }
}

/// Whether a scene has swarms.
pub(crate) fn has_swarms(scene: &Scene) -> bool {
    scene.swarms().next().is_some()
}

/// Checks that the adapter can hold the swarms of `scene`.
pub(crate) fn check(gpu: &Gpu, scene: &Scene) -> Result<(), Failure> {
    for (i, _, swarm) in scene.swarms() {
        let checked = gpu.check_swarm(swarm.launches.len() as u64);
        checked.map_err(|error| {
            let what = format!("{}: emitters[{i}].on: {error}", scene.name);
            match error {
                RenderError::Swarm { .. } => Failure::Usage(what),
                _ => Failure::NoAdapter(what),
            }
        })?;
    }
    Ok(())
}

/// Estimated time per particle of a picture that is drawn in software, s: measured by `--bench frames` on two cores.
const DRAWN_IN_SOFTWARE_S: f64 = 0.8e-6;

/// Time of a picture of particles above which it is announced, s.
const SLOW_S: f64 = 0.1;

/// A warning, with a cure, if pictures of the swarms of `scene` take long because they are drawn in software.
pub(crate) fn slow_words(gpu: &Gpu, scene: &Scene) -> Option<String> {
    let particles = scene.swarm_particles();
    #[expect(clippy::cast_precision_loss, reason = "millions of particles")]
    let seconds = particles as f64 * DRAWN_IN_SOFTWARE_S;
    let [all, tenth] = [seconds, seconds / 10.0].map(long_duration);
    (gpu.info.software && seconds > SLOW_S).then(|| {
        format!(
            "{}: this machine draws in software, and a picture of {particles} particles takes about {all}; with a tenth of \
             `rate_per_s` and `capacity` it takes {tenth}",
            scene.name
        )
    })
}

/// Refuses rows of particles that are on a device.
pub(crate) fn refuse_rows(scene: &Scene) -> Result<(), Failure> {
    scene.swarms().next().map_or(Ok(()), |(i, ..)| {
        let what = "its particles are on the graphics device and have no rows for --state";
        let cure = "give on: cpu, or leave --state out";
        Err(Failure::Usage(format!("{}: emitters[{i}]: {what}; {cure}", scene.name)))
    })
}

/// The swarms of `stage` in the summary of a run, read from the device of the camera or from their own.
///
/// # Errors
/// If they cannot be read back.
pub(crate) fn summary(
    stage: &Stage,
    camera: Option<&mut Camera>,
    device: Option<&mut SwarmDevice>,
) -> Result<Value, Failure> {
    let swarms = all_swarms(stage);
    let (gpu, states) = match (camera, device) {
        (Some(camera), _) => camera.follow(&swarms),
        (None, Some(device)) => {
            device.swarms.follow(&device.gpu, &swarms);
            (&device.gpu, Some(&device.swarms))
        }
        (None, None) => return Ok(Value::Null),
    };
    let Some(states) = states else { return Ok(Value::Null) };
    let mut all = Vec::new();
    for ((index, swarm), (_, emitter, spec)) in
        swarms.iter().enumerate().zip(stage.sim().scene.swarms())
    {
        let State { living, failed, hash } = State::of(swarm, &states.read(gpu, index)?);
        let particles = swarm.launches.len() as u64;
        all.push(json!({
            "emitter": emitter.name,
            "adapter": gpu.info.to_string(),
            "method": spec.method.name(),
            "particles": particles,
            "living": living,
            "failed": failed,
            "bytes": Swarms::bytes(particles),
            "state_hash": format!("{hash:016x}"),
        }));
    }
    Ok(Value::Array(all))
}

/// The state of a swarm: counts and a hash.
struct State {
    living: u64,
    /// Particles that would live if their state had not become infinite.
    failed: u64,
    hash: u64,
}

impl State {
    fn of(swarm: &Swarm, stored: &[Option<SwarmParticle>]) -> Self {
        let (mut living, mut failed, mut hash) = (0, 0, Xxh3::new());
        for (expected, stored) in expected(swarm).into_iter().zip(stored) {
            let Some(number) = expected else { continue };
            match stored {
                Some(SwarmParticle { generation, position, other })
                    if *generation == number / swarm.launches.len() as u64 =>
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
fn expected(swarm: &Swarm) -> Vec<Option<u64>> {
    let slots = swarm.launches.len() as u64;
    let mut living = vec![None; swarm.launches.len()];
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
