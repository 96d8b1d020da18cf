//! Pictures of sessions as files.

use render::{Gpu, Image, Kept, Layer, Offscreen, Quality, Renderer};

use crate::failure::Failure;
use crate::output::files::{OutputPath, write};
use cockpit::app::pictures::png;
use cockpit::app::session::Session;
use cockpit::stage::Stage;

/// Draws pictures without a window.
pub(crate) struct Camera {
    pub gpu: Gpu,
    renderer: Renderer,
    target: Offscreen,
}

impl Camera {
    pub fn new(size: [u32; 2], quality: Quality) -> Result<Self, Failure> {
        let gpu = headless()?;
        let renderer = Renderer::new(&gpu, render::OFFSCREEN_FORMAT, quality);
        let target = Offscreen::new(&gpu, size)?;
        Ok(Self { gpu, renderer, target })
    }

    /// Prepares `layer`, and returns the device and what the layer keeps there.
    pub fn prepare(&mut self, layer: &dyn Layer) -> (&Gpu, &Kept) {
        (&self.gpu, self.renderer.prepare(&self.gpu, layer))
    }

    /// Draws a picture.
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

    /// The picture that was drawn last.
    pub fn read(&self) -> Result<Image, Failure> {
        self.gpu.check()?;
        Ok(self.target.read(&self.gpu)?)
    }
}

/// Address space that opening a device in software takes at most, bytes: with less, Mesa's shader compiler crashes.
const ADDRESS_SPACE: u64 = 640 << 20;

/// A device that draws without a window.
pub(crate) fn headless() -> Result<Gpu, Failure> {
    if let Some(left) = scene::address_space().filter(|left| *left < ADDRESS_SPACE) {
        let [takes, left] = [ADDRESS_SPACE, left].map(scene::byte_words);
        let what = "drawing pictures takes about";
        return Err(Failure::NoAdapter(format!(
            "{what} {takes} of address space, and {left} are left; raise `ulimit -v`, or draw none"
        )));
    }
    Ok(Gpu::headless()?)
}

/// Writes a picture with the settings that made it.
pub(crate) fn write_picture(
    image: &Image,
    path: &OutputPath,
    stage: &Stage,
) -> Result<(), Failure> {
    write(path, &png(image, stage))
}
