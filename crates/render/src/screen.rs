//! All that draws into a window or a page.

use wgpu::{Instance, SurfaceTarget};

use crate::{Frame, Gpu, Offscreen, Quality, RenderError, Renderer, WindowTarget};

/// A device, the swap chain of a window or a page, and the renderer.
pub struct Screen {
    /// The device.
    pub gpu: Gpu,
    /// The swap chain.
    pub target: WindowTarget,
    renderer: Renderer,
}

impl Screen {
    /// Opens a device to draw into `window`, of `size_px`. See [`Gpu::for_window`].
    pub async fn open(
        instance: Instance,
        window: impl Into<SurfaceTarget<'static>>,
        size_px: [u32; 2],
    ) -> Result<Self, RenderError> {
        let (gpu, surface) = Gpu::for_window(instance, window).await?;
        let target = WindowTarget::new(surface, &gpu, size_px)?;
        let renderer = Renderer::new(&gpu, target.format(), Quality::for_adapter(&gpu.info));
        Ok(Self { gpu, target, renderer })
    }

    /// Takes over what was sent only once to a screen whose device is lost.
    pub fn replace(&mut self, lost: Self) {
        self.renderer.replace(&self.gpu, lost.renderer);
    }

    /// Draws a picture, and calls `before_present` just before it is shown. Returns `false` if there is nothing to draw on: the
    /// window is not seen, or its [surface is lost](WindowTarget::lost).
    pub fn draw(
        &mut self,
        picture: impl FnOnce() -> Frame,
        before_present: impl FnOnce(),
    ) -> Result<bool, RenderError> {
        self.gpu.check()?;
        let Some(target) = self.target.acquire(&self.gpu) else { return Ok(false) };
        let mut frame = picture();
        frame.size_px = target.size_px();
        self.renderer.draw(&self.gpu, &frame, target.view());
        before_present();
        target.present(&self.gpu);
        Ok(true)
    }

    /// Draws a picture that can be read, with the bytes that the window shows.
    pub fn copy(&mut self, frame: &Frame) -> Result<Offscreen, RenderError> {
        let copy = Offscreen::with_format(&self.gpu, frame.size_px, self.target.format())?;
        self.renderer.draw(&self.gpu, frame, copy.view());
        Ok(copy)
    }
}
