//! Find a scene by a part of its name, or open a file by its path.

use std::path::{Path, PathBuf};

use egui::{Align2, Button, Key, RichText, TextEdit, Ui};

use crate::intent::Intent;
use crate::stage::Stage;
use crate::tools::tool::{Anchor, Desk, Tool};

/// The state of the finder: the text typed so far.
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

    fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let field = TextEdit::singleline(&mut self.query);
        let field = ui.add(
            field.hint_text("part of a name, or the path of a file").desired_width(f32::INFINITY),
        );
        // Getting the focus takes a frame, and Enter drops it. A request while the field has it would cause another frame.
        if !field.has_focus() {
            field.request_focus();
        }
        let enter = ui.input(|input| input.key_pressed(Key::Enter));
        let is_path = self.query.contains(['.', '/', '\\']);
        let query = self.query.to_lowercase();
        let (files, scenes) =
            (your_files(desk.stage.files.all(), query.trim()), scene::find(&self.query));
        if files.is_empty() && scenes.is_empty() && !is_path {
            ui.weak("no scene has this in its name");
        }
        // Enter takes the first row; without a query that is the first scene, and the person's files are only listed.
        let first_is_file = !files.is_empty() && !query.trim().is_empty();
        let chosen = if is_path && (ui.button("Open this file").clicked() || enter) {
            Some(self.query.clone())
        } else {
            let file = list_files(ui, &files, first_is_file.then_some(0));
            let file = file.or_else(|| files.first().filter(|_| enter && first_is_file).cloned());
            if !files.is_empty() {
                ui.strong("Scenes of the program");
            }
            scenes.into_iter().enumerate().fold(file, |chosen, (row, scene)| {
                let is_first = row == 0 && !first_is_file;
                let clicked = ui.selectable_label(is_first, scene.name).clicked();
                chosen.or_else(|| (clicked || (enter && is_first)).then(|| scene.name.to_owned()))
            })
        };
        if let Some(chosen) = chosen {
            desk.intents.push(Intent::Open(chosen));
            desk.closes = true;
        }
    }
}

/// The scene files with `query` in their paths, the newest first.
pub(crate) fn your_files(files: &[PathBuf], query: &str) -> Vec<String> {
    let paths = files.iter().rev().map(|path| path.display().to_string());
    paths.filter(|path| path.to_lowercase().contains(query)).collect()
}

/// Lists scene files by their names and marks number `marked`. Returns the clicked one.
pub(crate) fn list_files(ui: &mut Ui, paths: &[String], marked: Option<usize>) -> Option<String> {
    if !paths.is_empty() {
        ui.add_space(6.0);
        ui.label(RichText::new("Your files").strong());
    }
    let name_of =
        |path: &str| Path::new(path).file_name().and_then(|name| name.to_str().map(str::to_owned));
    paths.iter().enumerate().fold(None, |clicked, (row, path)| {
        let name = name_of(path).unwrap_or_else(|| path.clone());
        // Files of the same name show their folders.
        let several =
            paths.iter().filter(|other| name_of(other).as_ref() == Some(&name)).count() > 1;
        let folder = Path::new(path).parent().and_then(|folder| name_of(&folder.to_string_lossy()));
        let name = match folder.filter(|_| several) {
            Some(folder) => format!("{folder}/{name}"),
            None => name,
        };
        let button = Button::new(name).selected(marked == Some(row));
        if ui.add(button).on_hover_text(path).clicked() { Some(path.clone()) } else { clicked }
    })
}
