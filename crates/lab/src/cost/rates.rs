//! Compares one simulated second at several frame rates.

use glam::DVec3;
use motion::{Damping, DampingModel, Method, Request, TimeStep, Transform};

use super::record::{RateRow, Setting};
use super::subject::Subject;
use crate::run::movable;

/// Frame rates, frames per second.
const RATES: [f64; 5] = [15.0, 30.0, 60.0, 144.0, 240.0];

/// Substeps of the run that the others are compared with.
const FINER: u32 = 100;

/// The frame rate at which a force for one frame equals the impulse.
const EVEN: f64 = 60.0;

/// Whether frame rates are compared for a subject: it runs for a second, in ticks that are not longer than frames.
pub(crate) fn are_compared(subject: &Subject) -> bool {
    subject.seconds() >= 1.0 && subject.scene.step_hz >= RATES[0]
}

/// Simulated seconds that [`rates`] takes: per frame rate two kinds of step and two of push, with each model of
/// damping.
pub(crate) fn seconds(subject: &Subject) -> usize {
    RATES.len() * 4 * models(subject).len()
}

fn models(subject: &Subject) -> Vec<Option<DampingModel>> {
    match subject.scene.damping {
        Some(_) => vec![Some(DampingModel::Tutorial), Some(DampingModel::Exact)],
        None => vec![None],
    }
}

/// Simulates a second of `subject` by its own method for every combination of frame rate, ticks (as long as frames,
/// or as the scene's own), model of damping (if the scene has damping) and push of the first body (a force for one
/// tick, or an impulse).
pub(crate) fn rates(subject: &Subject) -> Vec<RateRow> {
    let Some((body, spec)) = movable(&subject.scene).next() else { return Vec::new() };
    let newtons = subject.scene.push.map_or(10.0, |push| push.start);
    // Position of the body at the end, m; `None` if it was quarantined.
    let pushed = |model: Option<DampingModel>, setting: Setting, tick_hz: f64, push: &str| {
        let mut subject = subject.clone();
        subject.scene.damping =
            subject.scene.damping.zip(model).map(|(damping, model)| Damping { model, ..damping });
        let mut run = subject.run(setting);
        let body = run.body(body)?;
        match push {
            "force" => run.push(body, DVec3::X * newtons),
            _ => run.request(Request::Impulse(body, DVec3::X * (newtons / EVEN))),
        }
        run.world.insert_resource(TimeStep(1.0 / tick_hz));
        run.run(ticks(tick_hz));
        let sound = run.failure().is_none();
        run.world.get::<Transform>(body).filter(|_| sound).map(|end| end.position)
    };
    let mut rows = Vec::new();
    for model in models(subject) {
        let fine = Setting { method: Method::RungeKutta4, substeps: FINER.into() };
        let exact = model.map(|_| DampingModel::Exact);
        let fine_end = pushed(exact, fine, subject.scene.step_hz, "impulse");
        for frame_hz in RATES {
            for (step, tick_hz) in [("frame", frame_hz), ("fixed", subject.scene.step_hz)] {
                for push in ["force", "impulse"] {
                    let end = pushed(model, subject.own(), tick_hz, push);
                    let distance = |from: Option<DVec3>| {
                        let distance = from?.distance(end?);
                        distance.is_finite().then_some(distance)
                    };
                    rows.push(RateRow {
                        frame_hz,
                        step: step.to_owned(),
                        damping: model.map_or("none", DampingModel::name).to_owned(),
                        push: push.to_owned(),
                        ticks: ticks(tick_hz),
                        moved_m: distance(Some(spec.position)),
                        off_m: distance(fine_end),
                    });
                }
            }
        }
    }
    rows
}

/// Number of ticks in a second.
fn ticks(tick_hz: f64) -> u64 {
    tick_hz.round() as u64
}
