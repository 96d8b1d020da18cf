//! The bar that appears when everything that moves has left the view.

use egui::{Panel as Side, Ui};

use crate::actions::Act;
use crate::app::focus::frame_if_lesson_names;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::view::View;

/// Lays out the bar at the bottom of `root`, if nothing that moves is in the view.
pub(super) fn show(root: &mut Ui, stage: &Stage, view: &View, intents: &mut Vec<Intent>) {
    let Some(words) = words(stage, view) else { return };
    Side::bottom("away").show(root, |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.label(words);
            if ui.button("Reset").on_hover_text(Act::ResetWorld.binding().tooltip()).clicked() {
                intents.push(Intent::Act(Act::ResetWorld));
            }
            let follow = ui.button("Follow");
            frame_if_lesson_names(ui, "Follow", &follow);
            let what = "the camera goes with the selection or the first body (L)";
            if follow.on_hover_text(what).clicked() {
                if stage.selection().is_none() {
                    intents.push(Intent::Act(Act::NextBody));
                }
                intents.push(Intent::Act(Act::LockCamera));
            }
        });
    });
}

fn words(stage: &Stage, view: &View) -> Option<&'static str> {
    if view.locked.is_some() || !view.has_lost_all(stage) {
        return None;
    }
    Some(match view.all_fell_through(stage) {
        true => "Nothing collides here: everything fell through the floor.",
        false => "Everything that moves has left the view.",
    })
}
