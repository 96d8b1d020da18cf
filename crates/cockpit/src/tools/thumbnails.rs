//! Pictures of the shipped scenes, by their groups.

use std::io::Cursor;

use egui::{ColorImage, Context, TextureHandle, TextureOptions, Vec2};

/// Makes the groups: titles, scenes and their pictures, PNG files that `tests/pixels.rs` draws. They are reduced to 128 colors, a
/// third of the bytes that a page has to load: `mogrify -dither None -colors 128 -define png:format=png8 *.png`.
macro_rules! groups {
    ($($title:literal: $($name:literal)*;)*) => {
        &[$(($title, &[$(
            ($name, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/thumbnails/", $name, ".png"))),
        )*])),*]
    };
}

/// Title, and scenes with their pictures.
pub(crate) type Group = (&'static str, &'static [(&'static str, &'static [u8])]);

/// The groups. Scenes that are in no group are listed under the last one.
pub(crate) const GROUPS: &[Group] = groups! {
    "The tutorial": "tutorial" "tutorial_large" "frame_step" "empty";
    "Methods": "orbits_race" "orbit" "solar" "figure_eight" "comets" "oscillator" "ship" "ship_between" "verlet_start";
    "Forces": "projectile" "coast" "terminal_speed" "feather" "first_law" "third_law" "wall" "everything";
    "Springs and soft bodies": "rope" "bridge" "resonance" "flag" "bungee" "cape" "jelly" "meadow" "shaken_cloth";
    "Particles": "thousand" "fountain" "sparks" "dust_trail" "galaxies" "storm" "shower";
    "Hard cases": "stiff_spring";
};

/// Size of a picture on the screen, points.
pub(crate) const PICTURE: Vec2 = Vec2::new(160.0, 90.0);

/// The pictures that were loaded so far, by the names of their scenes.
#[derive(Default)]
pub(crate) struct Thumbnails(Vec<(String, Option<TextureHandle>)>);

impl Thumbnails {
    /// The picture of a scene, if it has one.
    pub fn of(&mut self, context: &Context, scene: &str) -> Option<TextureHandle> {
        if let Some((_, picture)) = self.0.iter().find(|(other, _)| other == scene) {
            return picture.clone();
        }
        let mut all = GROUPS.iter().flat_map(|(_, scenes)| scenes.iter());
        let png = all.find(|(name, _)| *name == scene).map(|(_, png)| *png);
        let image = png.and_then(|bytes| render::Image::decode_png(Cursor::new(bytes)).ok());
        let picture = image.map(|image| {
            let size = image.size_px.map(|side| side as usize);
            let image = ColorImage::from_rgba_unmultiplied(size, &image.rgba);
            context.load_texture(scene, image, TextureOptions::LINEAR)
        });
        self.0.push((scene.to_owned(), picture.clone()));
        picture
    }
}
