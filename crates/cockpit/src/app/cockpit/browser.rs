//! The scene browser at the left: every scene by its picture, in groups, and a search.

use std::path::PathBuf;
use std::sync::LazyLock;

use egui::{Button, Image, Response, RichText, ScrollArea, Sense, TextEdit, Ui};

use crate::app::focus::reveal_focus;
use crate::intent::Intent;
use crate::tools::finder::{list_files, your_files};
use crate::tools::thumbnails::{GROUPS, Group, PICTURE, Thumbnails};

/// Words by which the search finds all scenes of a group, beside its title.
const ALSO_FOUND_BY: [(&str, &str); 3] = [
    ("Methods", "accuracy error energy conserved order"),
    ("Springs and soft bodies", "cloth jelly elastic energy stiffness"),
    ("Particles", "emitters"),
];

/// Title and scenes of every group.
static SCENES: LazyLock<Vec<(&str, Vec<Entry>)>> = LazyLock::new(|| {
    let entry = |title: &str, name: &'static str| {
        let scene = scene::embedded(name)?.load().ok()?;
        let of_group = |(group, _): &(&str, &str)| *group == title;
        let group =
            ALSO_FOUND_BY.iter().find(|group| of_group(group)).map_or("", |(_, words)| words);
        let found_by =
            format!("{} {name} {} {title} {group}", name.replace('_', " "), scene.description);
        Some(Entry { name, about: scene.description, found_by: found_by.to_lowercase() })
    };
    let grouped = |name: &str| {
        GROUPS.iter().any(|(_, scenes)| scenes.iter().any(|(other, _)| *other == name))
    };
    let of = |(title, scenes): &Group| {
        let scenes = scenes.iter().filter_map(|(name, _)| entry(title, name));
        (*title, scenes.collect::<Vec<_>>())
    };
    let mut groups: Vec<_> = GROUPS.iter().map(of).collect();
    let rest = scene::shipped().iter().chain(scene::cases()).filter(|scene| !grouped(scene.name));
    if let Some((title, last)) = groups.last_mut() {
        last.extend(rest.filter_map(|scene| entry(title, scene.name)));
    }
    groups
});

/// A scene in the browser.
struct Entry {
    name: &'static str,
    about: String,
    /// The text that the search matches, in lower case.
    found_by: String,
}

/// The text of the search, and the pictures that were loaded so far.
#[derive(Default)]
pub(super) struct Browser {
    query: String,
    pictures: Thumbnails,
}

impl Browser {
    /// Lays out the search and the scenes. Returns the search field.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        (present, files): (&str, &[PathBuf]),
        intents: &mut Vec<Intent>,
    ) -> Response {
        ui.add_space(4.0);
        let search =
            TextEdit::singleline(&mut self.query).hint_text("Search").desired_width(f32::INFINITY);
        let search = ui.add(search);
        let query = self.query.to_lowercase();
        let fits = |entry: &&Entry| entry.found_by.contains(query.trim());
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let files = your_files(files, query.trim());
            let here = files.iter().position(|path| path == present);
            if let Some(path) = list_files(ui, &files, here) {
                intents.push(Intent::Open(path));
            }
            for (title, entries) in SCENES.iter() {
                let entries: Vec<_> = entries.iter().filter(fits).collect();
                if entries.is_empty() {
                    continue;
                }
                ui.add_space(6.0);
                ui.label(RichText::new(*title).strong());
                for entry in entries {
                    let words = RichText::new(entry.name.replace('_', " "));
                    let here = entry.name == present;
                    let row = ui.vertical_centered(|ui| {
                        let picture = self.pictures.of(ui.ctx(), entry.name).map(|texture| {
                            let image = Image::from_texture((texture.id(), PICTURE));
                            // Without focus: the keyboard goes from name to name.
                            ui.add(Button::image(image).selected(here).sense(Sense::CLICK))
                        });
                        let name = ui.add(Button::selectable(here, words));
                        picture.map_or(name.clone(), |picture| picture.union(name))
                    });
                    if row.inner.on_hover_text(&entry.about).clicked() {
                        intents.push(Intent::Open(entry.name.to_owned()));
                    }
                }
            }
            if SCENES.iter().all(|(_, entries)| !entries.iter().any(|entry| fits(&entry))) {
                ui.weak("no scene has this in its name or description");
            }
            reveal_focus(ui);
        });
        search
    }
}
