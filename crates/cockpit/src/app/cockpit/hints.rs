//! The line at the bottom: what the mouse does now and, if there is room, the size and the speed of the run.

use egui::{Align, Label, Layout, RichText, Role, Ui, WidgetInfo};
use report::numbers::{digits, duration};

use crate::app::cockpit::toolbar;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::stage::things::is_movable;
use crate::tools::editor::Editor;
use crate::view::hud::bodies;
use crate::view::{Mode, View};

/// Lays out the line.
pub(super) fn show(
    ui: &mut Ui,
    stage: &Stage,
    view: &View,
    editor: &Editor,
    intents: &mut Vec<Intent>,
) {
    let words = match &editor.spring_ends {
        Some(ends) if ends.is_empty() => "Click the first body that the spring joins.".to_owned(),
        Some(ends) => format!("Click the body that the spring joins to {}.", ends[0]),
        None if editor.has_handles && stage.selection().is_some() => {
            words(stage, view) + " Its arrows move it."
        }
        None => words(stage, view),
    };
    let (words, state) = (RichText::new(words).weak(), RichText::new(state(stage, view)).weak());
    ui.horizontal(|ui| {
        let width = |text: &RichText| {
            let text = egui::WidgetText::from(text.clone());
            text.into_galley(
                ui,
                Some(egui::TextWrapMode::Extend),
                f32::INFINITY,
                egui::TextStyle::Body,
            )
            .size()
            .x
        };
        let needed = width(&words) + width(&state) + 24.0;
        // For those who have no wheel.
        if stage.selection().is_some_and(|thing| is_movable(&stage.sim().world, thing))
            && stage.sim().scene.push.is_some()
        {
            let mut turn = |ui: &mut Ui, icon, name, notches| {
                let button = ui.button(icon).on_hover_text(name);
                button.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
                if button.clicked() {
                    intents.push(Intent::TurnForce(notches));
                }
            };
            turn(ui, "-", "Less force", -1.0);
            ui.label(format!("{} N", digits(view.click_force)));
            turn(ui, "+", "More force", 1.0);
        }
        let has_room = needed <= ui.available_width();
        ui.add(Label::new(words).truncate());
        if has_room {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.label(state));
        }
    });
}

/// The number of bodies, the tick rate and, unless the run is paused, the measured speed.
fn state(stage: &Stage, view: &View) -> String {
    let measured =
        view.measured.filter(|_| !stage.playback().paused()).map_or(String::new(), |measured| {
            let tick = duration(1e9 * measured.tick, 3);
            format!("   tick {tick}   {:.0} frames/s", measured.frames_per_second)
        });
    format!("{}   {}{measured}", bodies(stage), toolbar::rate(stage))
}

fn words(stage: &Stage, view: &View) -> String {
    let click = || {
        let (verb, force) = if view.click_force < 0.0 {
            ("pulls", -view.click_force)
        } else {
            ("pushes", view.click_force)
        };
        let force = digits(force);
        let notch = digits(stage.sim().scene.push_spec().per_notch);
        format!("a right click {verb} it with {force} N, the wheel changes that by {notch} N")
    };
    let pushes = stage.sim().scene.push.is_some();
    match (view.mode, stage.selection()) {
        (Mode::Camera, selected) => {
            let aim = selected.filter(|_| pushes).map_or(String::new(), |_| format!(" At the selection, {}.", click()));
            format!("The mouse looks around; W A S D fly, Space and Shift rise and sink. Q frees the pointer.{aim}")
        }
        // Short enough for a phone, beside the buttons of the force.
        (Mode::Selection, None) if view.by_finger => {
            "Tap selects, drag pulls; two fingers orbit, zoom, pan.".to_owned()
        }
        (Mode::Selection, Some(thing)) if view.by_finger => {
            let words = match is_movable(&stage.sim().world, thing) {
                true if pushes => "Drag pulls; hold to push.",
                true => "Drag pulls.",
                false => "Forces do not move this.",
            };
            words.to_owned()
        }
        (Mode::Selection, None) => {
            "Click a body to select it, drag it to pull it. Right drag orbits, middle drag pans, the wheel zooms. F frames the scene.".to_owned()
        }
        (Mode::Selection, Some(thing)) if !is_movable(&stage.sim().world, thing) => {
            format!(
                "{}: forces do not move it. Right drag orbits, middle drag pans, the wheel zooms. F frames it. A click beside a body deselects.",
                stage.name(thing)
            )
        }
        (Mode::Selection, Some(thing)) if pushes => {
            format!("{}: drag pulls it, {}. F frames it. A click beside it deselects.", stage.name(thing), click())
        }
        (Mode::Selection, Some(thing)) => {
            format!("{}: drag pulls it, the wheel zooms. F frames it. A click beside it deselects.", stage.name(thing))
        }
    }
}
