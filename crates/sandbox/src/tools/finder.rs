//! Find a scene by a part of its name.

use egui::{Align2, Key, TextEdit};

use crate::app::panels::Edit;

/// What was typed so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Finder {
    query: String,
}

impl Finder {
    /// Shows the finder; `false` when it is done.
    pub fn show(&mut self, context: &egui::Context, edits: &mut Vec<Edit>) -> bool {
        let mut open = true;
        egui::Window::new("Find scene")
            .resizable(false)
            .collapsible(false)
            .anchor(Align2::CENTER_TOP, [0.0, 80.0])
            .show(context, |ui| {
                let field = ui.add(
                    TextEdit::singleline(&mut self.query)
                        .hint_text("part of a name")
                        .desired_width(f32::INFINITY),
                );
                // Focus needs a frame, and Enter gives it up. Asking for what is there would ask for another frame.
                if !field.has_focus() {
                    field.request_focus();
                }
                let enter = ui.input(|input| input.key_pressed(Key::Enter));
                let found = scene::find(&self.query);
                if found.is_empty() {
                    ui.weak("no scene has this in its name");
                }
                for (row, scene) in found.into_iter().enumerate() {
                    let chosen = ui.selectable_label(row == 0, scene.name).clicked();
                    if open && (chosen || (enter && row == 0)) {
                        edits.push(Edit::Open(scene.name.to_owned()));
                        open = false;
                    }
                }
            });
        open
    }
}
