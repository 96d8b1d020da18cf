//! The film of a run: an animated PNG, or a GIF if its file name ends so.

use std::fs::File;
use std::ops::RangeInclusive;
use std::path::Path;

use render::{Film, Gif, Image};

use crate::failure::Failure;
use crate::output::files::{Output, OutputPath, folder_of, output_file};
use cockpit::app::pictures::with_settings;
use cockpit::stage::Stage;

/// Default frames per second of a GIF: with more, browsers show it slower.
pub(super) const GIF_FPS: f64 = 25.0;

/// Whether the film is a GIF.
pub(super) fn is_gif(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("gif"))
}

/// How long a picture of the film can be shown, s.
pub(super) fn frame_seconds_range(path: &Path) -> RangeInclusive<f64> {
    let [shortest, longest] = if is_gif(path) { Gif::LENGTHS_S } else { Film::LENGTHS_S };
    shortest..=longest
}

/// A film that is being written.
pub(super) enum FilmFile {
    /// Kept in a file without a name until it is finished, so that nothing is left of it however the run ends.
    Png(Film<File>, Output),
    Gif(Gif<Output>),
}

impl FilmFile {
    /// Begins a film of pictures of that size.
    pub fn begin(path: &OutputPath, size_px: [u32; 2]) -> Result<Self, Failure> {
        let file = output_file(path)?;
        if is_gif(path.as_ref()) {
            let film = Gif::new(file, size_px)
                .map_err(|error| Failure::file("write", path.as_ref(), &error))?;
            return Ok(Self::Gif(film));
        }
        let folder = if file.is_device_or_pipe() {
            std::env::temp_dir()
        } else {
            folder_of(path.as_ref()).to_owned()
        };
        let spool = tempfile::tempfile_in(&folder)
            .map_err(|error| Failure::file("write into", &folder, &error))?;
        Ok(Self::Png(Film::new(spool), file))
    }

    /// Adds a picture that begins `at_s` seconds after the start.
    pub fn add(&mut self, image: Image, at_s: f64) -> std::io::Result<()> {
        match self {
            Self::Png(film, _) => film.add(image, at_s),
            Self::Gif(film) => film.add(image, at_s),
        }
    }

    /// Writes the rest of it.
    pub fn finish(self, stage: &Stage) -> std::io::Result<()> {
        match self {
            Self::Png(film, mut file) => {
                with_settings(stage, |text| film.finish(&mut file, text))?;
                file.finish()
            }
            Self::Gif(film) => film.finish()?.finish(),
        }
    }
}
