//! The particles on the graphics device, as the layer of a frame.

use std::sync::Arc;

use scene::{Appearance, FileIndex, PointRadius};
use swarm::{DrawnSwarm, Swarm, SwarmLayer, SwarmLog, SwarmLook};

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
