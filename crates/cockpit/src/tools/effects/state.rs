//! Effects of a running session: what switched them, and the receipt.

use history::{RunSettings, Timeline};
use lab::{ReceiptLine, ReceiptRun};
use motion::PreviousPosition;
use motion::effects::EffectState;
use scene::Scene;

use crate::stage::Stage;
use crate::stage::notices::Topic;
use crate::stage::query;
use crate::view::View;

/// Why a run is recorded.
const RECORDED: &str = "going back: the window, --black-box";

/// Name of the row of the energy watch.
pub const ENERGY_WATCH: &str = "energy_watch";

/// Time of a frame in which the panel measures, s.
const WORK_OF_FRAME_S: f64 = 0.02;

/// Ticks that the panel measures: an answer in a fraction of a second for a scene of some hundred bodies.
const MEASURED_TICKS: u64 = 60;

/// Bodies up to which the panel measures: more take minutes.
const MEASURED_BODIES: usize = 5_000;

/// The state behind the receipt of a scene.
#[derive(Default)]
pub struct Effects {
    /// Tick and counts of the last look.
    pub(super) seen: (u64, Vec<(&'static str, u64)>),
    /// Evaluations per step between the last two looks.
    rates: Vec<(&'static str, f64)>,
    /// What is being measured on a copy of the scene.
    run: Option<ReceiptRun>,
    /// Nanoseconds per step and share by name, as measured.
    measured: Vec<(&'static str, Option<f64>, Option<f64>)>,
}

impl Effects {
    /// The receipt of the stage as it is: which effects are on, why, on how many bodies; evaluations per step are counted since
    /// the last look, and times are from the last measurement.
    pub fn receipt(&mut self, stage: &Stage, view: &View) -> Vec<ReceiptLine> {
        self.look_at_rates(stage);
        let mut rows = lab::receipt_without_running(stage.sim());
        rows.extend(picture_rows(stage, view));
        for row in &mut rows {
            if let Some(by) = row.effect.and_then(|effect| stage.switched_by(effect)) {
                row.because = Some(by.words().to_owned());
            }
            if let Some((_, rate)) = self.rates.iter().find(|(law, _)| *law == row.name) {
                row.evaluations = *rate;
            }
            if let Some((_, ns, share)) = self.measured.iter().find(|(name, ..)| *name == row.name)
            {
                (row.ns, row.share) = (*ns, *share);
            }
        }
        rows
    }

    /// Begins to measure on a copy of the scene, from its start, what each effect costs per step.
    pub(super) fn measure(&mut self, stage: &mut Stage) {
        let scene = &stage.sim().scene;
        if scene.bodies.len() > MEASURED_BODIES {
            stage.notices.say(
                Topic::Other,
                format!("too many bodies to wait for: run `sandbox effects {}`", scene.name),
            );
            return;
        }
        // An effect that is off at the start may have been switched on since.
        let scene = Scene { off_at_start: Vec::new(), ..Scene::clone(scene) };
        let off = RunSettings::of(stage.sim()).effects.off;
        self.run = Some(ReceiptRun::new(&scene, MEASURED_TICKS, &off));
    }

    /// Whether effects are being measured.
    pub(super) const fn measures(&self) -> bool {
        self.run.is_some()
    }

    /// Measures for a part of a frame.
    pub(super) fn continue_measuring(&mut self, stage: &Stage) {
        let Some(run) = self.run.take_if(|run| run.work(WORK_OF_FRAME_S)) else { return };
        let receipt = run.receipt();
        let watch = lab::watch_time(&stage.sim().scene);
        let rows = receipt.rows.iter().map(|row| (row.name, row.ns, row.share));
        self.measured =
            rows.chain([(ENERGY_WATCH, Some(watch), Some(watch / receipt.ns))]).collect();
    }

    #[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
    fn look_at_rates(&mut self, stage: &Stage) {
        let now = stage.sim().ticks();
        let (then, before) = &self.seen;
        if now <= *then {
            return;
        }
        let counts = stage.sim().evaluations().laws().to_vec();
        let ticks = (now - then) as f64;
        let was = |law| before.iter().find(|(name, _)| *name == law).map_or(0, |(_, count)| *count);
        self.rates = counts
            .iter()
            .map(|(law, count)| (*law, count.saturating_sub(was(*law)) as f64 / ticks))
            .collect();
        self.seen = (now, counts);
    }
}

/// The rows of what a stage with pictures does beside the step.
pub fn picture_rows(stage: &Stage, view: &View) -> [ReceiptLine; 7] {
    let row = |name, on: bool, bodies, bytes, why: &str| ReceiptLine {
        because: on.then(|| why.to_owned()),
        bodies: if on { bodies } else { 0 },
        bytes: if on { bytes } else { 0 },
        ..ReceiptLine::of(name, if on { EffectState::On } else { EffectState::Off })
    };
    let drawn_between =
        query::<&PreviousPosition, ()>(&stage.sim().world).iter(&stage.sim().world).count();
    let (shapes, picked) = view.targets();
    let movable = stage.sim().bodies_per_method().into_iter().map(|(_, bodies)| bodies).sum();
    let arrows = view.velocity_arrows || view.force_arrows;
    let timeline = stage.recorder().timeline().map_or(0, Timeline::bytes);
    let shadows = stage.sim().scene.light.is_some_and(|light| light.shadows);
    let options = stage.options();
    [
        row(
            "interpolation",
            options.interpolate,
            drawn_between,
            drawn_between * size_of::<PreviousPosition>(),
            "pictures between two ticks",
        ),
        row("picking", shapes > 0, shapes, picked, "pictures and the pointer"),
        match shadows {
            true => row("shadows", options.pictures, shapes, 0, "the light"),
            false => ReceiptLine::of("shadows", EffectState::NotDeclared),
        },
        row("arrows", arrows, movable, 0, "keys 1 and 2"),
        row("timeline", stage.recorder().is_on(), 0, timeline, RECORDED),
        on_device(stage),
        row(ENERGY_WATCH, stage.recorder().is_on(), movable, history::Watch::bytes(), RECORDED),
    ]
}

/// The row of the particles on the graphics device.
fn on_device(stage: &Stage) -> ReceiptLine {
    let scene = &stage.sim().scene;
    let Some((first, _)) = scene.on_device().next() else {
        return ReceiptLine::of("swarms", EffectState::NotDeclared);
    };
    let (mut dispatches, mut bytes) = (0, 0);
    for swarm in scene.emitters.iter().filter_map(|emitter| emitter.on_device.as_ref()) {
        dispatches += swarm.substeps.unwrap_or_else(|| stage.sim().substeps().least());
        bytes += swarm.bytes();
    }
    let s = if dispatches == 1 { "" } else { "es" };
    ReceiptLine {
        because: Some(format!("emitters[{first}].on: gpu; {dispatches} dispatch{s} per tick")),
        bodies: scene.particles_on_device(),
        #[expect(clippy::cast_possible_truncation, reason = "what a device has fits into memory")]
        bytes: bytes as usize,
        ..ReceiptLine::of("swarms", EffectState::On)
    }
}
