//! The bar that appears when the selection, or everything that moves, has left the view.

use bevy_ecs::prelude::*;
use egui::{Rect, Ui};
use motion::Gravity;

use crate::actions::Act;
use crate::app::cockpit::bar;
use crate::app::focus::frame_if_lesson_names;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::stage::things::is_movable;
use crate::view::View;
use crate::view::camera::Camera;

/// Lays out the bar at the bottom of what is `free` of the view, if what a person may look for has left it.
pub(super) fn show(
    root: &Ui,
    free: &mut Rect,
    stage: &Stage,
    view: &View,
    seen: &mut Seen,
    intents: &mut Vec<Intent>,
) {
    let Some(words) = words(stage, view, seen) else { return };
    // Otherwise everything falls again.
    let falls = stage.sim().world.get_resource::<Gravity>().is_some_and(|gravity| gravity.on)
        && view.all_fell_through(stage);
    bar(root, "away", free, |ui| {
        ui.label(words);
        offer(ui, intents, "Reset", Act::ResetWorld);
        offer(ui, intents, "First view", Act::ResetCamera);
        let follow = ui.button("Follow");
        frame_if_lesson_names(ui, "Follow", &follow);
        let what = "the camera goes with the selection or the first body (L)";
        if follow.on_hover_text(what).clicked() {
            if stage.selection().is_none() {
                intents.push(Intent::Act(Act::NextBody));
            }
            intents.push(Intent::Act(Act::LockCamera));
        }
        if falls {
            offer(ui, intents, "Gravity off", Act::ToggleGravity);
        }
    });
}

/// Lays out a button for an action.
fn offer(ui: &mut Ui, intents: &mut Vec<Intent>, words: &str, act: Act) {
    if ui.button(words).on_hover_text(act.binding().tooltip()).clicked() {
        intents.push(Intent::Act(act));
    }
}

/// The selection and the camera when the selection was last in the view.
pub(super) type Seen = Option<(Entity, Camera)>;

fn words(stage: &Stage, view: &View, seen: &mut Seen) -> Option<String> {
    if view.locked.is_some() {
        return None;
    }
    let is_seen = |thing| Some(view.sees(stage.drawn_position(thing)?));
    let selected = stage.selection().filter(|thing| is_movable(&stage.sim().world, *thing));
    let here = selected.map(|thing| (thing, view.camera));
    let is_seen = selected.and_then(is_seen);
    if is_seen == Some(true) {
        *seen = here;
    }
    match here {
        _ if view.has_lost_all(stage) => Some(match view.all_fell_through(stage) {
            true => "Nothing collides here: everything fell through the floor.".to_owned(),
            false => "Everything that moves has left the view.".to_owned(),
        }),
        // It went, and not the camera.
        Some((thing, _)) if is_seen == Some(false) && *seen == here => {
            Some(format!("{} has left the view.", stage.name(thing)))
        }
        _ => None,
    }
}
