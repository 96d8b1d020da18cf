//! Find a scene by a part of its name, or open a file by its path.

use std::path::{Path, PathBuf};

use egui::{Align2, Key, RichText, TextEdit, Ui};

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
        let query = self.query.to_lowercase();
        if let Some(path) = your_files(ui, &desk.stage.run.files, query.trim()) {
            desk.edits.push(Edit::Open(path));
            desk.closes = true;
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

/// Lists scene files with `query` in their paths, the newest first, by their names; the one that is clicked.
pub(crate) fn your_files(ui: &mut Ui, files: &[PathBuf], query: &str) -> Option<String> {
    let paths = files.iter().rev().map(|path| path.display().to_string());
    let paths: Vec<_> = paths.filter(|path| path.to_lowercase().contains(query)).collect();
    if !paths.is_empty() {
        ui.add_space(6.0);
        ui.label(RichText::new("Your files").strong());
    }
    paths.into_iter().fold(None, |clicked, path| {
        let name = Path::new(&path).file_name().and_then(|name| name.to_str()).unwrap_or(&path);
        if ui.button(name).on_hover_text(&path).clicked() { Some(path) } else { clicked }
    })
}
