//! The scene browser at the left: every scene by its picture, in groups, and a search.

use std::io::Cursor;
use std::path::PathBuf;
use std::sync::LazyLock;

use egui::{
    Button, ColorImage, Image, Response, RichText, ScrollArea, Sense, TextEdit, TextureHandle,
    TextureOptions, Ui, Vec2,
};

use crate::app::focus::reveal_focus;
use crate::intent::Intent;
use crate::tools::finder::{list_files, your_files};

/// Makes the groups: titles, scenes and their pictures, PNG files that `tests/pixels.rs` draws.
macro_rules! groups {
    ($($title:literal: $($name:literal)*;)*) => {
        &[$(($title, &[$(
            ($name, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/thumbnails/", $name, ".png"))),
        )*])),*]
    };
}

type Group = (&'static str, &'static [(&'static str, &'static [u8])]);

/// Words by which the search finds all scenes of a group, beside its title.
const ALSO_FOUND_BY: [(&str, &str); 3] = [
    ("Methods", "accuracy error energy conserved order"),
    ("Springs and soft bodies", "cloth jelly elastic energy stiffness"),
    ("Particles", "emitters"),
];

/// The groups. Scenes that are in no group are listed under the last one.
const GROUPS: &[Group] = groups! {
    "The tutorial": "tutorial" "tutorial_large" "frame_step" "empty";
    "Methods": "orbits_race" "orbit" "solar" "figure_eight" "oscillator" "ship" "ship_between" "verlet_start";
    "Forces": "projectile" "coast" "terminal_speed" "feather" "first_law" "third_law" "wall" "everything";
    "Springs and soft bodies": "rope" "bridge" "flag" "bungee" "cape" "jelly" "meadow";
    "Particles": "thousand" "fountain" "sparks" "dust_trail" "galaxies" "storm" "shower";
    "Hard cases":;
};

/// Size of a picture on the screen, points.
const PICTURE: Vec2 = Vec2::new(160.0, 90.0);

/// Title and scenes of every group.
static SCENES: LazyLock<Vec<(&str, Vec<Entry>)>> = LazyLock::new(|| {
    let entry = |title: &str, name: &'static str, png| {
        let scene = scene::embedded(name)?.load().ok()?;
        let of_group = |(group, _): &(&str, &str)| *group == title;
        let group =
            ALSO_FOUND_BY.iter().find(|group| of_group(group)).map_or("", |(_, words)| words);
        let found_by =
            format!("{} {name} {} {title} {group}", name.replace('_', " "), scene.description);
        Some(Entry { name, about: scene.description, found_by: found_by.to_lowercase(), png })
    };
    let grouped = |name: &str| {
        GROUPS.iter().any(|(_, scenes)| scenes.iter().any(|(other, _)| *other == name))
    };
    let of = |(title, scenes): &Group| {
        let scenes = scenes.iter().filter_map(|(name, png)| entry(title, name, Some(*png)));
        (*title, scenes.collect::<Vec<_>>())
    };
    let mut groups: Vec<_> = GROUPS.iter().map(of).collect();
    let rest = scene::shipped().iter().chain(scene::cases()).filter(|scene| !grouped(scene.name));
    if let Some((title, last)) = groups.last_mut() {
        last.extend(rest.filter_map(|scene| entry(title, scene.name, None)));
    }
    groups
});

/// A scene in the browser.
struct Entry {
    name: &'static str,
    about: String,
    /// The text that the search matches, in lower case.
    found_by: String,
    png: Option<&'static [u8]>,
}

/// The text of the search, and the pictures that were loaded so far.
#[derive(Default)]
pub(super) struct Browser {
    query: String,
    pictures: Vec<(&'static str, Option<TextureHandle>)>,
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
            if let Some(path) = list_files(ui, &your_files(files, query.trim()), None) {
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
                        let picture = self.picture(ui, entry).map(|texture| {
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

    /// The picture of a scene, if it has one.
    fn picture(&mut self, ui: &Ui, Entry { name, png, .. }: &Entry) -> Option<TextureHandle> {
        if let Some((_, picture)) = self.pictures.iter().find(|(other, _)| other == name) {
            return picture.clone();
        }
        let image = png.and_then(|bytes| render::Image::decode_png(Cursor::new(bytes)).ok());
        let picture = image.map(|image| {
            let size = image.size_px.map(|side| side as usize);
            let image = ColorImage::from_rgba_unmultiplied(size, &image.rgba);
            ui.ctx().load_texture(*name, image, TextureOptions::LINEAR)
        });
        self.pictures.push((*name, picture.clone()));
        picture
    }
}
