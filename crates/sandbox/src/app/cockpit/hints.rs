//! The line at the bottom: what the mouse does now.

use egui::{RichText, Ui};

use crate::view::stage::{Mode, Stage};

pub(super) fn show(ui: &mut Ui, stage: &Stage) {
    ui.label(RichText::new(words(stage)).weak());
}

fn words(stage: &Stage) -> String {
    let view = &stage.view;
    let pushes = |push: &str| {
        let (force, notch) = (view.click_force, view.push.per_notch);
        format!("{push} pushes {force} N; the wheel changes that by {notch} N.")
    };
    let selected = stage.seen.selection.filter(|_| stage.sim.scene.push.is_some());
    match (view.mode, selected) {
        (Mode::Camera, None) => {
            "The mouse looks around; W A S D fly, Space and Shift rise and sink. Q frees the pointer.".to_owned()
        }
        (Mode::Camera, Some(_)) => format!("{} Q frees the pointer.", pushes("Right click at the selection")),
        (Mode::Selection, None) => {
            "Left click selects. Right drag orbits, middle drag pans, the wheel zooms. F frames the scene, Q flies."
                .to_owned()
        }
        (Mode::Selection, Some(thing)) => format!(
            "{} {} Right drag beside it orbits. F frames it, Escape lets it go.",
            stage.name(thing),
            pushes("is selected: right click on it")
        ),
    }
}
