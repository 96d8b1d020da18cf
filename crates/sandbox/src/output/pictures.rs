//! Pictures of sessions as files.

use std::path::{Path, PathBuf};

use render::{Gpu, Image, Offscreen, Quality, Renderer};

use crate::app::bundle::PROGRAM;
use crate::app::session::Session;
use crate::failure::Failure;
use crate::output::files::{make_folder, write};
use crate::output::report;
use crate::stage::Stage;

/// Draws frames into files.
pub(crate) struct Camera {
    pub gpu: Gpu,
    renderer: Renderer,
    target: Offscreen,
    folder: PathBuf,
    pub pictures: u64,
}

impl Camera {
    pub fn new(size: [u32; 2], quality: Quality, folder: PathBuf) -> Result<Self, Failure> {
        let camera = Self::without_folder(size, quality)?;
        // Last, so that a run that cannot draw leaves no folder.
        make_folder(&folder)?;
        Ok(Self { folder, ..camera })
    }

    /// One that draws, and writes nothing.
    pub fn without_folder(size: [u32; 2], quality: Quality) -> Result<Self, Failure> {
        let gpu = Gpu::headless()?;
        let renderer = Renderer::new(&gpu, render::OFFSCREEN_FORMAT, quality);
        let target = Offscreen::new(&gpu, size)?;
        Ok(Self { gpu, renderer, target, folder: PathBuf::new(), pictures: 0 })
    }

    pub fn draw(&mut self, frame: &render::Frame) -> Result<(), Failure> {
        if self.target.size_px() != frame.size_px {
            self.target = Offscreen::new(&self.gpu, frame.size_px)?;
        }
        self.renderer.draw(&self.gpu, frame, self.target.view());
        Ok(())
    }

    /// The present picture of `session`.
    pub fn picture(&mut self, session: &mut Session) -> Result<Image, Failure> {
        self.draw(&session.picture())?;
        self.read()
    }

    /// What was drawn last.
    pub fn read(&self) -> Result<Image, Failure> {
        Ok(self.target.read(&self.gpu)?)
    }

    pub fn write(&mut self, name: &str, stage: &Stage) -> Result<(), Failure> {
        let image = self.read()?;
        let path = self.folder.join(name);
        write_picture(&image, &path, stage)?;
        self.pictures += 1;
        Ok(())
    }
}

/// Writes a picture with the settings that made it.
pub(crate) fn write_picture(image: &Image, path: &Path, stage: &Stage) -> Result<(), Failure> {
    write(path, &png(image, stage))
}

/// A picture as a PNG with the settings that made it.
pub(crate) fn png(image: &Image, stage: &Stage) -> Vec<u8> {
    let png = with_settings(stage, |text| image.png(text));
    png.expect("the keywords are those below, and memory takes every byte")
}

/// What `png` makes of the settings and the state of a stage, as keyword and value pairs.
pub(crate) fn with_settings<T>(stage: &Stage, png: impl FnOnce(&[(&str, &str)]) -> T) -> T {
    let text = [
        ("Software", PROGRAM.to_owned()),
        ("Scene", stage.scene().name.clone()),
        ("Tick", stage.ticks().to_string()),
        ("Method", stage.stepper().method().name().to_owned()),
        ("StateHash", format!("{:016x}", report::state_hash(stage))),
    ];
    let text: Vec<_> = text.iter().map(|(name, value)| (*name, value.as_str())).collect();
    png(&text)
}
