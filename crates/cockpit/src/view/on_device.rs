//! Converts swarms of the simulation to the plain numbers of a frame.

use motion::{DampingModel, Method, Swarm, SwarmLog, SwarmTick};
use render::{SwarmDamping, SwarmLook, SwarmStepping};
use scene::{Appearance, FileIndex, PointRadius};

use crate::stage::Stage;
use crate::stage::query;
use crate::view::View;

/// Exposure time of the particles of emitters, s: a particle is drawn as long as its path in that time.
pub(super) const EXPOSURE_S: f64 = 1.0 / 60.0;

/// Last fraction of its life in which a particle of an emitter fades away.
pub(super) const FADES_IN: f64 = 0.3;

impl View {
    /// Adds the swarms of the scene.
    pub(super) fn add_swarms(&self, stage: &Stage, frame: &mut render::Frame) {
        let back = 1.0 - stage.here().alpha;
        frame.swarms =
            swarms(stage, |anchor| (anchor - self.camera.position).as_vec3().to_array(), back);
    }
}

/// The swarms of a run, in the order of the scene, without a camera.
pub fn all_swarms(stage: &Stage) -> Vec<render::Swarm> {
    swarms(stage, |_| [0.0; 3], 0.0)
}

fn swarms(stage: &Stage, seen: impl Fn(glam::DVec3) -> [f32; 3], back: f64) -> Vec<render::Swarm> {
    let mut found: Vec<_> = query::<
        (&FileIndex, &Swarm, &SwarmLog, Option<&Appearance>, Option<&PointRadius>),
        (),
    >(&stage.sim().world)
    .iter(&stage.sim().world)
    .map(|(FileIndex(index), swarm, log, look, radius)| {
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
        let ticks = log.ticks.iter().map(tick).collect();
        let (stepping, launches) = (stepping(swarm.method), swarm.launches.clone());
        let goes_back = stage.recorder().is_on();
        (*index, render::Swarm { stepping, launches, ticks, goes_back, look })
    })
    .collect();
    found.sort_by_key(|(index, _)| *index);
    found.into_iter().map(|(_, swarm)| swarm).collect()
}

/// How the device steps by a method of [`Swarm::METHODS`].
pub fn stepping(method: Method) -> SwarmStepping {
    match method {
        Method::SemiImplicitEuler => SwarmStepping::SemiImplicitEuler,
        Method::VelocityVerlet => SwarmStepping::VelocityVerlet,
        Method::PositionVerlet => SwarmStepping::PositionVerlet,
        Method::ExplicitEuler
        | Method::ImplicitEuler
        | Method::RungeKutta2Midpoint
        | Method::RungeKutta2Heun
        | Method::RungeKutta4
        | Method::Yoshida4 => {
            unreachable!("the first tick refuses what is not among `Swarm::METHODS`")
        }
    }
}

fn tick(tick: &SwarmTick) -> render::SwarmTick {
    let SwarmTick {
        key, step, substeps, births, born, first_birth, between, source, carried, ..
    } = *tick;
    let SwarmTick { dead, other_laws, reversed, phase, ref laws, .. } = *tick;
    let motion::SwarmLaws { constant, rate, drag, wells, damping } = &**laws;
    let air = drag.unwrap_or_default();
    let model = |model: DampingModel| match model {
        DampingModel::Tutorial => Some(SwarmDamping::Tutorial),
        DampingModel::Clamped => Some(SwarmDamping::Clamped),
        DampingModel::Implicit => Some(SwarmDamping::Implicit),
        // Exact damping is part of `rate`.
        DampingModel::Exact => None,
    };
    let laws = render::SwarmLaws {
        constant: *constant,
        rate: *rate,
        drag: drag.map(|drag| [drag.linear, drag.quadratic]),
        air: [air.mean, air.across, air.up],
        wave: air.wave,
        turns: air.turns,
        wells: wells.clone(),
        damping: damping.and_then(|(which, rate)| Some((model(which)?, rate))),
    };
    render::SwarmTick {
        key,
        step,
        substeps,
        births,
        born,
        first_birth,
        between,
        source,
        carried,
        dead,
        other_laws,
        reversed,
        phase,
        laws,
    }
}
