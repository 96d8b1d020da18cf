//! The panel of the timeline: seeks anywhere in the last minute, and says what went wrong.

use egui::{Align2, Color32, Pos2, Rect, Sense, Slider, Stroke, Ui, Vec2};

use crate::intent::Intent;
use crate::stage::Stage;
use crate::stage::quarantines::QuarantinedBody;
use crate::stage::timeline::Within;
use crate::tools::number::read_number;
use crate::tools::tool::{Anchor, Desk, Tool};
use crate::view::hud::mouse_hint;
use crate::view::inks;
use crate::view::marks::FAULT;

/// Going back in the last minute; the recording is the stage's.
#[derive(Default)]
pub(crate) struct Timeline;

/// Greatest number of quarantined bodies that are listed.
const LISTED: usize = 6;

const WIDTH: f32 = 460.0;
const MARKS_HEIGHT: f32 = 14.0;
const KEYFRAME: Color32 = Color32::from_gray(110);
const NOW: Color32 = Color32::from_rgb(120, 190, 255);

impl Tool for Timeline {
    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::RIGHT_BOTTOM, [-8.0, -48.0])
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let width = desk.width(WIDTH);
        ui.set_width(width);
        mouse_hint(ui, desk.view);
        match &desk.stage.recorder().within(desk.stage.sim()) {
            Some(within) => scrubber(ui, within, desk.stage, width, desk.intents),
            None => drop(ui.label("No timeline: too many bodies, or this run is not recorded.")),
        }
        quarantined(ui, desk.stage);
    }
}

#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "ticks below 2^53, bytes for people"
)]
fn scrubber(ui: &mut Ui, within: &Within, stage: &Stage, width: f32, intents: &mut Vec<Intent>) {
    let (mut tick, times) = (within.at, &within.times);
    let (first, last) = (*within.range.start(), *within.range.end());
    ui.spacing_mut().slider_width = width - 90.0;
    // A range of one tick would put the handle into the middle.
    let slider = Slider::new(&mut tick, first..=last.max(first + 1))
        .custom_formatter(|tick, _| times.words(tick as u64))
        .custom_parser(|text| {
            // egui reads the shown text even if nothing was typed.
            let is_typed = text != times.words(within.at);
            let seconds = || read_number(text.trim().trim_end_matches('s'));
            Some(if is_typed { times.tick(seconds()?) } else { within.at } as f64)
        });
    if ui.add(slider).changed() && tick != within.at {
        intents.push(Intent::Seek(tick));
    }
    marks(ui, within, width);
    ui.horizontal(|ui| {
        let before = within.at.saturating_sub(1).max(first);
        for (text, what, to) in [
            ("|<", "the oldest tick that is kept", first),
            ("<", "one tick back (,)", before),
            (">|", "the newest tick", last),
        ] {
            let button = ui.add_enabled(within.at != to, egui::Button::new(text));
            if button.on_hover_text(what).clicked() {
                intents.push(Intent::Seek(to));
            }
        }
        if let Some(good) = stage.recorder().last_good()
            && ui.button("Last good tick").clicked()
        {
            intents.push(Intent::Seek(good));
        }
        if ui
            .button("Save bundle")
            .on_hover_text("one file that `sandbox replay` runs again")
            .clicked()
        {
            intents.push(Intent::SaveBundle);
        }
    });
    if let Some(fault) = &within.fault {
        let color = inks::words(ui.visuals(), FAULT);
        ui.colored_label(color, format!("at {}: {}", times.words(fault.tick), fault.what));
    }
    if within.left > 0 {
        ui.label(format!("Seeking: {} ticks left to simulate again", within.left));
    } else if within.at < *within.range.end() {
        ui.label(match within.repeats {
            true => "Continuing from here repeats what came after; any change drops it.",
            false => "Continuing from here drops what came after.",
        });
    } else if stage.playback().paused() {
        ui.label("The present, paused.");
    }
    let mebibytes = |bytes: usize| bytes as f64 / f64::from(1 << 20);
    ui.weak(format!(
        "The last minute: {} to {}, in {:.2} of {:.0} MiB",
        times.words(first),
        times.words(last),
        mebibytes(within.bytes),
        mebibytes(within.cap)
    ));
}

/// Lists the bodies that were quarantined, when, by which system and why.
fn quarantined(ui: &mut Ui, stage: &Stage) {
    let (bodies, times) = (stage.quarantines().here(), stage.times());
    for QuarantinedBody { body, tick, what, system, cause, .. } in bodies.iter().take(LISTED) {
        ui.separator();
        let at = times.words(*tick);
        ui.label(format!("{body}: quarantined at {at} by {system}, cause {cause}"));
        ui.weak(what);
    }
    if bodies.len() > LISTED {
        ui.weak(format!("and {} more", bodies.len() - LISTED));
    }
}

/// Marks the snapshots, the present and the fault along the slider.
#[expect(clippy::cast_precision_loss, reason = "ticks of a minute, pixels")]
fn marks(ui: &mut Ui, within: &Within, width: f32) {
    let (rect, _) = ui.allocate_exact_size(Vec2::new(width - 90.0, MARKS_HEIGHT), Sense::hover());
    let (first, last) = (*within.range.start(), *within.range.end());
    let length = (last - first).max(1) as f32;
    let x = |tick: u64| {
        rect.left() + rect.width() * (tick.saturating_sub(first) as f32 / length).min(1.0)
    };
    let line = |tick: u64, color: Color32, width: f32| {
        let ends = [Pos2::new(x(tick), rect.top()), Pos2::new(x(tick), rect.bottom())];
        ui.painter().line_segment(ends, Stroke::new(width, inks::marks(ui.visuals(), color)));
    };
    let axis = Rect::from_min_max(rect.left_center(), rect.right_center());
    let gray = inks::marks(ui.visuals(), KEYFRAME);
    ui.painter().line_segment([axis.min, axis.max], Stroke::new(1.0, gray));
    within.keyframes.iter().for_each(|tick| line(*tick, KEYFRAME, 1.0));
    line(within.at, NOW, 2.0);
    if let Some(fault) = &within.fault {
        line(fault.tick, FAULT, 2.0);
    }
}
