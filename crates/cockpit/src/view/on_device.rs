//! The particles on the graphics device, as the layer of a frame.

use std::sync::Arc;

use render::Gpu;
use report::numbers::long_duration;
use scene::{Appearance, FileIndex, PointRadius, Scene};
use swarm::{DrawnSwarm, Swarm, SwarmError, SwarmLayer, SwarmLog, SwarmLook, Swarms};

use crate::stage::Stage;
use crate::view::View;

/// Exposure time of the particles of emitters, s: a particle is drawn as long as its path in that time.
pub(super) const EXPOSURE_S: f64 = 1.0 / 60.0;

/// Last fraction of its life in which a particle of an emitter fades away.
pub(super) const FADES_IN: f64 = 0.3;

impl View {
    /// Adds the particles on the graphics device.
    pub(super) fn add_particles_on_device(&self, stage: &Stage, frame: &mut render::Frame) {
        let back = 1.0 - stage.here().alpha;
        let seen = |anchor: glam::DVec3| (anchor - self.camera.position).as_vec3().to_array();
        let swarms = drawn(stage, seen, back);
        if !swarms.is_empty() {
            frame.layer = Some(Arc::new(SwarmLayer(swarms)));
        }
    }
}

/// The swarms of a run, in the order of the scene, without a camera.
pub fn swarms(stage: &Stage) -> Vec<DrawnSwarm> {
    drawn(stage, |_| [0.0; 3], 0.0)
}

fn drawn(stage: &Stage, seen: impl Fn(glam::DVec3) -> [f32; 3], back: f64) -> Vec<DrawnSwarm> {
    let world = &stage.sim().world;
    let swarms = world
        .try_query::<(&FileIndex, &Swarm, &SwarmLog, Option<&Appearance>, Option<&PointRadius>)>();
    // A world that never had one does not know the component.
    let Some(mut swarms) = swarms else { return Vec::new() };
    let drawn = swarms.iter(world).map(|(FileIndex(index), swarm, log, look, radius)| {
        let [r, g, b] = look.map_or([1.0; 3], |look| look.color);
        #[expect(clippy::cast_possible_truncation, reason = "pixels are f32")]
        let look = SwarmLook {
            anchor: seen(swarm.anchor),
            radius_m: radius.copied().unwrap_or_default().0,
            color: [r, g, b, 1.0],
            back: back as f32,
            exposure_s: EXPOSURE_S as f32,
            life_s: stage.sim().scene.emitters[*index as usize].life as f32,
            fades_in: FADES_IN as f32,
        };
        let (ticks, goes_back) = (log.ticks.iter().cloned().collect(), stage.recorder().is_on());
        (*index, DrawnSwarm { swarm: swarm.clone(), ticks, goes_back, look })
    });
    let mut found: Vec<_> = drawn.collect();
    found.sort_by_key(|(index, _)| *index);
    found.into_iter().map(|(_, swarm)| swarm).collect()
}

/// Checks that the adapter can hold the particles of `scene`.
///
/// # Errors
/// If it cannot, with the words for a person.
pub fn check(gpu: &Gpu, scene: &Scene) -> Result<(), (SwarmError, String)> {
    scene.on_device().try_for_each(|(i, emitter)| {
        Swarms::check(gpu, emitter.particles_on_device() as u64).map_err(|error| {
            let what = format!("{}: emitters[{i}].on: {error}", scene.name);
            (error, what)
        })
    })
}

/// What a person is told of a scene on an adapter that cannot hold its particles, or is slow to draw them.
#[must_use]
pub fn words(gpu: &Gpu, scene: &Scene) -> Option<String> {
    let missing = check(gpu, scene).err().map(|(_, what)| what);
    missing.or_else(|| slow_words(gpu, scene))
}

/// Estimated time per particle of a picture that is drawn in software, s: measured by `--bench frames` on two cores.
const DRAWN_IN_SOFTWARE_S: f64 = 0.8e-6;

/// Time of a picture of particles above which it is announced, s.
const SLOW_S: f64 = 0.1;

/// A warning, with a cure, if pictures of the particles of `scene` take long because they are drawn in software.
#[must_use]
pub fn slow_words(gpu: &Gpu, scene: &Scene) -> Option<String> {
    let particles = scene.particles_on_device();
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
