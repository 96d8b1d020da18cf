//! The bar that appears when the selection, or everything that moves, has left the view.

use egui::{Rect, Ui};

use crate::actions::Act;
use crate::app::cockpit::bar;
use crate::app::focus::frame_if_lesson_names;
use crate::intent::Intent;
use crate::stage::Stage;
use crate::stage::things::is_movable;
use crate::view::View;

/// Lays out the bar at the bottom of what is `free` of the view, if what a person may look for has left it.
pub(super) fn show(
    root: &Ui,
    free: &mut Rect,
    stage: &Stage,
    view: &View,
    intents: &mut Vec<Intent>,
) {
    let Some(words) = words(stage, view) else { return };
    bar(root, "away", free, |ui| {
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
}

fn words(stage: &Stage, view: &View) -> Option<String> {
    if view.locked.is_some() {
        return None;
    }
    let thrown = stage.selection().filter(|thing| {
        let is_seen = |place| view.seen_at(place).is_some_and(|(_, inside)| inside);
        is_movable(&stage.sim().world, *thing)
            && stage.drawn_position(*thing).is_some_and(|place| !is_seen(place))
    });
    match thrown {
        _ if view.has_lost_all(stage) => Some(match view.all_fell_through(stage) {
            true => "Nothing collides here: everything fell through the floor.".to_owned(),
            false => "Everything that moves has left the view.".to_owned(),
        }),
        Some(thing) => Some(format!("{} has left the view.", stage.name(thing))),
        None => None,
    }
}
