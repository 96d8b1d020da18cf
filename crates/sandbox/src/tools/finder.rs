//! Find a scene by a part of its name, or open a file by its path.

use egui::{Align2, Key, TextEdit, Ui};

use crate::tools::tool::{Anchor, Desk, Edit, Tool};
use crate::view::stage::Stage;

/// What was typed so far.
#[derive(Default)]
pub(crate) struct Finder {
    query: String,
}

impl Tool for Finder {
    fn toggle(&mut self, _: &mut Stage, open: bool) -> bool {
        self.query.clear();
        !open
    }

    fn anchor(&self, _: &[&str]) -> Anchor {
        (Align2::CENTER_TOP, [0.0, 80.0])
    }

    fn docks(&self) -> bool {
        false
    }

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let field = TextEdit::singleline(&mut self.query);
        let field =
            ui.add(field.hint_text("part of a name, or the path of a file").desired_width(f32::INFINITY));
        // Focus needs a frame, and Enter gives it up. Asking for what is there would ask for another frame.
        if !field.has_focus() {
            field.request_focus();
        }
        let enter = ui.input(|input| input.key_pressed(Key::Enter));
        let is_path = self.query.contains(['.', '/', '\\']);
        let found = scene::find(&self.query);
        if is_path && (ui.button("Open this file").clicked() || enter) {
            desk.edits.push(Edit::Open(self.query.clone()));
            desk.closes = true;
        } else if found.is_empty() && !is_path {
            ui.weak("no scene has this in its name");
        }
        for (row, scene) in found.into_iter().enumerate() {
            let clicked = ui.selectable_label(row == 0, scene.name).clicked();
            if !desk.closes && (clicked || (enter && row == 0)) {
                desk.edits.push(Edit::Open(scene.name.to_owned()));
                desk.closes = true;
            }
        }
    }
}
